"""Tiny experiments: small pictures, few frames, rendered once for all tests."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from andante.data import Estimate, FrameInfo, Pose2D, Status
from andante.evaluation.experiments import Scale
from andante.evaluation.experiments.cache import rendered
from andante.evaluation.experiments.plans import COW, GROWING, STATIC, UNSEEN, long_term_plan, single_plan
from andante.evaluation.experiments.rides import Ride
from andante.evaluation.experiments.tracking import learned
from andante.evaluation.experiments.trials import Bench
from andante.localization import Evidence
from andante.mapping import SlowMap

SEED = 5


@pytest.fixture(scope="session")
def embree():
    return pytest.importorskip("embreex", reason="rays need the extra sim: pip install 'andante[sim]'")


@pytest.fixture(scope="session")
def tiny():
    return Scale(frames=70, image_px=64, sessions=3, permutations=2)


@pytest.fixture(scope="session")
def singles(tiny):
    return single_plan(SEED, tiny, (STATIC, GROWING, UNSEEN, COW))


@pytest.fixture(scope="session")
def years(tiny):
    return long_term_plan(SEED, tiny)


@pytest.fixture(scope="session")
def pictures(embree, singles, years, tmp_path_factory) -> Path:
    """A cache with all sessions of both plans and no results."""
    cache = tmp_path_factory.mktemp("pictures")
    for plan in (singles, years):
        rendered(plan, cache)
    return cache


@pytest.fixture
def cache(pictures, tmp_path) -> Path:
    """A copy of it, for one test alone."""
    return Path(shutil.copytree(pictures, tmp_path / "cache"))


def ride_of(poses: np.ndarray, odometry: np.ndarray, *, wait_s: float = 0.2) -> Ride:
    """A ride through poses (n, 3); image k says how many k is."""
    infos = tuple(
        FrameInfo(k, f"{k}.jpg", 100 + wait_s * k, Pose2D(*b.tolist()), Pose2D(*p.tolist()))
        for k, (p, b) in enumerate(zip(poses, odometry, strict=True))
    )
    return Ride(infos, tuple(Evidence(Estimate(Status.OK, "", float(k), 0.0)) for k in range(len(poses))))


def circle(n: int = 40, radius_m: float = 4.0) -> np.ndarray:
    turn = 2 * np.pi * np.arange(n) / n
    return np.stack([radius_m * np.cos(turn), radius_m * np.sin(turn), turn + np.pi / 2], axis=1)


def moved(poses: np.ndarray, x: float, y: float, turn: float) -> np.ndarray:
    cos, sin = np.cos(turn), np.sin(turn)
    xy = poses[:, :2] @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
    return np.column_stack([xy, poses[:, 2] + turn])


@pytest.fixture
def lap() -> Ride:
    """A closed lap of 40 frames around a circle, whose odometry lies in a frame of its own."""
    return ride_of(circle(), moved(circle(), 7, -3, 1.1))


@pytest.fixture(scope="session")
def garden_map(pictures, years, tiny) -> SlowMap:
    """A map of the first session."""
    return learned(Bench(years, pictures), [years.sessions[0].name])
