"""What slow features say of a lawn: maps, cost surfaces, and whether they know how far it is (thesis figure 9.1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.stats import spearmanr

from andante.data import FloatArray, Trajectory
from andante.evaluation.experiments.navigation_trials import KERNEL, THESIS
from andante.evaluation.experiments.navigation_world import CLEAR_M, Lawn
from andante.navigation import SlowCost, SlowSight
from andante.protocols import Recording
from andante.recordings import map_frames

_GOALS = 60
_SEED = 96
_FARTHEST_M = 0.15

CostOf = Callable[[FloatArray, FloatArray], SlowCost]
"""The goal's slow features and the deltas -> a cost."""


@dataclass(frozen=True)
class SeenBy:
    """A distance by name: which sight it looks with, and how features are weighted."""

    name: str
    sight: str
    cost: CostOf


SEEN_BY = (
    SeenBy("thesis' features, s1 and s2", THESIS, lambda goal, deltas: SlowCost.plain(goal)),
    SeenBy("thesis' features, all plain", THESIS, lambda goal, deltas: SlowCost.plain(goal, len(goal))),
    SeenBy("thesis' features, commute time", THESIS, SlowCost.commute),
    SeenBy("thesis' features, biharmonic", THESIS, SlowCost.biharmonic),
    SeenBy("kernel features, s1 and s2", KERNEL, lambda goal, deltas: SlowCost.plain(goal)),
    SeenBy("kernel features, all plain", KERNEL, lambda goal, deltas: SlowCost.plain(goal, len(goal))),
    SeenBy("kernel features, commute time", KERNEL, SlowCost.commute),
    SeenBy("kernel features, biharmonic", KERNEL, SlowCost.biharmonic),
)


@dataclass(frozen=True, eq=False)
class CostMap:
    """Slow features ``slow`` (n, k) at places ``xy_m`` (n, 2) of a grid, and the goal at ``goal_m``."""

    by: SeenBy
    deltas: FloatArray
    xy_m: FloatArray
    slow: FloatArray
    goal_m: FloatArray

    def cost_to(self, goal_m: FloatArray) -> FloatArray:
        """(n,) the cost of every place, with the goal seen at the place next to ``goal_m`` (2,)."""
        goal = self.slow[((self.xy_m - goal_m) ** 2).sum(axis=1).argmin()]
        cost = self.by.cost(goal, self.deltas)
        values: FloatArray = np.sqrt(((self.slow - goal) ** 2) @ cost.weight)
        return values


def cost_maps(sights: Mapping[str, SlowSight], grid: Recording, goal_m: FloatArray) -> tuple[CostMap, ...]:
    """All of ``SEEN_BY``, from a recording with one picture at each place, in headings by chance."""
    seen = {name: _seen(sight, grid) for name, sight in sights.items()}
    return tuple(CostMap(by, sights[by.sight].deltas, *seen[by.sight], goal_m) for by in SEEN_BY)


def _seen(sight: SlowSight, grid: Recording) -> tuple[FloatArray, FloatArray]:
    """Positions (n, 2) of a recording and the slow features (n, k) of its images."""
    infos, slow = zip(*map_frames(grid, lambda frame: sight.slow(frame.image)), strict=True)
    return Trajectory.of(infos, "reference").xy_m, np.stack(slow)


def travel_correlations(costs: Sequence[CostMap], lawn: Lawn) -> dict[str, float]:
    """Spearman's correlation of cost and length of the shortest way over all places, the mean over 60 goals."""
    xy = costs[0].xy_m
    number = lawn.nearest(xy)
    near = np.linalg.norm(lawn.xy_m[number] - xy, axis=1) < _FARTHEST_M
    rng = np.random.default_rng(_SEED)
    roomy = np.flatnonzero(lawn.room_m >= CLEAR_M)
    goals = lawn.xy_m[rng.choice(roomy, _GOALS)]
    totals = {one.by.name: 0.0 for one in costs}
    for goal in goals:
        travel = lawn.travel_m(goal)[number]
        known = near & np.isfinite(travel)
        for one in costs:
            totals[one.by.name] += float(spearmanr(one.cost_to(goal)[known], travel[known])[0]) / _GOALS
    return totals
