"""Which frames of two drives along the same way show the same place, from features alone.

Monotone alignment in the spirit of SeqSLAM (Milford and Wyeth 2012), found as the best path of a hidden Markov model
(Viterbi): from frame to frame of the query the reference goes on by 0 to ``max_step`` frames, or, at a price, jumps
anywhere. Where the reference is a closed lap, its last frame is followed by its first one.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from andante.data import FloatArray, IndexArray
from andante.errors import ArrayError, ConfigError
from andante.sequences.likeness import FeatureArray, centred_cosine, checked_features, contrasted

_HIGHEST = 6.0
"""A single frame counts no more than so many deviations."""
_OFF_PACE = 0.25
"""Price in deviations of each frame that the reference goes on more or less than one."""
_NEAR, _NEAR_M = 3, 0.5
"""Frames, or metres where they are known, around the path where a frame's own best match supports it."""


@dataclass(frozen=True, slots=True)
class Correspondences:
    """Frames ``first`` (k,) of a query and ``second`` (k,) of a reference that show the same place.

    ``confidence`` (k,) is in 0..1; ``offset`` (k,) in -0.5..0.5 is how many frames after ``second`` the place lies.
    ``reverse`` is true where the query was driven in the opposite direction.
    """

    first: IndexArray
    second: IndexArray
    confidence: FloatArray
    offset: FloatArray
    reverse: bool = False

    def __post_init__(self) -> None:
        shapes = {one.shape for one in (self.first, self.second, self.confidence, self.offset)}
        if len(shapes) != 1 or self.first.ndim != 1:
            raise ArrayError(f"correspondences need arrays (k,) of one length, got shapes {sorted(shapes)}")

    def __len__(self) -> int:
        return len(self.first)

    @classmethod
    def between(cls, first: ArrayLike, second: ArrayLike, confidence: float = 1.0) -> Correspondences:
        """Whole frames, all equally sure."""
        a, b = np.asarray(first, np.int64), np.asarray(second, np.int64)
        return cls(a, b, np.full(a.shape, float(confidence)), np.zeros(a.shape))


def align_sequences(
    query: ArrayLike,
    reference: ArrayLike,
    *,
    reference_xy_m: ArrayLike | None = None,
    cyclic: bool = True,
    both_directions: bool = True,
    max_step: int = 3,
    jump_cost: float = 20.0,
    window: int = 10,
) -> Correspondences:
    """For each frame of ``query`` (n, d) the frame of ``reference`` (m, d) of the same place: n correspondences.

    Features are heading-invariant where ``both_directions`` is to make sense: then the opposite direction is tried as
    well and the better one taken. ``cyclic`` lets the reference begin again after its last frame; ``jump_cost``, in
    deviations of likeness, is the price of any other jump. Confidence is the share of the frames within ``window`` of
    a frame whose own best match, without any path, lies within 3 frames of the path: near 1 where single frames are
    recognised, mostly below 0.3 in another garden. With ``reference_xy_m`` (m, 2) it is within half a metre, so that a
    place that the reference visits several times counts as one.
    Raises ``ArrayError`` for other shapes, ``ConfigError`` for values out of range.
    """
    if max_step < 1 or not jump_cost > 0 or window < 0:
        raise ConfigError(
            f"max_step={max_step}, jump_cost={jump_cost}, window={window}: at least 1, above 0, at least 0 are allowed"
        )
    likeness = centred_cosine(checked_features(query, "query"), checked_features(reference, "reference"))
    score = np.minimum(contrasted(likeness), _HIGHEST)
    path, total = _best_path(score, cyclic, max_step, jump_cost)
    reverse = False
    if both_directions:
        backward, other = _best_path(score[:, ::-1], cyclic, max_step, jump_cost)
        if other > total:
            path, reverse = score.shape[1] - 1 - backward, True
    agrees = _near(score.argmax(axis=1), path, score.shape[1], cyclic, reference_xy_m)
    offsets = _offsets(likeness, path, cyclic)
    return Correspondences(np.arange(len(path)), path, _share_around(agrees, window), offsets, reverse)


def _best_path(score: FeatureArray, cyclic: bool, max_step: int, jump_cost: float) -> tuple[IndexArray, float]:
    """The path (n,) over columns of ``score`` (n, m) with the highest sum, and that sum."""
    n, m = score.shape
    columns = np.arange(m)
    # Column 0 is where a jump came from; the others came by 0, 1, .. max_step frames.
    paces = np.arange(min(max_step, m - 1) + 1)
    price = _OFF_PACE * np.abs(paces - 1.0)
    origin = columns[None, :] - paces[:, None]
    outside = (origin < 0) & (not cyclic)
    origin %= m
    came_from = np.empty((n, m), np.int64)
    best = score[0].astype(np.float64)
    for row in range(1, n):
        reached = np.where(outside, -np.inf, best[origin] - price[:, None])
        choice = reached.argmax(axis=0)
        value, source = reached[choice, columns], origin[choice, columns]
        top = int(best.argmax())
        jumps = best[top] - jump_cost > value
        came_from[row] = np.where(jumps, top, source)
        best = np.where(jumps, best[top] - jump_cost, value) + score[row]
    path = np.empty(n, np.int64)
    path[-1] = int(best.argmax())
    for row in range(n - 1, 0, -1):
        path[row - 1] = came_from[row, path[row]]
    return path, float(best.max())


def _near(found: IndexArray, path: IndexArray, m: int, cyclic: bool, xy_m: ArrayLike | None) -> NDArray[np.bool_]:
    """(n,) whether each frame's own best match lies near the path, in a reference of ``m`` frames."""
    if xy_m is not None:
        places = np.asarray(xy_m, np.float64)
        if places.shape != (m, 2):
            raise ArrayError(f"reference_xy_m has to be one position per reference frame ({m}, 2), got {places.shape}")
        return np.asarray(np.linalg.norm(places[found] - places[path], axis=1) <= _NEAR_M, np.bool_)
    apart = np.abs(found - path)
    return np.asarray((np.minimum(apart, m - apart) if cyclic else apart) <= _NEAR, np.bool_)


def _share_around(agrees: NDArray[np.bool_], window: int) -> FloatArray:
    """(n,) share of the frames around each one that agree."""
    total = np.concatenate([[0.0], np.cumsum(agrees)])
    frames = np.arange(len(agrees))
    low, high = np.maximum(frames - window, 0), np.minimum(frames + window + 1, len(agrees))
    return np.asarray((total[high] - total[low]) / (high - low), np.float64)


def _offsets(likeness: FeatureArray, path: IndexArray, cyclic: bool) -> FloatArray:
    """(n,) vertex of the parabola through the likeness at the path and at the frames before and after it."""
    n, m = likeness.shape
    frames = np.arange(n)
    ends = (path == 0) | (path == m - 1)
    before, at, after = (np.float64(likeness[frames, (path + shift) % m]) for shift in (-1, 0, 1))
    bend = 2.0 * at - before - after
    peak = (at >= before) & (at >= after) & (bend > 0) & (cyclic | ~ends)
    offset = np.where(peak, 0.5 * (after - before) / np.where(peak, bend, 1.0), 0.0)
    return np.clip(offset, -0.5, 0.5)
