"""The extended Kalman filter against its definition."""

import math

import numpy as np
import pytest

from andante.data import Fix
from andante.localization.config import KalmanConfig
from andante.localization.filters import Gauss, Weighted
from andante.localization.kalman_filter import KalmanFilter, moved
from andante.localization.motion import Step
from andante.localization.sighting import sighting_of_fix
from andante.localization.trail import Trail

CONFIG = KalmanConfig()


def seen(x, y, sigma=0.1, share=1.0):
    sighting = sighting_of_fix(Fix(x, y, sigma))
    return [Weighted(sighting, 1.0, share, sighting.floor, contradicts=False)]


def begun(x=0.0, y=0.0):
    one = KalmanFilter(CONFIG)
    one.correct(seen(x, y), Trail.empty(), doubt=0.0)
    return one


def test_a_correction_is_the_textbooks():
    one = KalmanFilter(CONFIG)
    rng = np.random.default_rng(0)
    root = rng.normal(size=(3, 3)) * 0.1
    mean, covariance = np.array([1.0, 2.0, 0.3]), root @ root.T + 1e-4 * np.eye(3)
    one.resume({"mean": mean, "covariance": covariance, "rejected": np.zeros(1)}, None)
    one.correct(seen(1.05, 1.98, sigma=0.08, share=0.25), Trail.empty(), doubt=0.0)
    rows, noise = np.eye(3)[:2], np.eye(2) * 0.08**2 / 0.25
    gain = covariance @ rows.T @ np.linalg.inv(rows @ covariance @ rows.T + noise)
    assert one.best.mean == pytest.approx(mean + gain @ (np.array([1.05, 1.98]) - mean[:2]))
    assert one.best.covariance == pytest.approx((np.eye(3) - gain @ rows) @ covariance)


def test_the_prediction_is_that_of_many_particles():
    rng = np.random.default_rng(0)
    gauss = Gauss(np.array([0.0, 0.0, 0.5]), np.diag([0.01, 0.01, 0.003]))
    sample = rng.multivariate_normal(gauss.mean, gauss.covariance, 50_000)
    step = Step(0.4, 0.05, 0.2, 0.5)
    after = moved(gauss, step, CONFIG.motion)
    cos, sin = np.cos(sample[:, 2]), np.sin(sample[:, 2])
    sample[:, 0] += cos * step.forward_m - sin * step.left_m
    sample[:, 1] += sin * step.forward_m + cos * step.left_m
    sample[:, 2] += step.turn_rad
    assert after.mean == pytest.approx(sample.mean(axis=0), abs=0.005)
    grown = after.covariance - np.cov(sample.T)
    assert np.linalg.eigvalsh(grown)[0] > -2e-4  # noise only adds
    assert np.trace(grown) < 0.05


def test_drift_grows_and_rest_changes_nothing():
    gauss = Gauss(np.zeros(3), np.diag([0.01, 0.01, 0.01]))
    assert moved(gauss, Step(duration_s=9.0), CONFIG.motion) is gauss
    spread = [gauss]
    for _ in range(100):
        spread.append(moved(spread[-1], Step(0.14, 0.0, 0.01, 0.2), CONFIG.motion))
    variances = [np.trace(one.covariance) for one in spread]
    assert variances == sorted(variances)
    walk = moved(gauss, Step(duration_s=4.0, known=False), CONFIG.motion).covariance - gauss.covariance
    assert np.diag(walk) == pytest.approx([4 * CONFIG.motion.walk_m**2] * 2 + [4 * CONFIG.motion.walk_rad**2])


def test_three_rejections_that_agree_begin_anew():
    one, trail = begun(), Trail.empty()
    for n in range(3):
        trail = trail.moved(Step(0.35)).with_place(9.0 + 0.35 * n, 0.0)
        one.move(Step(0.35))
        one.correct(seen(9.0 + 0.35 * n, 0.0), trail, doubt=0.0)
        assert one.best.mean[0] < 2 if n < 2 else one.best.mean[0] == pytest.approx(9.7)
    assert one.belief.moved_m > 8
    assert one.best.heading_known


def test_rejections_that_contradict_each_other_do_not():
    one, trail = begun(), Trail.empty()
    for x in (9.0, -7.0, 15.0, 4.0, -12.0):
        trail = trail.moved(Step(0.2)).with_place(x, 0.0)
        one.move(Step(0.2))
        one.correct(seen(x, 0.0), trail, doubt=0.0)
    assert abs(one.best.mean[0]) < 2


def test_without_a_heading_it_goes_anywhere_until_the_way_tells():
    one, trail = KalmanFilter(CONFIG), Trail.empty()
    for n in range(6):
        step = Step(0.2) if n else Step()
        trail = trail.moved(step).with_place(0.0, 0.2 * n)
        one.move(step)
        one.correct(seen(0.0, 0.2 * n, sigma=0.02), trail, doubt=0.0)
        if n == 1:
            assert one.hypotheses[0].heading_rad is None
    assert one.hypotheses[0].heading_rad == pytest.approx(math.pi / 2, abs=0.1)


def test_a_sighting_that_is_no_news_changes_nothing():
    one = begun()
    before = one.best
    one.correct(seen(0.1, 0.0, share=0.0), Trail.empty(), doubt=0.0)
    assert one.best is before


@pytest.mark.parametrize(
    "arrays",
    [
        {"mean": np.zeros(3)},
        {"mean": np.zeros(2), "covariance": np.eye(3), "rejected": np.zeros(1)},
        {"mean": np.zeros(3), "covariance": -np.eye(3), "rejected": np.zeros(1)},
        {"mean": np.zeros(3), "covariance": np.triu(np.ones((3, 3))), "rejected": np.zeros(1)},
    ],
)
def test_arrays_that_are_no_state_of_it(arrays):
    with pytest.raises(ValueError, match="covariance"):
        KalmanFilter(CONFIG).resume(arrays, None)
