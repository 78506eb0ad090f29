"""One anchor through a recording, with a detector that finds bright red things and misses some frames."""

from dataclasses import replace

import numpy as np
import pytest

from andante.data import CameraSpec
from andante.errors import ConfigError, ImageError, InputError, LearningError
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.search import AnchorSearch, _still
from andante.landmarks.tracks import Chosen, one_anchor
from andante.landmarks.yolox import Found
from andante.recordings import MemoryRecording

FRAMES = 24


class Red:
    """Finds what is marked in pure red in a cut; the marks are drawn over the frames in which it is to be seen."""

    def __call__(self, picture, min_score):
        mask = (picture[..., 2] > 180) & (picture[..., 0] < 60)
        columns = np.flatnonzero(mask.any(axis=0))
        found = []
        for run in np.split(columns, np.flatnonzero(np.diff(columns) > 8) + 1) if len(columns) > 3 else []:
            rows = np.flatnonzero(mask[:, run].any(axis=1))
            found.append(
                Found((float(run[0]), float(rows[0]), float(run[-1] + 1), float(rows[-1] + 1)), "suitcase", 0.8)
            )
        return found


def framed(panorama, box, half_deg=30.0):
    """A red frame around a box in a panorama whose horizon is in its middle."""
    height, width = panorama.shape[:2]
    left, right = (round((np.pi - edge) / (2 * np.pi) * width) for edge in (box.left_rad, box.right_rad))
    top, low = (
        round((np.radians(half_deg) - edge) / np.radians(2 * half_deg) * height) for edge in (box.high_rad, box.low_rad)
    )
    for columns, rows in (
        ((left, right), (top, top + 3)),
        ((left, right), (low - 3, low)),
        ((left, left + 3), (top, low)),
        ((right - 3, right), (top, low)),
    ):
        panorama[slice(*rows), np.mod(np.arange(*columns), width)] = (0, 0, 255)
    return panorama


@pytest.fixture
def boxes():
    return [Box(float(np.angle(np.exp(1j * (2.8 + 0.03 * n)))), 0.0, 0.4, 0.4) for n in range(FRAMES)]


def recorded(scene, frames, *seen):
    """Frames of 720 x 120 px, elevations +-30 degrees; ``seen`` are (boxes, frames in which they are marked)."""
    images = []
    for n in range(frames):
        image = scene.panorama(0.0)
        for boxes, marked in seen:
            if n in marked:
                framed(image, boxes[n])
        images.append(image)
    return MemoryRecording(images, np.arange(frames) * 0.2, CameraSpec(model="panorama"))


def test_an_anchor_is_found_in_every_frame_in_which_it_is(scene, boxes):
    calls = []
    search = AnchorSearch(Red(), workers=1)
    track = search.find(recorded(scene, FRAMES, (boxes, range(FRAMES))), "suitcase", lambda *done: calls.append(done))
    assert list(track) == list(range(FRAMES))
    assert min(track[n].box.iou(boxes[n]) for n in track) > 0.8
    assert calls[-1] == (FRAMES, FRAMES)
    assert "suitcase" in search.names


def test_looking_at_every_third_frame_follows_the_others(scene, boxes):
    recording = recorded(scene, FRAMES, (boxes, range(FRAMES)))
    track = AnchorSearch(Red(), every=2, workers=1).find(recording, "suitcase")
    assert all(one.followed == bool(n % 2) for n, one in track.items())
    assert len(track) >= FRAMES - 2


def test_no_anchor_and_too_few_frames_are_errors(scene, boxes):
    with pytest.raises(LearningError, match=r"no suitcase was found in any frame; put one beside the landmark"):
        AnchorSearch(Red(), workers=1).find(recorded(scene, 5), "suitcase")
    with pytest.raises(LearningError, match=r"the suitcase was found in 3 frames only, at least 10 are needed"):
        AnchorSearch(Red(), workers=1).find(recorded(scene, 12, (boxes, range(4, 7))), "suitcase")


def test_two_anchors_are_an_error_until_one_is_chosen(scene, boxes):
    others = [Box(-0.5, 0.0, 0.3, 0.3)] * FRAMES
    recording = recorded(scene, FRAMES, (boxes, range(FRAMES)), (others, range(FRAMES)))
    search = AnchorSearch(Red(), workers=1)
    with pytest.raises(InputError, match=r"two things called 'suitcase' are in view.*say which by a frame"):
        search.find(recording, "suitcase")
    track = search.find(recording, "suitcase", chosen=Chosen(3, -0.4))
    assert all(abs(one.box.azimuth_rad + 0.5) < 0.05 for one in track.values())


def test_what_is_chosen_is_not_exchanged_for_what_most_frames_show():
    # Of the chosen one there are too few frames to say where it stands; then another one is in view for long.
    poses = np.column_stack([0.3 * np.arange(80), np.zeros(80), np.zeros(80)])
    things = {range(4): (3.0, 6.0), range(25, 80): (20.0, -6.0)}
    detections = {
        frame: [Detection(Box(float(np.arctan2(y, x - poses[frame, 0])), 0.05, 0.2, 0.2), "bicycle", 0.8)]
        for frames, (x, y) in things.items()
        for frame in frames
    }
    first, other = (Chosen(frame, detections[frame][0].box.azimuth_rad) for frame in (1, 40))
    with pytest.raises(InputError, match=r"what was chosen in frame 1 stands elsewhere than what most of 59 frames"):
        _still(one_anchor(detections, np.zeros(80), first, poses), poses, first)
    assert set(_still(one_anchor(detections, np.zeros(80), other, poses), poses, other)) == set(range(25, 80))


def test_every_frame_is_looked_at_once_for_all_anchors(scene, boxes):
    recording, red = recorded(scene, FRAMES, (boxes, range(FRAMES))), Red()
    fresh = AnchorSearch(Red(), workers=1).find(recording, "suitcase")
    looks = []

    def counted(picture, min_score):
        looks.append(1)
        return red(picture, min_score)

    def stop(done, total):
        if done == 5:
            raise KeyboardInterrupt

    search = AnchorSearch(counted, workers=1)
    with pytest.raises(KeyboardInterrupt):
        search.find(recording, "suitcase", stop)
    calls = []
    with pytest.raises(LearningError, match=r"no bicycle"):
        search.find(recording, "bicycle", lambda *done: calls.append(done))
    assert calls[0] == (5, FRAMES)
    before = len(looks)
    assert search.find(recording, "suitcase") == fresh
    assert len(looks) == before
    search.find(recorded(scene, FRAMES, (boxes, range(FRAMES))), "suitcase")  # another recording is looked at anew
    assert len(looks) > before


def test_frames_that_show_a_part_of_the_anchor_are_left_out_where_there_are_others(scene, boxes):
    # The picture ends at -0.52.
    low = [replace(box, elevation_rad=-0.35 if n < 8 else 0.0) for n, box in enumerate(boxes)]
    track = AnchorSearch(Red(), workers=1).find(recorded(scene, FRAMES, (low, range(FRAMES))), "suitcase")
    assert list(track) == list(range(8, FRAMES))
    everywhere = [replace(box, elevation_rad=-0.35) for box in boxes]
    track = AnchorSearch(Red(), workers=1).find(recorded(scene, FRAMES, (everywhere, range(FRAMES))), "suitcase")
    assert list(track) == list(range(FRAMES))


def test_a_frame_that_cannot_be_read_is_passed_over(scene, boxes):
    recording = recorded(scene, FRAMES, (boxes, range(FRAMES)))
    load = recording.load

    def broken(info, *, colour=False):
        if info.index == 9:
            raise ImageError("frame 9 is damaged")
        return load(info, colour=colour)

    recording.load = broken
    track = AnchorSearch(Red(), workers=1).find(recording, "suitcase")
    assert 9 not in track
    assert {8, 10} <= set(track)


def test_unknown_names_and_strides_are_errors(scene):
    with pytest.raises(ConfigError, match=r"an anchor 'wheelbarrow' is not known; known are person, bicycle"):
        AnchorSearch(Red()).find(recorded(scene, 2), "wheelbarrow")
    with pytest.raises(ConfigError, match=r"every = 0 is not allowed"):
        AnchorSearch(Red(), every=0)
