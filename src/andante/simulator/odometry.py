"""Odometry that drifts: wheels that slip, wheels of unknown size, a gyro with a bias."""

from __future__ import annotations

from typing import Annotated

import numpy as np
from pydantic import Field

from andante.data import Pose2D, Trajectory
from andante.simulator.settings import Settings

_Deviation = Annotated[float, Field(ge=0, le=1)]


class OdometryNoise(Settings):
    """Standard deviations; scale and gyro bias are drawn once a drive, the others at every step.

    ``wheel_m`` grows with the square root of the way (per square root of a metre), ``turn_rad`` with that of the turn.
    """

    scale: _Deviation = 0.01
    gyro_rad_s: _Deviation = 0.003
    wheel_m: _Deviation = 0.01
    turn_rad: _Deviation = 0.01

    def times(self, factor: float) -> OdometryNoise:
        """The same, so many times as large; raises ``ConfigError`` for more than is allowed."""
        return OdometryNoise(**{name: value * factor for name, value in self.model_dump().items()})


class Odometer:
    """Adds up noisy steps from (0, 0, 0) in a frame of its own."""

    def __init__(self, noise: OdometryNoise, rng: np.random.Generator) -> None:
        self._noise, self._rng = noise, rng
        self._scale = 1.0 + rng.normal(0.0, noise.scale)
        self._bias_rad_s = rng.normal(0.0, noise.gyro_rad_s)
        self.pose = Pose2D(0.0, 0.0, 0.0)

    def advance(self, forward_m: float, left_m: float, turn_rad: float, duration_s: float) -> Pose2D:
        """One true step, in the robot's frame before it -> where the robot believes to be, heading not wrapped."""
        noise, rng = self._noise, self._rng
        way = np.hypot(forward_m, left_m)
        slip = 1.0 + rng.normal(0.0, noise.wheel_m) / np.sqrt(max(way, 1e-3))
        turn = turn_rad + self._bias_rad_s * duration_s + rng.normal(0.0, noise.turn_rad) * np.sqrt(abs(turn_rad))
        heading = self.pose.heading_rad or 0.0
        error = (turn - turn_rad) / 2.0  # the step is taken half-way through its turn
        cos, sin = np.cos(heading + error), np.sin(heading + error)
        forward, left = forward_m * self._scale * slip, left_m * self._scale * slip
        self.pose = Pose2D(
            float(self.pose.x_m + cos * forward - sin * left),
            float(self.pose.y_m + sin * forward + cos * left),
            float(heading + turn),
        )
        return self.pose


def drifting(truth: Trajectory, noise: OdometryNoise, rng: np.random.Generator) -> list[Pose2D]:
    """The odometry of a whole drive, one pose for each of the true ones."""
    odometer = Odometer(noise, rng)
    poses = [odometer.pose]
    steps, durations = np.diff(truth.xy_m, axis=0), np.diff(truth.timestamp_s)
    turns = np.mod(np.diff(truth.heading_rad) + np.pi, 2.0 * np.pi) - np.pi
    for (dx, dy), heading, turn, duration in zip(steps, truth.heading_rad, turns, durations, strict=False):
        cos, sin = np.cos(heading), np.sin(heading)
        poses.append(odometer.advance(cos * dx + sin * dy, cos * dy - sin * dx, float(turn), float(duration)))
    return poses
