import tempfile
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.data import CameraSpec, Frame, FrameInfo, Pose2D
from andante.errors import ConfigError, RecordingError
from andante.recordings import MemoryRecording, write_recording

finite = st.floats(-1e9, 1e9)
poses = st.none() | st.builds(Pose2D, finite, finite, st.none() | finite)
texts = st.text(st.characters(exclude_categories=["Cs"]), min_size=1)


def frames(n=3, **more):
    images = [np.full((4, 6, 3), 20 * index, np.uint8) for index in range(n)]
    return MemoryRecording(images, range(n), CameraSpec(), **more).frames(colour=True)


@settings(max_examples=40)
@given(
    rows=st.lists(st.tuples(poses, poses, st.none() | st.integers(0, 10**6)), min_size=1, max_size=3),
    times=st.lists(finite, min_size=3, max_size=3, unique=True),
    name=texts,
    conditions=st.dictionaries(texts, texts | finite | st.booleans(), max_size=3),
    seed=st.integers(0, 2**32),
)
def test_round_trip_is_exact(rows, times, name, conditions, seed):
    odometry, reference, place = zip(*rows, strict=True)
    images = list(np.random.default_rng(seed).integers(0, 256, (len(rows), 4, 6, 3), dtype=np.uint8))
    camera = CameraSpec(model="panorama", forward_deg=12.5)
    original = MemoryRecording(
        images, sorted(times)[: len(rows)], camera, odometry=odometry, reference=reference, place=place
    )
    with tempfile.TemporaryDirectory() as parent:
        written = write_recording(
            Path(parent) / "a",
            original.frames(colour=True),
            name=name,
            camera=camera,
            conditions=conditions,
            image_format="png",
        )
        assert (written.name, written.camera, written.conditions) == (name, camera, conditions)
        for ours, theirs in zip(original.infos, written.infos, strict=True):
            assert (ours.timestamp_s, ours.odometry, ours.reference, ours.place) == (
                theirs.timestamp_s,
                theirs.odometry,
                theirs.reference,
                theirs.place,
            )
        for image, frame in zip(images, written.frames(colour=True), strict=True):
            np.testing.assert_array_equal(frame.image, image)


def test_jpeg_is_near_and_quality_matters(tmp_path):
    fine = write_recording(tmp_path / "fine", frames(), name="a", camera=CameraSpec())
    coarse = write_recording(tmp_path / "coarse", frames(), name="a", camera=CameraSpec(), jpeg_quality=10)
    for frame in fine.frames():
        assert np.abs(frame.image.astype(int) - 20 * frame.info.index).max() <= 3
    sizes = [sum(path.stat().st_size for path in (r.folder / "images").iterdir()) for r in (fine, coarse)]
    assert sizes[0] > sizes[1]


def test_frames_are_taken_one_by_one(tmp_path):
    def watched():
        for index, frame in enumerate(frames(5)):
            assert len(list(tmp_path.glob(".a.*.part/images/*"))) == index
            assert not (tmp_path / "a").exists()
            yield frame

    write_recording(tmp_path / "a", watched(), name="a", camera=CameraSpec())
    assert [path.name for path in tmp_path.iterdir()] == ["a"]


@pytest.mark.parametrize("error", [RuntimeError, KeyboardInterrupt])
def test_an_interruption_leaves_nothing_behind(tmp_path, error):
    def broken():
        yield from frames(2)
        raise error

    with pytest.raises(error):
        write_recording(tmp_path / "a", broken(), name="a", camera=CameraSpec())
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("infos", "message"),
    [
        ([], r"a/frames\.csv: no rows"),
        ([FrameInfo(0, "", 1.0), FrameInfo(1, "", 1.0)], r"line 3 has 1\.0 s after 1\.0 s in line 2"),
        ([FrameInfo(0, "", float("nan"))], "line 2, column timestamp_s: 'nan' is not a finite number"),
        ([FrameInfo(0, "", 0.0, reference=Pose2D(1.0, float("inf")))], "column y_m: 'inf' is not a finite number"),
    ],
)
def test_what_could_not_be_read_is_not_written(tmp_path, infos, message):
    image = np.zeros((4, 6), np.uint8)
    with pytest.raises(RecordingError, match=message):
        write_recording(tmp_path / "a", (Frame(info, image) for info in infos), name="a", camera=CameraSpec())
    assert list(tmp_path.iterdir()) == []


def test_faults(tmp_path):
    (tmp_path / "there").mkdir()
    with pytest.raises(RecordingError, match="there exists already; choose another folder"):
        write_recording(tmp_path / "there", frames(), name="a", camera=CameraSpec())
    with pytest.raises(ConfigError, match="image format 'gif' is unknown; allowed are jpg, png"):
        write_recording(tmp_path / "a", frames(), name="a", camera=CameraSpec(), image_format="gif")
    with pytest.raises(ConfigError, match="jpeg_quality = 0 is not allowed; use 1 to 100"):
        write_recording(tmp_path / "a", frames(), name="a", camera=CameraSpec(), jpeg_quality=0)
    with pytest.raises(RecordingError, match="'name': String should have at least 1 character"):
        write_recording(tmp_path / "a", frames(), name="", camera=CameraSpec())
    with pytest.raises(RecordingError, match=r"'camera\.radius_px': Input should be greater than 0"):
        write_recording(tmp_path / "a", frames(), name="a", camera=CameraSpec(radius_px=-1.0))
    with pytest.raises(RecordingError, match="a condition of type object cannot be written"):
        write_recording(tmp_path / "a", frames(), name="a", camera=CameraSpec(), conditions={"x": object()})
    odd = Frame(FrameInfo(0, "", 0.0), np.zeros((4, 6, 4), np.uint8))
    with pytest.raises(
        RecordingError, match=r"an image of shape \(4, 6, 4\) and type uint8 cannot be written; allowed"
    ):
        write_recording(tmp_path / "a", [odd], name="a", camera=CameraSpec())
    assert [path.name for path in tmp_path.iterdir()] == ["there"]
