"""Where a thing stands that a robot saw from known places, and whether another one stands there too."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray
from andante.landmarks.boxes import Detection

_LEAST_FRAMES = 5
_LEAST_SPREAD_RAD = float(np.radians(15.0))
"""Directions that differ by less do not meet anywhere in particular."""
_OWN_RAD = float(np.radians(6.0))
_OTHER_RAD = float(np.radians(30.0))
"""Off by more in the median is another place, whatever a detector and poses get wrong."""
_ROUNDS = 5
_LEAST_DISTANCE_M = 0.3


def stands_elsewhere(one: Mapping[int, Detection], other: Mapping[int, Detection], poses: FloatArray) -> bool:
    """Whether what ``other`` shows stands for certain where what ``one`` shows does not, both by frame.

    ``poses`` (n, 3) of the robot in frames, x, y in metres and heading in radians, NaN where they are not known.
    """
    seen, again = _rays(one, poses), _rays(other, poses)
    if min(len(seen), len(again)) < _LEAST_FRAMES:
        return False
    spread = np.hypot(np.cos(seen[:, 2]).mean(), np.sin(seen[:, 2]).mean())
    if spread > 1.0 - _LEAST_SPREAD_RAD**2 / 8.0:
        return False
    place = _meeting(seen)
    return _off_rad(place, seen) < _OWN_RAD and _off_rad(place, again) > _OTHER_RAD


def _rays(chain: Mapping[int, Detection], poses: FloatArray) -> FloatArray:
    """(m, 3) from where and in which direction, of the frames with a known pose."""
    frames = np.array(sorted(chain), np.int64)
    rays = poses[frames] + np.array([(0.0, 0.0, chain[frame].box.azimuth_rad) for frame in frames.tolist()])
    return np.asarray(rays[np.isfinite(rays).all(axis=1)], np.float64)


def _meeting(rays: FloatArray) -> FloatArray:
    """Where rays (m, 3) meet, by least squares of angles."""
    normal = np.stack([-np.sin(rays[:, 2]), np.cos(rays[:, 2])], axis=1)
    target = (normal * rays[:, :2]).sum(axis=1)
    place, weight = rays[:, :2].mean(axis=0), np.ones(len(rays))
    for _ in range(_ROUNDS):
        place = np.linalg.lstsq(normal * weight[:, None], target * weight)[0]
        # What is across a ray is an angle times a distance.
        weight = 1.0 / np.maximum(np.linalg.norm(place - rays[:, :2], axis=1), _LEAST_DISTANCE_M)
    return np.asarray(place, np.float64)


def _off_rad(place: FloatArray, rays: FloatArray) -> float:
    """By how much rays (m, 3) miss a place, in the median."""
    away = place - rays[:, :2]
    return float(np.median(np.abs(wrapped(np.arctan2(away[:, 1], away[:, 0]) - rays[:, 2]))))
