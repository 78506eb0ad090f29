"""Drives to goals: who drives, in which world, and how it went; many at once, in processes."""

from __future__ import annotations

import math
import multiprocessing
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass, replace
from functools import lru_cache

import cv2
import numpy as np

from andante.data import FloatArray, Pose2D
from andante.errors import InputError
from andante.evaluation.experiments.navigation_world import ROBOT_RADIUS_M, Errand
from andante.localization import make_tracker
from andante.mapping import Progress, SlowMap
from andante.navigation import (  # fmt: skip
    CommuteNavigator,
    GradientNavigator,
    GradientSettings,
    Guarded,
    Limits,
    Localize,
    PlaceGraph,
    PlaceGraphNavigator,
    SlowCost,
    SlowSight,
    drive,
    tracked,
)
from andante.navigation.place_graph import length_m
from andante.protocols import Navigator, Observation, VelocityCommand
from andante.sfa import one_thread
from andante.simulator import (
    Conditions,
    GardenSpec,
    OdometryNoise,
    Renderer,
    Scene,
    SimulatedCamera,
    SimulatedRobot,
    make_garden,  # fmt: skip
)

LIMITS = Limits(timeout_s=300.0)
REACH_M = 1.5
_GOAL_PICTURE = 10**6
_USUAL_NOISE = OdometryNoise()
_THESIS_WINDOW_M = 2.0
"""Around obstacles; the thesis does not size it."""


@dataclass(frozen=True)
class World:
    """A garden, how it is seen, and by what; driven in by a robot whose odometry has ``noise``."""

    garden: GardenSpec
    camera: SimulatedCamera
    conditions: Conditions
    noise: OdometryNoise = _USUAL_NOISE
    goal_conditions: Conditions | None = None
    """How it was when the goal was seen; as now where ``None``."""


@dataclass(frozen=True)
class Driver:
    """One way to navigate: which sight it needs, and how to make a navigator from the goal's slow features.

    The place graph needs a map instead, and is told where the goal is. ``aside`` ones show what a part of the method is
    worth, on fewer drives.
    """

    name: str
    sight: str
    make: Callable[[FloatArray, FloatArray, bool], Navigator] | None
    """Slow features of the goal (k,), deltas (k,), whether there is an obstacle."""
    aside: bool = False


@dataclass(frozen=True)
class Task:
    """One drive: ``driver`` by name, with sights that were learnt on a ``lawn`` of this name."""

    driver: str
    lawn: str
    world: World
    errand: Errand
    seed: int


@dataclass(frozen=True, eq=False)
class Result:
    """How a drive ended: how far from the goal, how often something was hit, metres, seconds, and the way (n, 2)."""

    distance_m: float
    hits: int
    way_m: float
    seconds: float
    state: str
    reason: str
    xy_m: FloatArray
    milliseconds: FloatArray


def _thesis(goal: FloatArray, deltas: FloatArray, obstacle: bool) -> Navigator:
    return GradientNavigator(SlowCost.plain(goal), _thesis_settings(obstacle), LIMITS)


def _scaled(goal: FloatArray, deltas: FloatArray, obstacle: bool) -> Navigator:
    cost = SlowCost.commute(goal, deltas).comparable()
    return GradientNavigator(cost, _thesis_settings(obstacle), LIMITS)


def _short(goal: FloatArray, deltas: FloatArray, obstacle: bool) -> Navigator:
    cost = SlowCost.biharmonic(goal, deltas).comparable()
    return GradientNavigator(cost, _thesis_settings(obstacle=True), LIMITS)


def _commute(goal: FloatArray, deltas: FloatArray, obstacle: bool) -> Navigator:
    return CommuteNavigator(SlowCost.commute(goal, deltas), limits=LIMITS)


def _better(goal: FloatArray, deltas: FloatArray, obstacle: bool) -> Navigator:
    return CommuteNavigator(SlowCost.biharmonic(goal, deltas), limits=LIMITS)


def _thesis_settings(obstacle: bool) -> GradientSettings:
    return GradientSettings(window_m=_THESIS_WINDOW_M if obstacle else None)


Sights = Mapping[tuple[str, str], SlowSight | SlowMap]
"""By the name of the lawn and that of the sight, or ``MAP``."""

THESIS, KERNEL, MAP = "thesis", "kernel", "map"
DRIVERS = (
    Driver("thesis' gradient", THESIS, _thesis),
    Driver("thesis' gradient, commute-time scaled", THESIS, _scaled),
    Driver("thesis' gradient, kernel features", KERNEL, _short, aside=True),
    Driver("andante's gradient, thesis' features", THESIS, _better, aside=True),
    Driver("andante's gradient, commute time", KERNEL, _commute, aside=True),
    Driver("andante's gradient", KERNEL, _better),
    Driver("place graph", MAP, None),
)


def run_tasks(
    tasks: Sequence[Task],
    sights: Sights,
    *,
    workers: int = 1,
    progress: Progress | None = None,
) -> list[Result]:
    """Drive all, in order; more than one worker starts processes."""
    found: list[Result] = []
    if workers == 1:
        for task in tasks:
            found.append(_drive(task, sights))
            _tell(progress, len(found), len(tasks))
        return found
    context = multiprocessing.get_context("spawn")
    with ProcessPoolExecutor(workers, context, _begin, (dict(sights),)) as pool:
        for outcome in pool.map(_work, tasks, chunksize=4):
            found.append(outcome)
            _tell(progress, len(found), len(tasks))
    return found


def _tell(progress: Progress | None, done: int, total: int) -> None:
    if progress is not None:
        progress("drives", done, total)


_SIGHTS: dict[tuple[str, str], SlowSight | SlowMap] = {}


def _begin(sights: dict[tuple[str, str], SlowSight | SlowMap]) -> None:
    cv2.setNumThreads(1)
    _SIGHTS.update(sights)


def _work(task: Task) -> Result:
    return _drive(task, _SIGHTS)


def _drive(task: Task, sights: Sights) -> Result:
    driver = next(one for one in DRIVERS if one.name == task.driver)
    world, (x, y) = task.world, task.errand.goal
    with one_thread():
        try:
            navigator, localize = _ready(driver, sights[task.lawn, driver.sight], task)
        except InputError as error:  # a goal where no map is: a drive that did not arrive
            return _stayed(task.errand, str(error))
        robot = WatchedRobot(
            _scene(world.garden),
            Pose2D(*task.errand.start),
            camera=world.camera,
            renderer=_renderer(world.garden, world.camera, world.conditions),
            noise=world.noise,
            radius_m=ROBOT_RADIUS_M,
            range_reach_m=REACH_M,
            seed=task.seed,
        )
        run = drive(robot, localize, navigator)
    way = np.array(robot.xy_m)
    return Result(
        distance_m=float(np.hypot(*(way[-1] - (x, y)))),
        hits=robot.hits,
        way_m=length_m(way),
        seconds=run.seconds,
        state=str(run.outcome),
        reason=run.reason,
        xy_m=way,
        milliseconds=run.milliseconds,
    )


def _stayed(errand: Errand, reason: str) -> Result:
    xy = np.array([errand.start[:2]])
    return Result(math.dist(xy[0], errand.goal), 0, 0.0, 0.0, "refused", reason, xy, np.empty(0))


def _ready(driver: Driver, learnt: SlowSight | SlowMap, task: Task) -> tuple[Navigator, Localize]:
    world, goal = task.world, Pose2D(*task.errand.goal, 0.0)
    if isinstance(learnt, SlowMap):
        inner = PlaceGraphNavigator(PlaceGraph.of(learnt), replace(goal, heading_rad=None), LIMITS)
        return Guarded(inner), tracked(make_tracker(learnt, seed=task.seed))
    assert driver.make is not None
    before = world.goal_conditions or world.conditions
    picture = _renderer(world.garden, world.camera, before).render(goal, _GOAL_PICTURE).image
    return driver.make(learnt.slow(picture), learnt.deltas, bool(world.garden.walls)), learnt.localize


class WatchedRobot(SimulatedRobot):
    """A robot whose true way is written down, for those who judge it."""

    def __init__(self, scene: Scene, start: Pose2D, **options: object) -> None:
        super().__init__(scene, start, **options)  # type: ignore[arg-type]
        self.xy_m = [(self.pose.x_m, self.pose.y_m)]
        self.hits = 0

    def step(self, command: VelocityCommand, duration_s: float) -> Observation:
        """Drive, look, and count."""
        observation = super().step(command, duration_s)
        self.xy_m.append((self.pose.x_m, self.pose.y_m))
        self.hits += observation.bumped
        return observation


@lru_cache(maxsize=4)
def _scene(garden: GardenSpec) -> Scene:
    return Scene.of(make_garden(garden).things)


@lru_cache(maxsize=4)
def _renderer(garden: GardenSpec, camera: SimulatedCamera, conditions: Conditions) -> Renderer:
    return Renderer(_scene(garden), conditions, camera)
