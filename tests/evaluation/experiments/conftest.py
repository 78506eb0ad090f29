"""Tiny experiments: small pictures, few frames, rendered once for all tests."""

import shutil
from pathlib import Path

import pytest

from andante.evaluation.experiments import Scale
from andante.evaluation.experiments.cache import rendered
from andante.evaluation.experiments.plans import COW, GROWING, STATIC, UNSEEN, long_term_plan, single_plan

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
