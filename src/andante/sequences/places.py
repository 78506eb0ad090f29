"""Edges between frames of the same place, whenever they were taken.

Slow features that are learnt along these edges see one place in many conditions as one thing, which is what the
thesis' restructured training sequence aims at (6.2), with all pairs instead of one random order. In the words of
Escalante-B. and Wiskott (JMLR 14, 2013) it is a training graph whose groups are places.

The number of edges is bounded: each frame chooses its nearest frames, the same number from every session, so that ten
summers do not outvote one winter; a pair is joined if either of its frames chose the other. There is no randomness:
the same frames give the same edges.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from andante.data import Edges, FloatArray, IndexArray
from andante.errors import ArrayError, ConfigError


def place_edges(
    xy_m: ArrayLike,
    radius_m: float,
    session: ArrayLike,
    *,
    across_weight: float = 1.0,
    max_neighbours: int = 32,
    density_corrected: bool = False,
) -> Edges:
    """Edges between frames at most ``radius_m`` apart, within and across sessions; each pair once, first < second.

    ``xy_m`` (n, 2) are positions in one common frame, NaN where unknown (such frames get no edges); ``session`` (n,)
    numbers the recording of each frame. A pair within one session weighs 1, a pair of two sessions ``across_weight``;
    0 leaves the kind out. Each frame chooses max(1, max_neighbours // number of sessions) nearest frames of every
    session, so there are at most n * max(max_neighbours, number of sessions) edges. ``density_corrected`` divides
    the weight of a pair by the square root of both frames' total weights: a place where the robot dwelt counts less.
    Raises ``ArrayError`` for other shapes, ``ConfigError`` for a radius, weight or number out of range.
    """
    points = np.asarray(xy_m, dtype=np.float64)
    if points.ndim != 2:
        raise ArrayError(f"xy_m has to hold one position per frame (n, 2), got shape {points.shape}")
    if not 0 < radius_m < np.inf:
        raise ConfigError(f"radius_m={radius_m}: has to be a distance above 0 m")
    first, second = _near_pairs(points, radius_m, np.asarray(session), max_neighbours)
    return _weighted(first, second, np.asarray(session), across_weight, density_corrected)


def label_edges(
    place: ArrayLike,
    neighbourhood: int,
    session: ArrayLike,
    *,
    across_weight: float = 1.0,
    max_neighbours: int = 32,
    density_corrected: bool = False,
) -> Edges:
    """Edges between frames whose place labels differ by at most ``neighbourhood`` (0: the same label).

    ``place`` (n,) are whole numbers along a route, NaN where unknown; all else is as in ``place_edges``.
    """
    labels = np.asarray(place, dtype=np.float64)
    if labels.ndim != 1:
        raise ArrayError(f"place has to be one label per frame (n,), got shape {labels.shape}")
    if neighbourhood < 0:
        raise ConfigError(f"neighbourhood={neighbourhood}: has to be 0 (same label) or more")
    # Labels are whole numbers: half a label more keeps rounding out of the comparison.
    radius = neighbourhood + 0.5
    points = labels[:, None]
    first, second = _near_pairs(points, radius, np.asarray(session), max_neighbours)
    return _weighted(first, second, np.asarray(session), across_weight, density_corrected)


def _near_pairs(
    points: FloatArray, radius: float, session: NDArray[Any], max_neighbours: int
) -> tuple[IndexArray, IndexArray]:
    """Pairs of frames within the radius, each once and sorted, bounded as ``place_edges`` says."""
    if session.shape != (len(points),):
        raise ArrayError(f"session has shape {session.shape}, but there are {len(points)} frames: one number per frame")
    if max_neighbours < 1:
        raise ConfigError(f"max_neighbours={max_neighbours}: has to be at least 1")
    n = len(points)
    known = np.flatnonzero(np.isfinite(points).all(axis=1))
    members = [known[session[known] == one] for one in np.unique(session[known])]
    quota = max(1, max_neighbours // max(1, len(members)))
    # A pair as one number, so that a pair which both frames chose counts once.
    keys = [np.empty(0, np.int64)]
    for others in members:
        frame, choice = _chosen_pairs(points, known, others, radius, quota)
        keys.append(np.minimum(frame, choice) * n + np.maximum(frame, choice))
    first, second = np.divmod(np.unique(np.concatenate(keys)), max(1, n))
    return first, second


def _weighted(
    first: IndexArray, second: IndexArray, session: NDArray[Any], across_weight: float, density_corrected: bool
) -> Edges:
    """Edges with the weights that ``place_edges`` describes; pairs of weight 0 are left out."""
    if not 0 <= across_weight < np.inf:
        raise ConfigError(f"across_weight={across_weight}: has to be a finite number >= 0")
    weight = np.where(session[first] == session[second], 1.0, across_weight)
    used = weight > 0
    first, second, weight = first[used], second[used], weight[used]
    if density_corrected:
        n = len(session)
        degree = np.bincount(first, weight, n) + np.bincount(second, weight, n)
        weight = weight / np.sqrt(degree[first] * degree[second])
    return Edges(first, second, weight)


def _chosen_pairs(
    points: FloatArray, frames: IndexArray, others: IndexArray, radius: float, quota: int
) -> tuple[IndexArray, IndexArray]:
    """Each of ``frames`` with its at most ``quota`` nearest of ``others`` other than itself, within the radius."""
    # One more than the quota, because a frame finds itself among its own session.
    k = min(quota + 1, len(others))
    distance, found = KDTree(points[others]).query(
        points[frames], k=np.arange(1, k + 1), distance_upper_bound=np.nextafter(radius, np.inf)
    )
    candidate = np.append(others, -1)[found]
    usable = np.isfinite(distance) & (candidate != frames[:, None])
    usable &= np.cumsum(usable, axis=1) <= quota
    row, column = np.nonzero(usable)
    return frames[row], candidate[row, column]
