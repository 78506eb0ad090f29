import shutil

import numpy as np
import pytest

from andante.baselines import training_frames, training_recordings
from andante.errors import RecordingError
from andante.mapping import build_map
from andante.recordings import open_recording, write_recording


@pytest.fixture
def on_disk(make_drive, tmp_path, slowmap):
    """Two drives below a folder, and the map of both."""
    for seed in (1, 2):
        drive = make_drive(seed)
        write_recording(tmp_path / f"d{seed}", drive.frames(), name=drive.name, camera=drive.camera, image_format="png")
    recordings = [open_recording(tmp_path / name) for name in ("d1", "d2")]
    return build_map(recordings, slowmap.config), tmp_path


def test_recordings_are_found_where_the_map_found_them(on_disk):
    slowmap, folder = on_disk
    assert [recording.folder for recording in training_recordings(slowmap)] == [folder / "d1", folder / "d2"]


def test_moved_ones_can_be_given_in_any_order(on_disk):
    slowmap, folder = on_disk
    (folder / "d1").rename(folder / "moved")
    found = training_recordings(slowmap, [open_recording(folder / "moved")])
    assert [recording.folder.name for recording in found] == ["moved", "d2"]


def test_a_missing_one_is_named(on_disk):
    slowmap, folder = on_disk
    shutil.rmtree(folder / "d2")
    with pytest.raises(RecordingError, match=r"training recording 'drive 2' is needed.*cannot be opened.*--train"):
        training_recordings(slowmap)


def test_a_changed_one_is_refused(on_disk):
    slowmap, folder = on_disk
    table = folder / "d1" / "frames.csv"
    table.write_text(table.read_text().replace("0.5,", "0.25,", 1))
    with pytest.raises(RecordingError, match=r"'drive 1' .*has changed since the map was made.*--train"):
        training_recordings(slowmap)


def test_one_that_was_never_on_disk_has_to_be_given(slowmap, make_drive):
    with pytest.raises(RecordingError, match=r"'drive 2' is needed for baselines, but was not read from a folder"):
        training_recordings(slowmap, [make_drive(1)])


def test_a_foreign_one_is_refused(slowmap, make_drive):
    with pytest.raises(RecordingError, match=r"'drive 7' is not one that the map was learnt from.*drive 1, drive 2"):
        training_recordings(slowmap, [make_drive(7)])


def test_the_frames_are_those_of_the_map(make_drive, slowmap):
    drives = [make_drive(1, standing=(5,), unknown=(8, 9), blank=(20,)), make_drive(2)]
    other = build_map(drives, slowmap.config)
    seen = []
    frames = training_frames(other, drives, progress=lambda *step: seen.append(step))
    assert [int((frames.session == number).sum()) for number in (0, 1)] == [s.frames for s in other.sources] == [36, 40]
    np.testing.assert_allclose(frames.xy, other.readout.xy)
    assert seen[-1] == ("drive 2", 40, 40)
    expected = other.front_end.features(drives[0].load(drives[0].infos[10]))
    np.testing.assert_allclose(frames.features[7], expected, atol=1e-6)
