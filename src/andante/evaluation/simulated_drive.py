"""A drive to a goal in a simulated garden, with the truth that the robot was not told."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from andante.data import FloatArray, Pose2D
from andante.errors import InputError
from andante.evaluation.experiments.navigation_trials import REACH_M, WatchedRobot
from andante.evaluation.experiments.navigation_world import ROBOT_RADIUS_M, Lawn
from andante.navigation import Drive, DriveState, Goal, Localize, drive
from andante.navigation.place_graph import length_m
from andante.protocols import Navigator, VelocityCommand, View
from andante.simulator import Conditions, Garden, OdometryNoise, Scene, SimulatedCamera


@dataclass(frozen=True)
class DrivenWorld:
    """A garden, what it is seen with and when, and how much worse than usual odometry is."""

    garden: Garden
    camera: SimulatedCamera
    conditions: Conditions
    odometry_noise: float = 1.0


@dataclass(frozen=True)
class Change:
    """A moment at which the navigator began something else."""

    timestamp_s: float
    state: DriveState
    reason: str


@dataclass(frozen=True, eq=False)
class SimulatedDrive:
    """What the robot knew, ``run``, and how it truly was: ``way_m`` (n + 2, 2), contacts, the shortest way."""

    run: Drive
    goal: Goal
    way_m: FloatArray
    contacts: int
    shortest_m: float
    changes: tuple[Change, ...]

    @property
    def distances_m(self) -> FloatArray:
        """(n + 2,) from the true way to the goal."""
        apart: FloatArray = np.hypot(*(self.way_m - (self.goal.pose.x_m, self.goal.pose.y_m)).T)
        return apart

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return {
            "arrived": self.run.arrived,
            "outcome": str(self.run.outcome),
            "reason": self.run.reason,
            "distance_m": float(self.distances_m[-1]),
            "path_m": length_m(self.way_m),
            "shortest_m": self.shortest_m if math.isfinite(self.shortest_m) else None,
            "seconds": self.run.seconds,
            "collisions": self.contacts,
            "ms_per_step": float(np.median(self.run.milliseconds)),
        }


def drive_in_garden(
    world: DrivenWorld, start: Pose2D, goal: Goal, navigator: Navigator, localize: Localize, *, seed: int = 0
) -> SimulatedDrive:
    """Drive there, with every image rendered where the robot is; ``seed`` decides odometry and sensor noise.

    Raises ``InputError`` for a start inside of something, ``MissingExtraError`` without embreex.
    """
    at = start.x_m, start.y_m
    if world.garden.obstacles.clearance_m([at])[0] < ROBOT_RADIUS_M:
        raise InputError(f"the start ({at[0]:g}, {at[1]:g}) is inside of something; choose another one")
    robot = WatchedRobot(
        Scene.of(world.garden.things),
        start,
        conditions=world.conditions,
        camera=world.camera,
        noise=OdometryNoise().times(world.odometry_noise),
        radius_m=ROBOT_RADIUS_M,
        range_reach_m=REACH_M,
        seed=seed,
    )
    changes = list[Change]()

    def watch(view: View, command: VelocityCommand, state: DriveState) -> None:
        if not changes or (changes[-1].state, changes[-1].reason) != (state, navigator.reason):
            changes.append(Change(view.timestamp_s, state, navigator.reason))

    run = drive(robot, localize, navigator, progress=watch)
    lawn = Lawn(world.garden)
    shortest = lawn.travel_m(np.array([goal.pose.x_m, goal.pose.y_m]))[lawn.nearest(np.array([at]))[0]]
    return SimulatedDrive(run, goal, np.array(robot.xy_m), robot.hits, float(shortest), tuple(changes))
