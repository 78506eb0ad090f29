"""What held-out frames promise: coverage, folds, thresholds."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from andante.errors import LearningError
from andante.mapping.calibration import Calibration, calibrate, conformal_factor
from andante.mapping.config import CalibrationConfig
from andante.mapping.folds import Folds
from andante.mapping.learning import Ground
from andante.mapping.located import Located

CONFIG = CalibrationConfig()


def ground(sessions: list[int], step_m: float = 0.2) -> Ground:
    """Straight drives of so many frames each."""
    xy = np.concatenate([np.column_stack([step_m * np.arange(n), np.zeros(n)]) for n in sessions])
    return Ground(xy, np.repeat(np.arange(len(sessions)), sessions), np.arange(len(xy)), 0.5)


def located(xy: np.ndarray, sigma: float = 1.0, agreement: float = 1.0) -> Located:
    n = len(xy)
    covariance = np.tile(np.eye(2) * sigma**2 / 2, (n, 1, 1))
    ones = np.ones(n)
    return Located(xy, covariance, ones, agreement * ones, np.empty((n, 0, 2)), np.empty((n, 0)), ones)


def tried(where: Ground, names: list[str], locate_fold) -> Calibration:
    """Calibrated on all folds."""
    return calibrate(where, Folds.of(where, names, CONFIG), locate_fold, CONFIG.coverage)


class Locator:
    """Answers with the truth plus an offset that depends on the session, and remembers what it was asked."""

    def __init__(self, where: Ground, offset_m: float = 0.1) -> None:
        self.where, self.offset_m, self.folds = where, offset_m, []

    def __call__(self, train, test):
        self.folds.append((train, test))
        n = int(test.sum())
        return located(self.where.xy[test] + [self.offset_m, 0]), np.linspace(0, 0.5, n)


@given(
    hnp.arrays(np.float64, st.integers(1, 50), elements=st.floats(0.01, 100)),
    st.floats(0.01, 0.99),
    st.randoms(use_true_random=False),
)
def test_the_conformal_factor_covers_its_share_of_any_frame_left_out(errors, coverage, random):
    """Leave each frame out in turn: of n + 1 exchangeable frames, at least the share lies within the factor."""
    shuffled = list(errors)
    random.shuffle(shuffled)
    n = len(shuffled)
    inside = [
        shuffled[i] <= conformal_factor(np.array(shuffled[:i] + shuffled[i + 1 :]), np.ones(n - 1), coverage)
        for i in range(n)
        if n > 1 and np.ceil(n * coverage) <= n - 1
    ]
    if inside:
        assert np.mean(inside) >= coverage - 1e-12


def test_the_conformal_factor_is_the_promised_order_statistic():
    scores = np.arange(1.0, 100.0)
    assert conformal_factor(2 * scores, np.full(99, 2.0), 0.9) == 90
    assert conformal_factor(scores[:5], np.ones(5), 0.9) == 5  # too few frames to promise more than the worst


def test_coverage_holds_for_new_frames():
    rng = np.random.default_rng(0)
    covered = [
        np.mean(rng.exponential(size=200) <= conformal_factor(rng.exponential(size=60), np.ones(60), 0.9))
        for _ in range(200)
    ]
    assert np.mean(covered) == pytest.approx(0.905, abs=0.02)


def test_folds_are_held_out_and_named():
    where = ground([40, 30, 20])
    locator = Locator(where)
    folds = Folds.of(where, ["a", "b", "c"], CONFIG)
    result = calibrate(where, folds, locator, CONFIG.coverage)
    assert result.kind == "sessions"
    assert [fold.left_out for fold in result.folds] == ["a", "b", "c"]
    assert [fold.sessions for fold in result.folds] == [(0,), (1,), (2,)]
    assert [fold.n for fold in result.folds] == [40, 30, 20]
    np.testing.assert_array_equal(locator.folds, list(folds))


def test_blocks_cover_one_session():
    where = ground([200])
    locator = Locator(where)
    result = tried(where, ["a"], locator)
    assert result.kind == "blocks"
    assert {fold.sessions for fold in result.folds} == {(0,)}
    assert sum(fold.n for fold in result.folds) == 200
    np.testing.assert_array_equal(np.sum([test for _, test in locator.folds], axis=0), 1)


def test_a_drive_shorter_than_a_block_cannot_be_tried():
    where = ground([10], step_m=0.01)
    assert tried(where, ["a"], Locator(where)).kind == "none"


def test_folds_that_cannot_learn_say_nothing():
    where = ground([40, 40])
    locator = Locator(where)

    def fails_without_the_first(train, test):
        if test[0]:
            raise LearningError("too few")
        return locator(train, test)

    assert [fold.left_out for fold in tried(where, ["a", "b"], fails_without_the_first).folds] == ["b"]

    def fails(train, test):
        raise LearningError("too few")

    assert tried(where, ["a", "b"], fails).kind == "none"


def test_figures_of_a_fold():
    where = ground([40, 40])
    fold = tried(where, ["a", "b"], Locator(where, 0.3)).folds[0]
    assert (fold.median, fold.mean, fold.p95, fold.max) == pytest.approx((0.3, 0.3, 0.3, 0.3))


def test_radius_and_thresholds():
    where = ground([40, 40])
    result = tried(where, ["a", "b"], Locator(where, 0.3))
    assert result.radius_factor == pytest.approx(0.3)
    assert 0 < result.off_map_below < result.degraded_below <= 0.5
    assert result.lost_below == 0.5


def test_readouts_without_strangers_are_never_off_the_map():
    where = ground([40, 40])
    result = tried(where, ["a", "b"], lambda train, test: (located(where.xy[test]), np.empty(0)))
    assert (result.off_map_below, result.degraded_below) == (0, 0)
