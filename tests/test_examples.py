"""What the examples are made of; running them whole takes a minute each."""

import importlib.util
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

EXAMPLES = Path(__file__).parents[1] / "examples"


@pytest.fixture(scope="module")
def mow():
    spec = importlib.util.spec_from_file_location("mow", EXAMPLES / "mow.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_lanes_cover_the_lawn_and_no_lane_crosses_what_is_not_mapped(mow):
    x, y = np.meshgrid(np.arange(0, 3, 0.1), np.arange(0, 5, 0.1))
    cells = np.column_stack([x.ravel(), y.ravel()])
    hole = (np.abs(cells - (1.5, 2.5)) < 0.6).all(axis=1)
    lanes = mow.lanes_over(cells[~hole], 0.3)
    assert len(lanes) > 11  # eleven lines, those through the hole in two parts
    line = np.concatenate([np.linspace(*lane, 200) for lane in lanes])
    assert not (np.abs(line - (1.5, 2.5)) < 0.5).all(axis=1).any()
    apart = np.linalg.norm(cells[~hole][:, None] - line[None], axis=-1).min(axis=1)
    assert (apart <= mow.CUT_M / 2).mean() > 0.95


def test_the_next_lane_begins_where_the_last_one_ended(mow):
    x, y = np.meshgrid(np.arange(0, 3, 0.1), np.arange(0, 5, 0.1))
    lanes = mow.lanes_over(np.column_stack([x.ravel(), y.ravel()]), 0.3)
    steps = [np.hypot(*(after[0] - before[1])) for before, after in pairwise(lanes)]
    assert max(steps) < 0.35
