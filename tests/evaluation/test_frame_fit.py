import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.evaluation.frame_fit import fit_robustly


@given(st.floats(-3, 3), st.floats(-20, 20), st.floats(-20, 20), st.integers(0, 9))
def test_found_although_many_are_far_off(turn, x, y, seed):
    rng = np.random.default_rng(seed)
    mapped = rng.uniform(-5, 5, (30, 2))
    cos, sin = np.cos(turn), np.sin(turn)
    truth = mapped @ np.array([[cos, sin], [-sin, cos]]) + (x, y)
    mapped[:10] += rng.uniform(3, 30, (10, 2))
    mapped[29] = np.nan
    found = fit_robustly(mapped, truth, "half")
    assert abs(np.angle(np.exp(1j * (found.rotation_rad - turn)))) < 1e-6
    assert np.allclose(found.out_of_map(mapped[10:29]), truth[10:29], atol=1e-6)
    assert found.residual_m == pytest.approx(0, abs=1e-6)


@pytest.mark.parametrize("mapped", [np.full((9, 2), np.nan), np.ones((9, 2)), np.zeros((2, 2))])
def test_nothing_to_fit(mapped):
    assert fit_robustly(mapped, np.arange(2.0 * len(mapped)).reshape(-1, 2), "half") is None
