"""A world of which only the truth is known: drives through it, and what a camera and odometry would make of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pytest

from andante.data import Estimate, FrameInfo, Hypothesis, Pose2D, Status, Trajectory
from andante.localization import Evidence
from andante.mapping import SlowMap, build_map
from andante.simulator.odometry import OdometryNoise, drifting

STEP_S, STEP_M = 0.2, 0.14


@dataclass
class World:
    """Slow features are waves over the ground; images err by ``sigma_m``, the same way for a while.

    ``headings`` says whether images tell headings.
    """

    headings: bool = False
    sigma_m: float = 0.04
    waves: np.ndarray = field(default_factory=lambda: np.random.default_rng(3).normal(0, 1.0, (2, 40)))
    phases: np.ndarray = field(default_factory=lambda: np.random.default_rng(4).uniform(0, 6.28, 40))

    def loop(self, n: int = 200, start: int = 0) -> np.ndarray:
        """(n, 3) poses along a rounded loop of about 12 x 8 m."""
        s = STEP_M * (start + np.arange(n + 1)) / 5.0
        xy = np.column_stack([6 * np.cos(s), 4 * np.sin(s) + 0.5 * np.sin(3 * s)])
        ahead = np.diff(xy, axis=0)
        return np.column_stack([xy[:-1], np.arctan2(ahead[:, 1], ahead[:, 0])])

    def infos(self, poses: np.ndarray, *, odometry: Sequence[Pose2D] | None = None, seed: int = 0) -> list[FrameInfo]:
        """Frames in time with drifting odometry, where none is given."""
        times = STEP_S * np.arange(len(poses))
        if odometry is None:
            truth = Trajectory(times, poses[:, :2], poses[:, 2])
            odometry = drifting(truth, OdometryNoise(), np.random.default_rng(seed))
        return [
            FrameInfo(n, f"{n}.png", float(t), odometry=one, reference=Pose2D(*pose))
            for n, (t, one, pose) in enumerate(zip(times, odometry, poses.tolist(), strict=True))
        ]

    def image(self, pose: Sequence[float], rng: np.random.Generator, status: Status = Status.OK) -> Evidence:
        """What an image from a pose says."""
        return self._evidence(pose, rng.normal(0, self.sigma_m, 2), rng, status)

    def images(self, poses: np.ndarray, seed: int = 0) -> list[Evidence]:
        """What images along a way say, with errors that last for about half a metre."""
        rng = np.random.default_rng(seed)
        error, out = rng.normal(0, self.sigma_m, 2), []
        for pose in poses:
            error = 0.8 * error + 0.6 * rng.normal(0, self.sigma_m, 2)
            out.append(self._evidence(pose, error, rng, Status.OK))
        return out

    @staticmethod
    def blank() -> Evidence:
        """A lens that is covered."""
        return Evidence(Estimate(Status.LOST, "the image is black"))

    @staticmethod
    def errors_m(estimates: Sequence[Estimate], infos: Sequence[FrameInfo]) -> np.ndarray:
        """(n,) distances to the truth, NaN without a pose."""
        found = [(np.nan, np.nan) if one.x_m is None else (one.x_m, one.y_m) for one in estimates]
        truth = [(info.reference.x_m, info.reference.y_m) for info in infos]
        return np.hypot(*(np.array(found) - np.array(truth)).T)

    @staticmethod
    def heading_errors_rad(estimates: Sequence[Estimate], infos: Sequence[FrameInfo]) -> np.ndarray:
        """(n,) NaN without a heading."""
        found = np.array([np.nan if one.heading_rad is None else one.heading_rad for one in estimates])
        truth = np.array([info.reference.heading_rad for info in infos])
        return np.abs(np.angle(np.exp(1j * (found - truth))))

    @staticmethod
    def oks(estimates: Sequence[Estimate]) -> np.ndarray:
        """(n,) which are ok."""
        return np.array([one.status == Status.OK for one in estimates])

    @staticmethod
    def in_time(infos: Sequence[FrameInfo]) -> list[FrameInfo]:
        """Frames one after the other, every ``STEP_S``."""
        return [replace(info, index=n, timestamp_s=STEP_S * n) for n, info in enumerate(infos)]

    def _evidence(self, pose: Sequence[float], error: np.ndarray, rng: np.random.Generator, status: Status) -> Evidence:
        xy = np.asarray(pose[:2]) + error
        slow = np.cos(np.asarray(pose[:2]) @ self.waves + self.phases) + rng.normal(0, 0.05, 40)
        heading = float(pose[2] + rng.normal(0, 0.05)) if self.headings else None
        covariance = np.full((3, 3), np.nan)
        covariance[:2, :2] = np.eye(2) * self.sigma_m**2
        if self.headings:
            covariance[2] = covariance[:, 2] = 0.0
            covariance[2, 2] = 0.05**2
        hypotheses = (Hypothesis(float(xy[0]), float(xy[1]), 1.0, heading),)
        if not status.has_pose:
            return Evidence(Estimate(status, "it is not sure", hypotheses=hypotheses), slow)
        radius = 2.146 * self.sigma_m
        estimate = Estimate(status, "", float(xy[0]), float(xy[1]), heading, covariance, radius, hypotheses=hypotheses)
        return Evidence(estimate, slow)


@pytest.fixture(scope="session")
def slowmap(garden: Any) -> SlowMap:
    return build_map(garden.two_days())


@pytest.fixture(scope="session")
def other_map(garden: Any) -> SlowMap:
    return build_map([garden.another_day()])


@pytest.fixture(params=[False, True], ids=["no headings", "headings"])
def world(request: Any) -> World:
    return World(headings=request.param)


@pytest.fixture(params=["particles", "kalman"])
def kind(request: Any) -> str:
    return request.param
