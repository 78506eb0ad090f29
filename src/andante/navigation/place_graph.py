"""Places that were driven to, ways that were really driven, and the shortest of them."""

from __future__ import annotations

from collections.abc import Callable, Iterable

import numpy as np
import scipy.sparse as sp
from numpy.typing import ArrayLike, NDArray
from scipy.sparse.csgraph import dijkstra
from scipy.spatial import cKDTree

from andante.data import FloatArray, IndexArray
from andante.errors import InputError, MapError
from andante.mapping import SlowMap

_Free = Callable[[FloatArray, FloatArray], bool]
_RADIUS_M = 0.35
_STEPS = 2.0
"""Consecutive frames farther apart than this many radii are no transition: what lies between was not seen."""
_ASIDE = 3.0
"""A way half a radius off the middle of what was driven costs as many lengths more, less near by the square."""
_GRAIN, _RIM = 0.25, 0.5  # radii


class PlaceGraph:
    """Nodes at ``xy_m`` (n, 2) driven positions, one for each square of ``radius_m`` that a drive came through.

    Edges are transitions between consecutive positions of a drive, both ways, and straight lines between nodes up to
    two radii apart that stay within half a radius of driven positions. A robot keeps farther than that from what it
    could bump into, so no edge crosses an obstacle, however much both sides look alike. Ways keep to the middle of what
    was driven: a pose is a little off, and at the rim of where robots went there is something that they kept away
    from. Positions are in metres in the frame of the map.
    """

    def __init__(self, drives: Iterable[ArrayLike], radius_m: float = _RADIUS_M) -> None:
        """``drives`` are positions (m, 2) in order; raises ``InputError`` where there are none."""
        parts = [np.asarray(drive, np.float64).reshape(-1, 2) for drive in drives]
        driven = np.concatenate(parts) if parts else np.empty((0, 2))
        if not len(driven):
            raise InputError("a place graph needs at least one driven position, got none; give it a drive")
        self.radius_m = radius_m
        self._tree = cKDTree(driven)
        # Every place once, however often it was driven.
        self._places = cKDTree(_binned(driven, _GRAIN * radius_m)[0])
        self._off_middle_m = _off_middle(self._places, _RIM * radius_m)
        self.xy_m, number = _binned(driven, radius_m)
        self._nodes = cKDTree(self.xy_m)
        ends = np.cumsum([len(part) for part in parts])[:-1]
        step = np.linalg.norm(np.diff(driven, axis=0), axis=1) <= _STEPS * radius_m
        step[ends[(ends > 0) & (ends < len(driven))] - 1] = False
        pairs = np.column_stack([number[:-1], number[1:]])[step]
        joins = [pair for pair in sorted(self._nodes.query_pairs(_STEPS * radius_m)) if self.open(*self.xy_m[[*pair]])]
        pairs = np.concatenate([pairs, np.array(joins, np.int64).reshape(-1, 2)])
        self.edges = np.unique(np.sort(pairs[pairs[:, 0] != pairs[:, 1]], axis=1), axis=0)
        self._prices = self.price(self.xy_m[self.edges[:, 0]], self.xy_m[self.edges[:, 1]])

    @classmethod
    def of(cls, slowmap: SlowMap) -> PlaceGraph:
        """From the drives that a map remembers, at its place radius.

        Raises ``MapError`` for a map without memory, ``InputError`` for one of numbered places.
        """
        if slowmap.unit == "place":
            raise InputError("this map knows numbered places, not positions; a place graph needs a map in metres")
        if slowmap.memory is None:
            raise MapError(
                "this map does not remember its drives; load it with its memory, or make it again without "
                "--localize-only (memory.keep = true)"
            )
        radius = slowmap.config.learning.place_radius_m or _RADIUS_M
        return cls([session.xy for session in slowmap.memory], min(max(radius, 0.2), _RADIUS_M))

    def off_m(self, xy_m: ArrayLike) -> float:
        """How far a point (2,) is from the nearest driven position."""
        return float(self._tree.query(np.asarray(xy_m, np.float64))[0])

    def price(self, start_m: FloatArray, goal_m: FloatArray) -> FloatArray:
        """(n,) the lengths of the lines between points (n, 2), longer the farther they lead from the middle."""
        length = np.linalg.norm(goal_m - start_m, axis=1)
        count = int(np.ceil(length.max(initial=0.0) / (_GRAIN * self.radius_m))) + 1
        line = start_m[:, None] + np.linspace(0.0, 1.0, count)[:, None] * (goal_m - start_m)[:, None]
        beside, nearest = self._places.query(line)
        aside = (beside + self._off_middle_m[nearest]) / (_RIM * self.radius_m)
        return np.asarray(length * (1.0 + _ASIDE * (aside**2).mean(axis=1)), np.float64)

    def open(
        self, start_m: FloatArray, goal_m: FloatArray, blocked_m: ArrayLike = (), clearance_m: float | None = None
    ) -> bool:
        """Whether the straight line between two points was as good as driven, and passes no ``blocked_m`` (k, 2)."""
        count = int(np.ceil(np.hypot(*(goal_m - start_m)) / (_GRAIN * self.radius_m))) + 1
        line = start_m + np.linspace(0.0, 1.0, count)[:, None] * (goal_m - start_m)
        if np.any(self._tree.query(line)[0] > 0.5 * self.radius_m):
            return False
        # Whoever stands close to what is in the way may leave, only not come closer.
        spots = np.asarray(blocked_m, np.float64).reshape(-1, 2)
        clearance = self.radius_m if clearance_m is None else clearance_m
        off = np.minimum(np.linalg.norm(spots - start_m, axis=1), np.linalg.norm(spots - goal_m, axis=1))
        return not _near(start_m[None], goal_m[None], spots, np.minimum(clearance, 0.95 * off))[0]

    def path(
        self, start_m: ArrayLike, goal_m: ArrayLike, blocked_m: ArrayLike = (), clearance_m: float | None = None
    ) -> FloatArray | None:
        """The best way (m, 2) from a point to a point, both included; ``None`` where there is none.

        It is the shortest but for a preference for the middle of what was driven (``price``). Edges that come within
        ``clearance_m``, by default a radius, of ``blocked_m`` (k, 2) are left out. Corners are cut where a straight
        open line is better. Raises ``InputError`` for a goal more than three radii from everything driven.
        """
        start, goal = np.asarray(start_m, np.float64), np.asarray(goal_m, np.float64)
        if self.off_m(goal) > 3.0 * self.radius_m:
            raise InputError(
                f"the goal ({goal[0]:.2f}, {goal[1]:.2f}) is {self.off_m(goal):.1f} m from everything that was mapped; "
                f"choose one within {3.0 * self.radius_m:.2f} m of a mapped drive"
            )
        clearance = self.radius_m if clearance_m is None else clearance_m

        def free(one: FloatArray, other: FloatArray) -> bool:
            return self.open(one, other, blocked_m, clearance)

        if np.hypot(*(goal - start)) <= self.radius_m and free(start, goal):
            return np.stack([start, goal])
        first, last = self._around(start, free), self._around(goal, free)
        ends = self._reach(start, first), self._reach(goal, last)
        matrix = self._matrix(blocked_m, clearance)
        prices, before = dijkstra(matrix, directed=False, indices=last, return_predecessors=True)
        total = prices[:, first] + ends[0] + ends[1][:, None]
        row, column = np.unravel_index(int(total.argmin()), total.shape)
        if not np.isfinite(total[row, column]):
            return None
        way = [int(first[column])]
        while way[-1] != last[row]:
            way.append(int(before[row, way[-1]]))
        return self._straightened(np.concatenate([start[None], self.xy_m[way], goal[None]]), free)

    def _matrix(self, blocked_m: ArrayLike, clearance_m: float) -> sp.csr_array:
        a, b = self.xy_m[self.edges[:, 0]], self.xy_m[self.edges[:, 1]]
        free = ~_near(a, b, blocked_m, clearance_m)
        shape = (len(self.xy_m), len(self.xy_m))
        return sp.coo_array((self._prices[free], tuple(self.edges[free].T)), shape=shape).tocsr()

    def _around(self, point: FloatArray, free: _Free) -> IndexArray:
        """Nodes that a point is joined with: those in open sight, or the nearest one."""
        near = self._nodes.query_ball_point(point, 1.5 * _STEPS * self.radius_m)
        sight = [node for node in near if free(point, self.xy_m[node])]
        return np.array(sight or [int(self._nodes.query(point)[1])], np.int64)

    def _reach(self, point: FloatArray, nodes: IndexArray) -> FloatArray:
        return self.price(np.broadcast_to(point, (len(nodes), 2)), self.xy_m[nodes])

    def _straightened(self, way: FloatArray, free: _Free) -> FloatArray:
        """Without the corners that a straight line cuts at no higher price."""
        paid = np.concatenate([[0.0], np.cumsum(self.price(way[:-1], way[1:]))])
        kept = [0]
        while kept[-1] < len(way) - 1:
            here = kept[-1]
            ahead = np.arange(len(way) - 1, here + 1, -1)
            prices = self.price(np.broadcast_to(way[here], (len(ahead), 2)), way[ahead])
            better = ahead[prices <= paid[ahead] - paid[here] + 1e-9]
            kept.append(next((int(there) for there in better if free(way[here], way[there])), here + 1))
        return way[kept]


def _off_middle(places: cKDTree, radius_m: float) -> FloatArray:
    """(n,) how far each place is from the mean of all places around it."""
    points = np.asarray(places.data)
    around = places.query_ball_point(points, radius_m)
    return np.array([np.hypot(*(points[near].mean(axis=0) - here)) for here, near in zip(points, around, strict=True)])


def length_m(way_m: FloatArray) -> float:
    """Of a way (m, 2)."""
    return float(np.linalg.norm(np.diff(way_m, axis=0), axis=1).sum())


def _binned(driven: FloatArray, side_m: float) -> tuple[FloatArray, IndexArray]:
    """The driven position next to the mean of each square, and the square of every position."""
    cells = np.floor(driven / side_m).astype(np.int64)
    _, number = np.unique(cells, axis=0, return_inverse=True)
    number = number.reshape(-1)
    count = np.bincount(number)
    mean = np.column_stack([np.bincount(number, driven[:, axis]) / count for axis in (0, 1)])
    off = np.linalg.norm(driven - mean[number], axis=1)
    order = np.lexsort((off, number))
    first = order[np.concatenate([[0], np.cumsum(count)[:-1]])]
    return driven[first], number


def _near(a: FloatArray, b: FloatArray, points: ArrayLike, radius_m: ArrayLike) -> NDArray[np.bool_]:
    """(n,) whether the lines from ``a`` to ``b`` (n, 2) come within one radius or (k,) of points (k, 2)."""
    spots = np.asarray(points, np.float64).reshape(-1, 1, 2)
    along = ((spots - a) * (b - a)).sum(-1) / np.maximum(((b - a) ** 2).sum(-1), 1e-12)
    off = np.linalg.norm(a + np.clip(along, 0.0, 1.0)[..., None] * (b - a) - spots, axis=-1)
    return np.asarray((off < np.asarray(radius_m).reshape(-1, 1)).any(axis=0))
