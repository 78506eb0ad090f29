"""The thesis' restructured training sequences: conditions change fast, places change slowly.

Slow feature analysis on edges between consecutive frames of a *reordered* sequence. Over several sessions of one
trajectory (thesis 6.2, figure 6.3) the images of all sessions at one position come before the next position. Within
one session (thesis 6.1, after Metka et al. 2016) an image of a revisited place is inserted behind that of the first.
``place_edges`` does the same with all pairs and without chance; these orders are here to compare with it.
"""

from __future__ import annotations

from collections import defaultdict

import numpy as np
from numpy.typing import ArrayLike
from scipy.spatial import KDTree

from andante.data import Edges, FloatArray, IndexArray
from andante.errors import ArrayError, ConfigError


def restructured_order(xy_m: ArrayLike, session: ArrayLike, bin_m: float, rng: np.random.Generator) -> IndexArray:
    """Frame indices (m,) ordered by place, and at each place by turns from every session in random order.

    The session with the longest path is the reference: its path, cut into pieces of ``bin_m`` metres, gives the places
    and their order. A frame belongs to the place of the nearest reference frame; frames without a position, or
    further than ``bin_m`` from the reference path, are left out, so m <= n. Frames of one session at one place keep
    their order along the path. ``xy_m`` (n, 2) in one common frame, NaN where unknown; ``session`` (n,), its frames
    in order of time; ``rng`` shuffles the sessions anew in every round at every place.
    Raises ``ArrayError`` for other shapes, ``ConfigError`` for a bin not above 0.
    """
    xy, session = _checked(xy_m, session)
    if not 0 < bin_m < np.inf:
        raise ConfigError(f"bin_m={bin_m}: has to be a length above 0 m")
    known = np.flatnonzero(np.isfinite(xy).all(axis=1))
    if len(known) == 0:
        return known
    # The reference path, and how far along it each of its frames lies.
    paths = [known[session[known] == one] for one in np.unique(session[known])]
    travelled = [_travelled(xy[path]) for path in paths]
    reference = int(np.argmax([path[-1] for path in travelled]))
    # The place of every frame that is near the path.
    distance, nearest = (np.asarray(found) for found in KDTree(xy[paths[reference]]).query(xy[known]))
    near = distance <= bin_m
    frames, along = known[near], travelled[reference][nearest[near]]
    place = np.floor(along / bin_m).astype(np.int64)
    # Places one after the other; there the sessions by turns, in random order within a turn.
    turn = _turns(place, session[frames], along)
    order: IndexArray = frames[np.lexsort((rng.random(len(frames)), turn, place))]
    return order


def restructured_edges(xy_m: ArrayLike, session: ArrayLike, bin_m: float, rng: np.random.Generator) -> Edges:
    """Edges of weight 1 between consecutive frames of ``restructured_order``."""
    return _path_edges(restructured_order(xy_m, session, bin_m, rng))


def loop_closure_order(xy_m: ArrayLike, radius_m: float, min_travel_m: float) -> IndexArray:
    """Frame indices (m,) of one drive where each revisit stands behind the frame of the first visit.

    A frame revisits the nearest earlier first-visit frame within ``radius_m`` if the robot has travelled more than
    ``min_travel_m`` in between; otherwise it is a first visit itself. Frames without a position are left out.
    ``xy_m`` (n, 2) in order of time. Raises ``ArrayError`` for another shape, ``ConfigError`` for lengths not above 0.
    """
    xy = _checked(xy_m, np.zeros(np.shape(xy_m)[0]))[0]
    if not (0 < radius_m < np.inf and 0 < min_travel_m < np.inf):
        raise ConfigError(f"radius_m={radius_m}, min_travel_m={min_travel_m}: both have to be lengths above 0 m")
    known = np.flatnonzero(np.isfinite(xy).all(axis=1))
    if len(known) == 0:
        return known
    points = xy[known]
    travelled = _travelled(points)
    tree = KDTree(points)
    first_visit = np.zeros(len(points), dtype=np.bool_)
    visits: defaultdict[int, list[int]] = defaultdict(list)
    for frame, point in enumerate(points):
        near = np.asarray(tree.query_ball_point(point, radius_m, return_sorted=True), dtype=np.int64)
        near = near[first_visit[near] & (travelled[near] < travelled[frame] - min_travel_m)]
        if len(near) == 0:
            first_visit[frame] = True
            visits[frame].append(frame)
        else:
            squared = np.square(points[near] - point).sum(axis=1)
            visits[int(near[squared.argmin()])].append(frame)
    order: IndexArray = known[np.concatenate([visits[frame] for frame in sorted(visits)])]
    return order


def loop_closure_edges(xy_m: ArrayLike, radius_m: float, min_travel_m: float) -> Edges:
    """Edges of weight 1 between consecutive frames of ``loop_closure_order``."""
    return _path_edges(loop_closure_order(xy_m, radius_m, min_travel_m))


def _path_edges(order: IndexArray) -> Edges:
    return Edges.between(order[:-1], order[1:])


def _travelled(path: FloatArray) -> FloatArray:
    """(n,) metres driven until each point of a path (n, 2)."""
    steps = np.hypot(*np.diff(path, axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)])


def _turns(place: IndexArray, session: IndexArray, along: FloatArray) -> IndexArray:
    """(n,) 0 for the first frame of a session at a place along the path, 1 for its second, and so on."""
    order = np.lexsort((along, session, place))
    starts = np.ones(len(order), dtype=np.bool_)
    starts[1:] = (np.diff(place[order]) != 0) | (session[order][1:] != session[order][:-1])
    position = np.arange(len(order))
    turn = np.empty(len(order), dtype=np.int64)
    turn[order] = position - np.maximum.accumulate(np.where(starts, position, 0))
    return turn


def _checked(xy_m: ArrayLike, session: ArrayLike) -> tuple[FloatArray, IndexArray]:
    xy, numbers = np.asarray(xy_m, dtype=np.float64), np.asarray(session)
    if xy.ndim != 2 or xy.shape[1] != 2 or numbers.shape != (len(xy),):
        raise ArrayError(
            f"xy_m has to be (n, 2) and session (n,), one of each per frame; got shapes {xy.shape}, {numbers.shape}"
        )
    return xy, numbers
