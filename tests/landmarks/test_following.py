"""Following: as far as the track holds, confirmed from both sides, and never past a lost track."""

import numpy as np
import pytest

from andante.landmarks.boxes import Box, Detection
from andante.landmarks.following import UNCONFIRMED, Follower, fill_gaps


def turned(azimuth):
    return float(np.angle(np.exp(1j * azimuth)))


class Drive:
    """A robot that turns and nears a thing, which nobody sees in ``hidden`` frames."""

    def __init__(self, scene, frames=21, start=2.9, hidden=()):
        self.scene, self.frames, self.hidden = scene, frames, set(hidden)
        self.headings = 0.15 * np.arange(frames)
        growth = 1.02 ** np.arange(frames)
        self.boxes = [
            Box(turned(start - heading + 0.01 * n), 0.15, 0.3 * grown, 0.3 * grown)
            for n, (heading, grown) in enumerate(zip(self.headings, growth, strict=True))
        ]

    def panorama(self, index):
        return self.scene.panorama(self.headings[index], None if index in self.hidden else self.boxes[index])

    def detected(self, *frames):
        return {index: Detection(self.boxes[index], "bicycle", 0.8) for index in frames}


def test_a_step_moves_and_scales_the_box(scene, geometry):
    drive = Drive(scene)
    moved = Follower(geometry).step(drive.panorama(0), drive.panorama(1), drive.boxes[0])
    assert moved is not None
    assert moved.iou(drive.boxes[1]) > 0.85


def test_a_gap_is_filled_from_both_ends_also_across_the_seam(scene, geometry):
    drive = Drive(scene)
    found = fill_gaps(drive.detected(0, 20), drive.panorama, geometry, drive.frames)
    assert list(found) == list(range(21))
    assert [index for index, one in found.items() if not one.followed] == [0, 20]
    assert min(found[index].box.iou(drive.boxes[index]) for index in found) > 0.6
    assert all(-np.pi < one.box.azimuth_rad <= np.pi for one in found.values())
    assert found[10].score < 0.8


def test_a_lost_track_is_not_followed_past(scene, geometry):
    drive = Drive(scene, hidden=range(8, 13))
    found = fill_gaps(drive.detected(0, 20), drive.panorama, geometry, drive.frames)
    assert not set(range(8, 13)) & set(found)
    # Without the other track to confirm it, each leads a few frames only.
    assert set(found) == {*range(UNCONFIRMED + 1), *range(20 - UNCONFIRMED, 21)}


def test_before_the_first_and_after_the_last_detection_only_few_frames_are_followed(scene, geometry):
    drive = Drive(scene)
    found = fill_gaps(drive.detected(10), drive.panorama, geometry, drive.frames)
    assert list(found) == list(range(10 - UNCONFIRMED, 10 + UNCONFIRMED + 1))


def test_where_both_tracks_disagree_there_is_none(scene, geometry):
    drive = Drive(scene)
    wrong = Box(turned(drive.boxes[20].azimuth_rad + 1.0), 0.2, 0.3, 0.3)
    ends = {**drive.detected(0), 20: Detection(wrong, "bicycle", 0.8)}
    found = fill_gaps(ends, drive.panorama, geometry, drive.frames)
    assert not set(range(UNCONFIRMED + 1, 20 - UNCONFIRMED)) & set(found)


def test_long_gaps_are_left_open(scene, geometry):
    drive = Drive(scene)
    found = fill_gaps(drive.detected(0, 20), drive.panorama, geometry, drive.frames, max_gap=10)
    assert 10 not in found


def test_where_nothing_can_be_seen_a_track_is_lost(geometry):
    blank = np.full((120, 720, 3), 90, np.uint8)
    assert Follower(geometry).step(blank, blank, Box(0.0, 0.1, 0.3, 0.3)) is None


def test_detections_stay_as_they_are(scene, geometry):
    drive = Drive(scene)
    detections = drive.detected(*range(21))
    assert fill_gaps(detections, drive.panorama, geometry, drive.frames) == detections


@pytest.mark.parametrize("frames", [(), (3,)])
def test_few_detections_are_no_error(scene, geometry, frames):
    drive = Drive(scene)
    found = fill_gaps(drive.detected(*frames), drive.panorama, geometry, drive.frames)
    assert set(frames) <= set(found)
