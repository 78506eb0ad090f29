"""An anchor stands still: where the robot's poses are known, whatever lies in another direction is another thing."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray, FrameInfo
from andante.landmarks.boxes import Detection

_OFF_RAD = float(np.radians(5.0))
_APART_RAD = float(np.radians(8.0))  # directions that differ less meet anywhere
_TRIED = 40
_MOST = 0.6  # of a track: where fewer agree the poses are not to be trusted


def standing_still(track: Mapping[int, Detection], infos: Sequence[FrameInfo]) -> dict[int, Detection]:
    """The detections of a track, by index of the frame, that point at one place.

    That place is the one to which most of them point, within 5 degrees or half of their width. Without reference poses,
    from a robot that hardly moves, and where fewer than 60 % agree, all of them are given.
    """
    known = [
        (index, pose.x_m, pose.y_m, pose.heading_rad)
        for index in track
        if (pose := infos[index].reference) is not None and pose.heading_rad is not None
    ]
    if len(known) < len(track) or len(known) < 2:
        return dict(track)
    indices = [row[0] for row in known]
    places = np.array([row[1:3] for row in known])
    directions = np.array([heading + track[index].box.azimuth_rad for index, _, _, heading in known])
    slack = np.array([max(_OFF_RAD, track[index].box.width_rad / 2.0) for index in indices])
    agreeing = np.zeros(len(indices), np.bool_)
    for spot in _meetings(places, directions):
        there = spot - places
        off = np.abs(wrapped(np.arctan2(there[:, 1], there[:, 0]) - directions)) <= slack
        if off.sum() > agreeing.sum():
            agreeing = off
    if agreeing.sum() < _MOST * len(indices):
        return dict(track)
    return {index: track[index] for index, agrees in zip(indices, agreeing, strict=True) if agrees}


def _meetings(places: FloatArray, directions: FloatArray) -> FloatArray:
    """Where the directions (n,) from places (n, 2) meet in pairs, ahead of both, for at most 40 of them: (k, 2)."""
    chosen = np.unique(np.linspace(0, len(places) - 1, _TRIED).round().astype(int))
    first, second = (chosen[side] for side in np.triu_indices(len(chosen), 1))
    cross = np.sin(directions[second] - directions[first])
    apart = np.abs(cross) > np.sin(_APART_RAD)
    first, second, cross = first[apart], second[apart], cross[apart]
    between = places[second] - places[first]
    ahead_first, ahead_second = np.stack([np.cos(directions), np.sin(directions)], 1)[[first, second]]
    along = (between[:, 0] * ahead_second[:, 1] - between[:, 1] * ahead_second[:, 0]) / cross
    beyond = (between[:, 0] * ahead_first[:, 1] - between[:, 1] * ahead_first[:, 0]) / cross
    meet = places[first] + along[:, None] * ahead_first
    return np.asarray(meet[(along > 0.0) & (beyond > 0.0)], np.float64)
