"""Where an image was taken away from all drives: by the directions in which known things are seen from there.

A patch that looks like a region of a mapped frame shows the thing that this region looks at, and a plane sweep told
where that stands. Slow features of gazes change little with the place of the robot, so that the thing is recognised
from elsewhere as well. Two things seen under an angle put the robot on a circle, three on a spot, with its heading
(resection); matches are often wrong, so that all spots of a grid are tried and every patch votes for those from where
one of its few best matches would be seen where it was seen.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.data import FloatArray
from andante.errors import ArrayError, LearningError

_MATCHES = 40
"""Of every patch, that may be right."""
_SHARPNESS = 4.0
_COARSE_M, _FINE_M = 0.3, 0.05
_COARSE_TURNS, _FINE_TURNS = 120, 360
_LARGEST_GRID = 2500
_BESIDE = np.float32(0.7)
"""What a match counts for a heading that is one off."""
_LEAST_PATCHES = 3


@dataclass(frozen=True, slots=True, eq=False)
class Resection:
    """``xy`` (2,) metres and heading of an image, and how well each of its patches agrees (m,), from 0 to 1."""

    xy: FloatArray
    heading_rad: float
    support: FloatArray

    @property
    def agreement(self) -> float:
        """Mean support, from 0 to 1."""
        return float(self.support.mean())


def resect(
    squared: NDArray[np.float32], points_m: FloatArray, azimuth_rad: FloatArray, area_m: FloatArray
) -> Resection:
    """From squared distances (m, F, K) of patches to regions, and the points (F, K, 2) that these look at, NaN unknown.

    ``azimuth_rad`` (m,) is where the patches are in the robot's frame, ``area_m`` (2, 2) the lower and upper corner of
    where the robot may be. Raises ``ArrayError`` for fewer than three patches or shapes that do not fit,
    ``LearningError`` where no point is known.
    """
    m = len(squared)
    if m < _LEAST_PATCHES or azimuth_rad.shape != (m,) or points_m.shape != (*squared.shape[1:], 2):
        raise ArrayError(
            f"a resection takes at least {_LEAST_PATCHES} patches with an azimuth each and a point for every region, "
            f"got shapes {squared.shape}, {azimuth_rad.shape} and {points_m.shape}"
        )
    known = np.isfinite(points_m).all(axis=2).ravel()
    if not known.any():
        raise LearningError("of no region it is known how far away it looks; the drive may be too short")
    things = points_m.reshape(-1, 2)[known]
    there, weight = _matches(squared.reshape(m, -1)[:, known])
    low, high = area_m
    step = max(_COARSE_M, float(np.sqrt(np.prod(high - low) / _LARGEST_GRID)))
    spots = _grid(low, high, step)
    frame = things[there], weight, azimuth_rad
    best = spots[_votes(spots, *frame, _COARSE_TURNS).sum(axis=0).max(axis=1).argmax()]
    spots = _grid(best - step, best + step, _FINE_M)
    votes = _votes(spots, *frame, _FINE_TURNS)
    total = votes.sum(axis=0)
    spot, turn = divmod(int(total.argmax()), _FINE_TURNS)
    heading = wrapped(2 * np.pi * (turn + 0.5) / _FINE_TURNS)
    # Of spots that are about as good, the middle.
    good = total.max(axis=1)
    share = np.exp(_SHARPNESS * (good - good.max()))
    xy: FloatArray = (share / share.sum()) @ spots
    return Resection(xy, heading, votes[:, spot, turn].astype(np.float64))


def _matches(squared: NDArray[np.float32]) -> tuple[NDArray[np.intp], NDArray[np.float32]]:
    """The best regions of every patch (m, c), and how good they are beside the best one, from 0 to 1."""
    few = min(_MATCHES, squared.shape[1])
    there = np.argpartition(squared, few - 1, axis=1)[:, :few]
    found = np.take_along_axis(squared, there, axis=1)
    return there, np.exp(-_SHARPNESS * (found / found.min(axis=1, keepdims=True) - 1)).astype(np.float32)


def _grid(low: FloatArray, high: FloatArray, step: float) -> FloatArray:
    axes = [np.arange(start, stop + step / 2, step) for start, stop in zip(low, high, strict=True)]
    return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, 2)


def _votes(
    spots: FloatArray, things: FloatArray, weight: NDArray[np.float32], azimuth: FloatArray, turns: int
) -> NDArray[np.float32]:
    """How much (m, s, turns) each patch speaks for spots (s, 2) and headings 2 pi (j + 0.5) / turns."""
    votes = np.zeros((len(azimuth), len(spots), turns), dtype=np.float32)
    rows = np.arange(len(spots))[:, None]
    for vote, seen, worth, angle in zip(votes, things, weight, azimuth, strict=True):
        towards = seen - spots[:, None]
        heading = np.arctan2(towards[..., 1], towards[..., 0]) - angle
        at = np.floor(np.mod(heading, 2 * np.pi) * (turns / (2 * np.pi))).astype(np.intp) % turns
        np.maximum.at(vote, (rows, at), np.broadcast_to(worth, at.shape))
        beside = np.maximum(np.roll(vote, 1, axis=1), np.roll(vote, -1, axis=1))
        np.maximum(vote, _BESIDE * beside, out=vote)
    return votes
