"""An anchor stands still: where it stands, seen from known places, tells it from others and from what is none."""

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
_OFF_RAD = float(np.radians(5.0))
_APART_RAD = float(np.radians(8.0))
"""Two directions that differ by less meet anywhere."""
_MOST = 0.6
"""Of a track: where fewer agree on a place the poses are not to be trusted."""
_TRIED = 40
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


def standing_still(track: Mapping[int, Detection], poses: FloatArray) -> dict[int, Detection]:
    """The detections of a track, by index of the frame, that point at one place.

    That place is the one to which most of them point, within 5 degrees or half of their width. Without ``poses`` (n, 3)
    of the robot in all of these frames (x, y, heading, NaN where unknown), from a robot that hardly moves, and where
    fewer than 60 % agree, all of them are given.
    """
    rays = _rays(track, poses)
    if len(rays) < max(len(track), 2):
        return dict(track)
    indices = sorted(track)
    slack = np.array([max(_OFF_RAD, track[index].box.width_rad / 2.0) for index in indices])
    agreeing = np.zeros(len(indices), np.bool_)
    for spot in _meetings(rays):
        off = _misses_rad(spot, rays) <= slack
        if off.sum() > agreeing.sum():
            agreeing = off
    if agreeing.sum() < _MOST * len(indices):
        return dict(track)
    return {index: track[index] for index, agrees in zip(indices, agreeing, strict=True) if agrees}


def _rays(chain: Mapping[int, Detection], poses: FloatArray) -> FloatArray:
    """(m, 3) from where and in which direction, of the frames with a known pose."""
    frames = np.array(sorted(chain), np.int64)
    azimuth = np.array([chain[frame].box.azimuth_rad for frame in frames.tolist()], np.float64)
    rays = poses[frames] + azimuth[:, None] * np.array([0.0, 0.0, 1.0])
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


def _meetings(rays: FloatArray) -> FloatArray:
    """Where rays (m, 3) meet in pairs, ahead of both, for at most 40 of them: (k, 2)."""
    chosen = rays[np.unique(np.linspace(0, len(rays) - 1, _TRIED).round().astype(int))]
    first, second = (chosen[side] for side in np.triu_indices(len(chosen), 1))
    cross = np.sin(second[:, 2] - first[:, 2])
    apart = np.abs(cross) > np.sin(_APART_RAD)
    first, second, cross = first[apart], second[apart], cross[apart]
    between = second[:, :2] - first[:, :2]
    ahead_first, ahead_second = (np.stack([np.cos(one[:, 2]), np.sin(one[:, 2])], axis=1) for one in (first, second))
    along = (between[:, 0] * ahead_second[:, 1] - between[:, 1] * ahead_second[:, 0]) / cross
    beyond = (between[:, 0] * ahead_first[:, 1] - between[:, 1] * ahead_first[:, 0]) / cross
    meet = first[:, :2] + along[:, None] * ahead_first
    return np.asarray(meet[(along > 0.0) & (beyond > 0.0)], np.float64)


def _off_rad(place: FloatArray, rays: FloatArray) -> float:
    """By how much rays (m, 3) miss a place, in the median."""
    return float(np.median(_misses_rad(place, rays)))


def _misses_rad(place: FloatArray, rays: FloatArray) -> FloatArray:
    """By how much each of rays (m, 3) misses a place."""
    away = place - rays[:, :2]
    return np.abs(wrapped(np.arctan2(away[:, 1], away[:, 0]) - rays[:, 2]))
