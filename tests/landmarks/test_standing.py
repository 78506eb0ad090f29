"""Detections that point at one place, and others."""

import numpy as np
import pytest

from andante.angles import wrapped
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.standing import standing_still

BICYCLE, POT = (4.0, 3.0), (-3.0, -5.0)


def driven(at, frames=30, posed=True):
    """Detections of things by frame, ``at(frame)`` where, and the poses of a robot that drives a bend."""
    n = np.arange(frames)
    poses = np.stack([-4.0 + 0.25 * n, 0.4 * np.sin(0.2 * n), wrapped(0.1 * n)], axis=1)
    track = {}
    for frame, pose in enumerate(poses):
        x, y = at(frame)
        azimuth = np.arctan2(y - pose[1], x - pose[0]) - pose[2]
        track[frame] = Detection(Box(float(wrapped(azimuth)), 0.0, 0.1, 0.1), "bicycle", 0.5)
    return track, poses if posed else np.full_like(poses, np.nan)


def test_what_lies_elsewhere_is_left_out():
    track, poses = driven(lambda n: POT if 10 <= n < 15 else BICYCLE)
    assert list(standing_still(track, poses)) == [*range(10), *range(15, 30)]


@pytest.mark.parametrize("frames", [1, 2, 30])
def test_what_stands_still_is_kept(frames):
    track, poses = driven(lambda n: BICYCLE, frames)
    assert standing_still(track, poses) == track


def test_nothing_is_left_out_where_little_is_known():
    track, poses = driven(lambda n: POT if n < 10 else BICYCLE, posed=False)
    assert standing_still(track, poses) == track
    track, poses = driven(lambda n: (4.0 * np.cos(n), 9.0 * np.sin(3.0 * n)))  # nowhere
    assert standing_still(track, poses) == track
    poses = np.zeros((30, 3))  # never moved
    track = {n: Detection(Box(0.3, 0.0, 0.1, 0.1), "bicycle", 0.5) for n in range(30)}
    assert standing_still(track, poses) == track
    assert standing_still({}, poses) == {}
