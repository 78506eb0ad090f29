"""What held-out frames promise: coverage, folds, thresholds."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from andante.errors import LearningError
from andante.mapping.calibration import Calibration, calibrate, conformal_factor
from andante.mapping.compass import Bearings
from andante.mapping.config import CalibrationConfig
from andante.mapping.folds import Folds
from andante.mapping.learning import Ground
from andante.mapping.located import Located
from andante.mapping.locating import Sighting, doubt_of

CONFIG = CalibrationConfig()


def ground(sessions: list[int], step_m: float = 0.2) -> Ground:
    """Straight drives of so many frames each."""
    xy = np.concatenate([np.column_stack([step_m * np.arange(n), np.zeros(n)]) for n in sessions])
    return Ground(xy, np.repeat(np.arange(len(sessions)), sessions), np.arange(len(xy)), 0.5)


def sighted(xy: np.ndarray, sigma: float = 1.0, agreement: float = 1.0, bearings: Bearings | None = None) -> Sighting:
    n = len(xy)
    covariance = np.tile(np.eye(2) * sigma**2 / 2, (n, 1, 1))
    ones = np.ones(n)
    located = Located(xy, covariance, ones, agreement * ones, np.empty((n, 0, 2)), np.empty((n, 0)), ones)
    return Sighting(located, ones, located.sigma * doubt_of(bearings, n), bearings)


def tried(where: Ground, names: list[str], locate_fold, heading: np.ndarray | None = None) -> Calibration:
    """Calibrated on all folds; headings are not known where none are given."""
    heading = np.full(len(where), np.nan) if heading is None else heading
    return calibrate(where, heading, Folds.of(where, names, CONFIG), locate_fold, CONFIG.coverage)


class Locator:
    """Answers with the truth plus an offset that depends on the session, and remembers what it was asked."""

    def __init__(self, where: Ground, offset_m: float = 0.1) -> None:
        self.where, self.offset_m, self.folds = where, offset_m, []

    def __call__(self, train, test):
        self.folds.append((train, test))
        n = int(test.sum())
        return sighted(self.where.xy[test] + [self.offset_m, 0]), np.linspace(0, 0.5, n)


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
    result = calibrate(where, np.full(90, np.nan), folds, locator, CONFIG.coverage)
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
    *blocks, _ = locator.folds
    np.testing.assert_array_equal(np.sum([test for _, test in blocks], axis=0), 1)


def test_what_one_session_promises_comes_from_every_third_frame():
    """Between two frames of a drive, that is, which lie nearer than the next block; another drive is farther off."""
    where = ground([201])
    asked = []

    def near_and_far(train, test):
        asked.append((train, test))
        third = test.sum() == 67
        return sighted(where.xy[test] + [0.02 if third else 5.0, 0]), np.full(int(test.sum()), 0.3 if third else 0.6)

    result = tried(where, ["a"], near_and_far)
    train, test = asked[-1]
    np.testing.assert_array_equal(np.flatnonzero(test), np.arange(1, 201, 3))
    np.testing.assert_array_equal(train, ~test)
    assert 1 <= result.radius_factor / 0.02 <= 3
    # The errors that are shown, and what is foreign, remain those of the blocks.
    assert [fold.median for fold in result.folds] == pytest.approx([5.0] * len(result.folds))
    assert result.off_map_below == pytest.approx(0.6)


def test_several_sessions_are_not_thinned():
    where = ground([40, 40])
    locator = Locator(where)
    tried(where, ["a", "b"], locator)
    assert len(locator.folds) == 2


def test_one_session_of_which_no_third_can_be_learnt_promises_what_its_blocks_do():
    where = ground([201])
    locator = Locator(where, 0.3)

    def not_by_thirds(train, test):
        if test.sum() == 67:
            raise LearningError("too few")
        return locator(train, test)

    assert 0.3 <= tried(where, ["a"], not_by_thirds).radius_factor <= 3 * 0.3


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
    assert result.usual_likeness == 1.0


def test_readouts_without_strangers_are_never_off_the_map():
    where = ground([40, 40])
    result = tried(where, ["a", "b"], lambda train, test: (sighted(where.xy[test]), np.empty(0)))
    assert (result.off_map_below, result.degraded_below) == (0, 0)


def with_headings(where: Ground, truth: np.ndarray, off: np.ndarray, peak: np.ndarray):
    """A locator whose headings are off by so much, as alike as ``peak`` says."""

    def locate(train, test):
        # Brought into one turn, as a compass does it.
        heading = np.mod(truth[test] + off[test] + np.pi, 2 * np.pi) - np.pi
        bearings = Bearings(heading, peak[test], np.zeros(int(test.sum())))
        return sighted(where.xy[test], bearings=bearings), np.zeros(int(test.sum()))

    return locate


@given(st.integers(0, 2**32 - 1))
def test_the_heading_factor_covers_its_share_of_held_out_frames(seed):
    """Whatever their doubt, on both sides of the seam, and with the headings left out that nobody knows."""
    rng = np.random.default_rng(seed)
    where = ground([60, 50])
    truth, peak = rng.uniform(-4, 4, 110), rng.uniform(0.2, 1, 110)
    doubt = doubt_of(Bearings(truth, peak, peak), 110)
    off = rng.normal(0, 0.02, 110) * doubt
    off[rng.random(110) < 0.1] = np.nan
    told = np.where(rng.random(110) < 0.1, np.nan, truth)
    result = tried(where, ["a", "b"], with_headings(where, truth, off, peak), told)
    known = np.isfinite(off + told)
    covered = np.abs(off[known]) <= result.heading_factor * doubt[known] * (1 + 1e-9)
    assert CONFIG.coverage <= covered.mean() <= CONFIG.coverage + 0.03


def test_the_radius_leaves_to_the_factor_what_doubt_does_not_explain():
    where, zeros = ground([40, 40]), np.zeros(80)

    def doubted(train, test):
        bearings = Bearings(zeros[test], np.full(int(test.sum()), 0.5), zeros[test])
        sighting = sighted(where.xy[test] + [0.3, 0], bearings=bearings)
        assert sighting.doubt.min() > 1.5
        return replace(sighting, sigma=sighting.doubt), np.zeros(int(test.sum()))

    doubt = doubt_of(Bearings(zeros[:1], np.array([0.5]), zeros[:1]), 1)[0]
    assert tried(where, ["a", "b"], doubted).radius_factor == pytest.approx(0.3 / doubt)


@pytest.mark.parametrize("unknown", ["truth", "compass", "bearings"])
def test_no_heading_no_factor(unknown):
    where = ground([40, 40])
    truth, nothing = np.zeros(80), np.full(80, np.nan)
    locate = {
        "truth": with_headings(where, truth, truth, np.ones(80)),
        "bearings": with_headings(where, truth, nothing, np.ones(80)),
        "compass": Locator(where),
    }[unknown]
    result = tried(where, ["a", "b"], locate, nothing if unknown == "truth" else truth)
    assert result.heading_factor is None
