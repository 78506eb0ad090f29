import numpy as np
import pytest

from andante.errors import LearningError
from andante.landmarks.scoring import fitted


def test_a_score_is_the_share_of_right_places_of_that_heat():
    rng = np.random.default_rng(0)
    heat = rng.normal(0, 2, 20_000)
    right = rng.random(20_000) < 1 / (1 + np.exp(-(1.5 * heat - 1.0)))
    score = fitted(heat, right, 1.0)
    assert (score.slope, score.offset) == pytest.approx((1.5, -1.0), abs=0.1)
    for low in (0.1, 0.4, 0.8):
        near = np.abs(score.of(heat) - low - 0.05) < 0.05
        assert right[near].mean() == pytest.approx(low + 0.05, abs=0.04)


def test_few_wrong_places_reach_the_threshold():
    rng = np.random.default_rng(1)
    heat = np.concatenate([rng.normal(2, 1, 500), rng.normal(-1, 1.5, 1000)])
    right = np.arange(1500) < 500
    for share in (0.1, 0.01):
        score = fitted(heat, right, share)
        assert (score.of(heat[~right]) > score.threshold).mean() <= share
    assert fitted(heat, right, 1.0).threshold == 0.25


def test_what_is_told_apart_completely_has_a_finite_score():
    score = fitted(np.array([5.0, 4.0, 4.5, -6.0, -7.0]), np.array([1, 1, 1, 0, 0], bool), 0.005)
    assert score.of(np.array([4.5]))[0] == pytest.approx(0.8, abs=0.1)  # Platt's targets: 4/5 and 1/4
    assert np.isfinite([score.slope, score.offset, score.threshold]).all()


@pytest.mark.parametrize("right", [[True, True], [False, False], [False, True]])
def test_what_cannot_be_told_apart_is_said(right):
    with pytest.raises(LearningError, match=r"right and . wrong places on held-out pictures cannot be told apart"):
        fitted(np.array([1.0, 0.5]), np.array(right), 0.01)
