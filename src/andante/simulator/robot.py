"""A robot in the garden that drives on command, looks, and bumps into things."""

from __future__ import annotations

import numpy as np

from andante.data import CameraSpec, Pose2D
from andante.errors import ConfigError
from andante.protocols import Observation, VelocityCommand
from andante.simulator.camera import SimulatedCamera
from andante.simulator.conditions import Conditions
from andante.simulator.garden import Scene
from andante.simulator.odometry import Odometer, OdometryNoise
from andante.simulator.render import Renderer

_SUBSTEP_M = 0.02
_SUBSTEP_RAD = 0.05


class SimulatedRobot:
    """Implements ``Robot``: a disc of ``radius_m`` that never enters an obstacle, and can leave one it is in.

    With ``range_reach_m`` it has a range sensor that looks straight ahead so far, as wide as the robot and
    ``range_margin_m`` more on either side. ``pose`` is where it really is, which a program under test must not ask.
    Many drives in one scene share a ``renderer``, which takes half a second to make; it decides about conditions and
    the noise of images. Raises ``MissingExtraError`` without embreex.
    """

    def __init__(
        self,
        scene: Scene,
        start: Pose2D,
        *,
        conditions: Conditions | None = None,
        camera: SimulatedCamera | None = None,
        noise: OdometryNoise | None = None,
        radius_m: float = 0.2,
        range_reach_m: float | None = None,
        range_margin_m: float = 0.05,
        renderer: Renderer | None = None,
        seed: int = 0,
    ) -> None:
        self._obstacles = scene.obstacles
        self._radius_m = radius_m
        self._range_reach_m, self._range_margin_m = range_reach_m, range_margin_m
        self._camera = camera or SimulatedCamera()
        self._renderer = renderer or Renderer(scene, conditions or Conditions(), self._camera, seed)
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(40,)))
        self._odometer = Odometer(noise or OdometryNoise(), rng)
        self.pose = Pose2D(start.x_m, start.y_m, start.heading_rad or 0.0)
        self._time_s = 0.0
        self._steps = 0

    @property
    def camera(self) -> CameraSpec:
        """The camera on the robot."""
        return self._camera.spec

    @property
    def stuck(self) -> bool:
        """Whether the robot is inside of something."""
        return self._room_m(self.pose.x_m, self.pose.y_m) < 0.0

    def step(self, command: VelocityCommand, duration_s: float) -> Observation:
        """Drive for ``duration_s`` seconds, or until something is in the way, then look.

        ``bumped`` is true where the way was blocked or the robot is inside of something. Raises ``ConfigError`` for a
        duration or a command that is not finite and for a negative duration.
        """
        if not np.isfinite([duration_s, command.forward_m_s, command.turn_rad_s]).all() or duration_s < 0.0:
            raise ConfigError(f"a step needs finite numbers and a duration_s of 0 or more, got {command}, {duration_s}")
        bumped = self._drive(command, duration_s)
        self._time_s += duration_s
        self._steps += 1
        image = self._renderer.render(self.pose, self._steps).image
        return Observation(self._time_s, image, self._odometer.pose, bumped or self.stuck, self._range_m())

    def _drive(self, command: VelocityCommand, duration_s: float) -> bool:
        """Small arcs, so that nothing is jumped over; returns whether one was blocked."""
        way, turn = command.forward_m_s * duration_s, command.turn_rad_s * duration_s
        parts = max(int(np.ceil(max(abs(way) / _SUBSTEP_M, abs(turn) / _SUBSTEP_RAD))), 1)
        blocked = False
        for _ in range(parts):
            heading = self.pose.heading_rad or 0.0
            middle = heading + turn / parts / 2.0
            x = self.pose.x_m + np.cos(middle) * way / parts
            y = self.pose.y_m + np.sin(middle) * way / parts
            room = self._room_m(x, y)
            # Inside of something only a way out is open: towards more room.
            free = bool(room >= 0.0 or room > self._room_m(self.pose.x_m, self.pose.y_m))
            blocked |= not free
            forward = way / parts if free else 0.0
            if free:
                self.pose = Pose2D(float(x), float(y), heading)
            self.pose = Pose2D(self.pose.x_m, self.pose.y_m, heading + turn / parts)
            half = turn / parts / 2.0
            self._odometer.advance(forward * np.cos(half), forward * np.sin(half), turn / parts, duration_s / parts)
        return blocked

    def _range_m(self) -> float | None:
        if self._range_reach_m is None:
            return None
        at, heading = (self.pose.x_m, self.pose.y_m), self.pose.heading_rad or 0.0
        radius = self._radius_m + self._range_margin_m
        return self._obstacles.free_way_m(at, heading, radius_m=radius, reach_m=self._range_reach_m)

    def _room_m(self, x_m: float, y_m: float) -> float:
        return float(self._obstacles.clearance_m([(x_m, y_m)])[0]) - self._radius_m
