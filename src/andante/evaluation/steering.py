"""The navigators of ``andante navigate``, made ready for a goal."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from andante.data import FloatArray, ImageArray, Trajectory
from andante.errors import InputError
from andante.localization import make_tracker
from andante.mapping import Progress, SlowMap
from andante.navigation import (
    CommuteNavigator,
    Goal,
    Limits,
    Localize,
    PlaceGraph,
    PlaceGraphNavigator,
    SlowCost,
    learn_sight,
    tracked,
)
from andante.protocols import Navigator
from andante.recordings import open_recording

_SHOWN_PLACES = 1500


@dataclass(frozen=True, eq=False)
class Steering:
    """Who steers and says where the robot is; mapped ``places_m`` (n, 2), with their ``cost`` (n,) for a gradient."""

    navigator: Navigator
    localize: Localize
    places_m: FloatArray
    cost: FloatArray | None = None

    @property
    def plans(self) -> list[FloatArray]:
        """The ways (m, 2) that were planned so far."""
        return [way for _, way in self.navigator.plans] if isinstance(self.navigator, PlaceGraphNavigator) else []

    @property
    def replans(self) -> int:
        """How often something was in the way of a plan."""
        return self.navigator.replans if isinstance(self.navigator, PlaceGraphNavigator) else 0


def by_graph(slowmap: SlowMap, goal: Goal, limits: Limits, seed: int) -> Steering:
    """Along the ways that the map remembers, with the pose of a tracker; raises as ``PlaceGraph.of`` does."""
    graph = PlaceGraph.of(slowmap)
    localize = tracked(make_tracker(slowmap, seed=seed))
    return Steering(PlaceGraphNavigator(graph, goal.pose, limits), localize, graph.xy_m)


def by_gradient(
    slowmap: SlowMap, goal: Goal, image: ImageArray | None, limits: Limits, progress: Progress | None = None
) -> Steering:
    """Down the slope of slow features that are learnt anew from the longest drive of the map.

    The goal is seen as in ``image``, or as in the picture of that drive that was taken next to it. Raises
    ``InputError`` where none of the map's recordings is where it was.
    """
    there = [source for source in slowmap.sources if source.folder and Path(source.folder).is_dir()]
    if not there:
        raise InputError(
            "the gradient learns from images, and no recording of this map is where it was mapped from; "
            "put one back, or use --navigator graph"
        )
    recording = open_recording(max(there, key=lambda source: source.frames).folder or "")
    sight = learn_sight(recording, progress=progress)
    known = [info for info in recording.infos if info.reference is not None]
    xy = Trajectory.of(known, "reference").xy_m
    if image is None:
        apart = np.hypot(*(xy - (goal.pose.x_m, goal.pose.y_m)).T)
        image = recording.load(known[int(apart.argmin())])
    cost = SlowCost.biharmonic(sight.slow(image), sight.deltas)
    shown = np.unique(np.linspace(0, len(known) - 1, min(len(known), _SHOWN_PLACES)).astype(np.int64))
    costs = np.array([cost.of(sight.slow(recording.load(known[at]))) for at in shown.tolist()])
    return Steering(CommuteNavigator(cost, limits=limits), sight.localize, xy[shown], costs)
