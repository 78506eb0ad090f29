"""The same features as MDP 3.6, which the thesis used, on series from closed formulas.

The numbers come from ``benchmarks/mdp_oracle.py``, which has to run in an environment of its own.
"""

import json
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from andante.sfa import LinearSFA, QuadraticSFA

ORACLE = json.loads((Path(__file__).parent / "data" / "mdp_oracle.json").read_text())


def series():
    t, j = np.arange(ORACLE["samples"])[:, None], np.arange(ORACLE["signals"])[None, :]
    slow = np.sin(0.011 * (j + 1) * t + j)
    fast = 0.5 * np.sin((0.37 + 0.113 * j) * t)
    return slow + fast + 0.3 * np.sin(0.0007 * (j + 1) * t * t)


def estimators():
    return {
        "linear": LinearSFA(4),
        "linear_episodes": LinearSFA(4),
        "quadratic": QuadraticSFA(4, reduced_dim=ORACLE["reduced"]),
    }


def test_the_series_is_the_one_the_oracle_saw():
    assert np.abs(series()).sum() == pytest.approx(ORACLE["checksum"], rel=1e-12)


@pytest.mark.parametrize("case", ["linear", "linear_episodes", "quadratic"])
def test_deltas_and_outputs_agree_with_mdp(case):
    x, bounds = series(), ORACLE["episodes"]
    data = [x[a:b] for a, b in pairwise(bounds)] if case == "linear_episodes" else x
    estimator = estimators()[case].fit(data)
    np.testing.assert_allclose(estimator.deltas_, ORACLE[case]["deltas"], rtol=1e-9)
    outputs, theirs = estimator.transform(x)[ORACLE["rows"]], np.array(ORACLE[case]["outputs"])
    signs = np.sign((outputs * theirs).sum(axis=0))
    np.testing.assert_allclose(outputs * signs, theirs, atol=1e-8)
