"""Detections that point at one place, and others."""

import numpy as np
import pytest

from andante.angles import wrapped
from andante.data import FrameInfo, Pose2D
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.standing import standing_still

BICYCLE, POT = (4.0, 3.0), (-3.0, -5.0)


def driven(at, frames=30, posed=True):
    """Detections of things by frame, ``at(frame)`` where, and the poses of a robot that drives a bend."""
    infos, track = [], {}
    for n in range(frames):
        pose = Pose2D(-4.0 + 0.25 * n, 0.4 * np.sin(0.2 * n), float(wrapped(0.1 * n)))
        infos.append(FrameInfo(n, f"{n}", 0.2 * n, None, pose if posed else None))
        x, y = at(n)
        azimuth = np.arctan2(y - pose.y_m, x - pose.x_m) - pose.heading_rad
        track[n] = Detection(Box(float(wrapped(azimuth)), 0.0, 0.1, 0.1), "bicycle", 0.5)
    return track, infos


def test_what_lies_elsewhere_is_left_out():
    track, infos = driven(lambda n: POT if 10 <= n < 15 else BICYCLE)
    assert list(standing_still(track, infos)) == [*range(10), *range(15, 30)]


@pytest.mark.parametrize("frames", [1, 2, 30])
def test_what_stands_still_is_kept(frames):
    track, infos = driven(lambda n: BICYCLE, frames)
    assert standing_still(track, infos) == track


def test_nothing_is_left_out_where_little_is_known():
    track, infos = driven(lambda n: POT if n < 10 else BICYCLE, posed=False)
    assert standing_still(track, infos) == track
    track, infos = driven(lambda n: (4.0 * np.cos(n), 9.0 * np.sin(3.0 * n)))  # nowhere
    assert standing_still(track, infos) == track
    infos = [FrameInfo(n, f"{n}", 0.2 * n, None, Pose2D(0.0, 0.0, 0.0)) for n in range(30)]  # never moved
    track = {n: Detection(Box(0.3, 0.0, 0.1, 0.1), "bicycle", 0.5) for n in range(30)}
    assert standing_still(track, infos) == track
    assert standing_still({}, infos) == {}
