import cv2
import numpy as np
import pytest

from andante.data import CameraSpec, Pose2D
from andante.errors import RecordingError
from andante.protocols import Recording
from andante.recordings import MemoryRecording

IMAGES = [np.full((4, 6), index, np.uint8) for index in range(3)]


def make(images=IMAGES, times=(0, 1, 2), **more):
    return MemoryRecording(images, times, CameraSpec(), **more)


def test_is_a_recording_with_everything_known():
    recording = make(odometry=[None, Pose2D(1, 2), None], place=[3, None, 5], name="x", conditions={"season": "snow"})
    assert isinstance(recording, Recording)
    assert [info.odometry for info in recording.infos] == [None, Pose2D(1, 2), None]
    assert [info.place for info in recording.infos] == [3, None, 5]
    assert all(info.reference is None for info in recording.infos)
    assert repr(recording) == "MemoryRecording('x', 3 frames)"
    assert (recording.name, recording.conditions) == ("x", {"season": "snow"})


def test_converts_between_grey_and_colour():
    bgr = np.random.default_rng(0).integers(0, 256, (4, 6, 3), dtype=np.uint8)
    recording = make([bgr, bgr[:, :, 0].copy()], [0, 1])
    first, second = recording.infos
    np.testing.assert_array_equal(recording.load(first), cv2.cvtColor(bgr, cv2.COLOR_BGR2GRAY))
    np.testing.assert_array_equal(recording.load(first, colour=True), bgr)
    np.testing.assert_array_equal(recording.load(second, colour=True), np.repeat(bgr[:, :, :1], 3, axis=2))


def test_changing_a_frame_does_not_change_the_recording():
    recording = make()
    next(recording.frames()).image[:] = 99
    assert next(recording.frames()).image.max() == 0


def test_hash_depends_on_pixels_shapes_and_table():
    assert make().content_hash() == make(name="other").content_hash()
    others = [
        make(times=[0, 1, 3]),
        make(place=[1, 2, 3]),
        make(reference=[Pose2D(0, 0), None, None]),
        make(odometry=[Pose2D(0, 0), None, None]),
        make([*IMAGES[:2], IMAGES[0]]),
        make([image.reshape(6, 4) for image in IMAGES]),
    ]
    assert len({make().content_hash(), *(other.content_hash() for other in others)}) == 7


def test_faults():
    with pytest.raises(RecordingError, match="recording 'memory': no images"):
        make([], [])
    with pytest.raises(RecordingError, match="2 timestamps_s for 3 images; give one for each"):
        make(times=[0, 1])
    with pytest.raises(RecordingError, match="1 reference for 3 images"):
        make(reference=[None])
    with pytest.raises(RecordingError, match=r"frame 2 has 1\.0 s after 1\.0 s in frame 1"):
        make(times=[0, 1, 1])
    with pytest.raises(RecordingError, match="frame 1: time nan is not finite"):
        make(times=[0, float("nan"), 1])
    for image in (np.zeros((4, 6)), np.zeros((4, 6, 4), np.uint8), np.zeros(4, np.uint8), np.zeros((0, 6), np.uint8)):
        with pytest.raises(RecordingError, match=r"image 0 has shape .* allowed are uint8"):
            make([image], [0])
