import shutil
from pathlib import Path

import numpy as np
import pytest

from andante.errors import RecordingError
from andante.protocols import Recording
from andante.recordings import open_folder, read_image
from andante.recordings.folder import FolderRecording

TOML = 'schema = 1\nname = "monday"\n[camera]\nmodel = "panorama"\n'


def test_reads_its_files(make_folder):
    recording = open_folder(str(make_folder(3)))
    assert isinstance(recording, Recording)
    assert isinstance(recording, FolderRecording)
    assert (recording.name, recording.camera.model, dict(recording.conditions)) == ("monday", "panorama", {})
    assert [info.image for info in recording.infos] == [f"images/00{index}.png" for index in range(3)]
    for frame in recording.frames(colour=True):
        np.testing.assert_array_equal(frame.image, read_image(recording.folder / frame.info.image, colour=True))


def test_table_is_read_once_and_late(make_folder):
    folder = make_folder(2, table="timestamp_s,image\n1,x\n0,y")
    recording = open_folder(folder)
    with pytest.raises(RecordingError, match=r"frames\.csv: times must increase, line 3"):
        _ = recording.infos
    good = open_folder(make_folder(2))
    infos = good.infos
    (good.folder / "frames.csv").unlink()
    assert good.infos is infos


@pytest.mark.parametrize("name", ["recording.toml", "frames.csv"])
def test_missing_files_are_named(make_folder, name):
    folder = make_folder()
    (folder / name).unlink()
    with pytest.raises(RecordingError, match=rf'{name} is missing; a recording is .* ask for format="images"'):
        open_folder(folder)


def test_missing_folder(tmp_path):
    with pytest.raises(RecordingError, match="nowhere does not exist or is no folder; check the path"):
        open_folder(tmp_path / "nowhere")


def test_missing_and_truncated_pictures_are_skipped(make_folder):
    folder = make_folder(40, suffix="jpg")
    (folder / "images/003.jpg").unlink()
    cut = folder / "images/030.jpg"
    cut.write_bytes(cut.read_bytes()[:-30])
    reasons = {}
    frames = list(open_folder(folder).frames(on_skip=lambda info, reason: reasons.update({info.index: reason})))
    assert len(frames) == 38
    assert "003.jpg does not exist" in reasons[3]
    assert "030.jpg: truncated or damaged" in reasons[30]


def test_links_out_of_the_recording_are_refused(make_folder, tmp_path):
    folder = make_folder(3)
    shutil.move(folder / "images/001.png", tmp_path / "elsewhere.png")
    (folder / "images/001.png").symlink_to(tmp_path / "elsewhere.png")
    recording = open_folder(folder)
    with pytest.raises(RecordingError, match=r"image images/001\.png is a link out of the folder"):
        list(recording.frames())
    with pytest.raises(RecordingError, match="is a link out of the folder"):
        recording.content_hash()


def test_a_folder_whose_name_begins_alike_is_still_outside(make_folder, tmp_path):
    folder = make_folder(2)
    beside = Path(str(folder) + "_beside")
    shutil.move(folder / "images", beside)
    (folder / "images").symlink_to(beside)
    with pytest.raises(RecordingError, match="is a link out of the folder"):
        list(open_folder(folder).frames())


def test_links_within_the_recording_and_to_it_are_fine(make_folder, tmp_path):
    folder = make_folder(3)
    (folder / "images").rename(folder / "pictures")
    (folder / "images").symlink_to("pictures")
    (tmp_path / "link").symlink_to(folder)
    assert len(list(open_folder(tmp_path / "link").frames())) == 3


def test_hash_follows_the_content_and_not_its_place(make_folder, tmp_path):
    folder = make_folder(3)
    original = open_folder(folder).content_hash()
    shutil.copytree(folder, tmp_path / "copy")
    copy = tmp_path / "copy"
    (copy / "recording.toml").write_text(TOML.replace("monday", "renamed"))
    assert open_folder(copy).content_hash() == original
    (copy / "images").rename(copy / "pictures")
    table = (copy / "frames.csv").read_text()
    (copy / "frames.csv").write_text(table.replace("images/", "pictures/").replace("0.5", "0.50"))
    assert open_folder(copy).content_hash() == original

    (copy / "frames.csv").write_text(table.replace("images/", "pictures/").replace("0.5", "0.25"))
    assert open_folder(copy).content_hash() != original
    (copy / "frames.csv").write_text(table.replace("images/", "pictures/"))
    shutil.copy(copy / "pictures/000.png", copy / "pictures/001.png")
    assert open_folder(copy).content_hash() != original


def test_hash_sees_a_missing_picture(make_folder):
    folder = make_folder(3)
    original = open_folder(folder).content_hash()
    (folder / "images/001.png").unlink()
    assert open_folder(folder).content_hash() not in ("", original)


@pytest.mark.parametrize(
    ("path", "count", "size", "model"),
    [
        ("garden_a/border_summer", 300, (480, 480), "fisheye"),
        ("garden_a/infield_summer", 500, (480, 480), "fisheye"),
        ("sussex_train", 455, (25, 120), "panorama"),
        ("sussex_binary", 136, (25, 120), "panorama"),
        ("nordland_summer", 2000, (32, 64), "perspective"),
        ("nordland_winter", 2000, (32, 64), "perspective"),
    ],
)
def test_real_recordings_open_and_iterate(shared_data, path, count, size, model):
    recording = open_folder(shared_data / path)
    assert (len(recording.infos), recording.camera.model) == (count, model)
    some = range(0, count, 10)
    frames = list(recording.frames(some))
    assert [frame.info.index for frame in frames] == list(some)
    assert {frame.image.shape for frame in frames} == {size}


def test_real_blank_cells(shared_data):
    infos = open_folder(shared_data / "sussex_binary").infos
    assert infos[0].reference is None
    assert any(info.reference is not None for info in infos)
    assert [info.place for info in open_folder(shared_data / "nordland_winter").infos[:3]] == [0, 1, 2]
