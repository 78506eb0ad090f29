"""A robot on an empty plane whose slow features are known functions of where it is."""

import numpy as np
import pytest

from andante.data import Estimate, Pose2D, Status
from andante.protocols import View


class PlainRobot:
    """A unicycle; ``slow`` makes features (k,) of a position (2,), ``ahead`` a free way of a pose."""

    def __init__(self, slow, start=(0.0, 0.0, 0.0), *, ahead=None, bump=None, off_map=None, noise=0.0):
        self.pose, self.slow, self.ahead, self.bump, self.off_map = np.array(start, float), slow, ahead, bump, off_map
        self.rng, self.noise = np.random.default_rng(0), noise
        self.time_s, self.track = 0.0, [self.pose.copy()]

    def view(self):
        x, y, heading = (float(value) for value in self.pose)
        slow = np.asarray(self.slow(self.pose[:2]), float)
        strange = self.off_map is not None and self.off_map(self.pose[:2])
        return View(
            self.time_s,
            Estimate(Status.OFF_MAP if strange else Status.LOST, "-"),
            Pose2D(x, y, heading),
            bumped=bool(self.bump is not None and self.bump(self.pose)),
            range_m=None if self.ahead is None else self.ahead(self.pose),
            slow=slow + self.noise * self.rng.standard_normal(slow.shape),
        )

    def drive(self, navigator, steps=3000, step_s=0.2):
        for _ in range(steps):
            command = navigator.command(self.view())
            if navigator.state.over:
                break
            for _ in range(10):
                self.pose[2] += command.turn_rad_s * step_s / 10
                self.pose[:2] += (
                    command.forward_m_s * step_s / 10 * np.array([np.cos(self.pose[2]), np.sin(self.pose[2])])
                )
            self.time_s += step_s
            self.track.append(self.pose.copy())
        return navigator


@pytest.fixture(scope="session")
def plain_robot():
    return PlainRobot
