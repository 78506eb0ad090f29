"""Robots and localizers that cost nothing, so that whole drives take milliseconds."""

import numpy as np
import pytest

from andante.data import CameraSpec, Estimate, Pose2D, Status
from andante.protocols import Observation

PANORAMA = CameraSpec(model="panorama")
IMAGE = np.zeros((2, 4), np.uint8)


class FlatRobot:
    """A disc on a plain with walls [(x0, y0, x1, y1), ...]; its odometry begins at zero and is true but for ``drift``.

    Never closer than 0.2 m to a wall; ``range_m`` is the free way ahead up to ``reach_m``.
    """

    camera = PANORAMA

    def __init__(self, start, walls=(), drift=1.0, reach_m=None):
        self.pose, self.time_s = np.array(start, float), 0.0
        self._start, self._drift, self._reach_m = self.pose.copy(), drift, reach_m
        self._walls = np.array(walls, float).reshape(-1, 4)
        self.poses, self.bumps = [], 0

    def room_m(self, xy):
        a, b = self._walls[:, :2], self._walls[:, 2:]
        along = np.clip(((xy - a) * (b - a)).sum(1) / np.maximum(((b - a) ** 2).sum(1), 1e-12), 0, 1)
        return np.hypot(*(a + along[:, None] * (b - a) - xy).T).min(initial=np.inf) - 0.2

    def step(self, command, duration_s):
        bumped = False
        for _ in range(8):
            x, y, heading = self.pose
            middle = heading + command.turn_rad_s * duration_s / 16
            ahead = np.array([x, y]) + command.forward_m_s * duration_s / 8 * np.array([np.cos(middle), np.sin(middle)])
            free = self.room_m(ahead) >= min(0.0, self.room_m(self.pose[:2]))
            bumped |= not free
            self.pose[:2] = ahead if free else self.pose[:2]
            self.pose[2] += command.turn_rad_s * duration_s / 8
        self.time_s += duration_s
        self.poses.append(self.pose.copy())
        self.bumps += bumped
        return Observation(self.time_s, IMAGE, self._odometry(), bumped, self._range_m())

    def _odometry(self):
        cos, sin = np.cos(self._start[2]), np.sin(self._start[2])
        dx, dy = self._drift * (self.pose[:2] - self._start[:2])
        return Pose2D(cos * dx + sin * dy, cos * dy - sin * dx, self.pose[2] - self._start[2])

    def _range_m(self):
        if self._reach_m is None:
            return None
        ahead = np.array([np.cos(self.pose[2]), np.sin(self.pose[2])])
        ways = np.arange(0.0, self._reach_m, 0.02)
        least = min(0.05, self.room_m(self.pose[:2]) - 0.005)
        blocked = [way for way in ways if self.room_m(self.pose[:2] + way * ahead) < least]
        return blocked[0] if blocked else self._reach_m


class Truth:
    """The true pose with some noise, without it where ``lost(time)`` says so; ``heading`` may be unknown."""

    def __init__(self, robot, sigma_m=0.0, sigma_rad=0.0, lost=lambda time_s: False, heading=True, seed=0):
        self._robot, self._sigma_m, self._sigma_rad = robot, sigma_m, sigma_rad
        self._lost, self._heading, self._rng = lost, heading, np.random.default_rng(seed)

    def __call__(self, observation):
        if self._lost(observation.timestamp_s):
            return Estimate(Status.LOST, "for a test"), None
        x, y = self._robot.pose[:2] + self._rng.normal(0, self._sigma_m, 2)
        heading = self._robot.pose[2] + self._rng.normal(0, self._sigma_rad) if self._heading else None
        return Estimate(Status.OK, "", float(x), float(y), heading, None, 2 * self._sigma_m), None


@pytest.fixture(scope="session")
def flat_robot():
    return FlatRobot


@pytest.fixture(scope="session")
def truth():
    return Truth
