import numpy as np
import pytest

from andante.navigation.slope import SlopeWindow

JACOBIAN = np.array([[1.0, 0.2], [0.3, -2.0], [0.0, 0.5]])
GOAL = np.array([2.0, -1.0])


def filled(window, positions, *, noise=0.0, outliers=(), seed=0):
    rng = np.random.default_rng(seed)
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(positions, axis=0), axis=1))])
    for number, (here, at) in enumerate(zip(positions, way, strict=True)):
        offset = JACOBIAN @ (here - GOAL) + noise * rng.standard_normal(3)
        window.append(here, offset + (5.0 if number in outliers else 0.0), float(at))
    return window.slope(positions[-1])


def arc(count=20, radius=0.35):
    angle = np.linspace(0.0, 3.5, count)
    return radius * np.column_stack([np.sin(angle), 1 - np.cos(angle)])


def test_linear_features_give_their_derivative_and_the_goal():
    slope = filled(SlopeWindow(), arc())
    here = arc()[-1]
    np.testing.assert_allclose(slope.jacobian, JACOBIAN, atol=0.05)
    np.testing.assert_allclose(slope.gradient, JACOBIAN.T @ JACOBIAN @ (here - GOAL), rtol=0.05)
    np.testing.assert_allclose(slope.to_goal_m, GOAL - here, atol=0.3)  # damped
    assert slope.cost == pytest.approx(np.linalg.norm(JACOBIAN @ (here - GOAL)), rel=0.03)


def test_one_blinded_image_changes_little():
    clean, blinded = (filled(SlopeWindow(), arc(30), noise=0.01, outliers=out).gradient for out in ((), (12,)))
    angle = np.arccos(clean @ blinded / np.linalg.norm(clean) / np.linalg.norm(blinded))
    assert angle < 0.15


def test_significance_falls_with_noise():
    quiet, loud = (filled(SlopeWindow(), arc(), noise=noise).significance for noise in (0.01, 1.0))
    assert quiet > 30
    assert loud < 10


def test_significance_is_in_standard_deviations():
    true = JACOBIAN.T @ JACOBIAN @ (arc()[-1] - GOAL)
    off = []
    for seed in range(200):
        slope = filled(SlopeWindow(lengths_m=(5.0,)), arc(40), noise=0.3, seed=seed)
        error = slope.gradient - true
        scale = (slope.offset * slope.noise) @ (slope.offset * slope.noise)
        off.append(error @ slope.information @ error / scale)
    # Chi-squared of two dimensions has mean 2; the offset itself is estimated as well, so a little more.
    assert 1.5 < np.mean(off) < 4.5


def test_the_shortest_window_that_decides_is_used():
    # The features bend at the corner: what was before it must not count where the rest suffices.
    straight = np.column_stack([np.linspace(-2.0, 0.0, 21), np.zeros(21)])
    corner = arc(12)
    way = np.concatenate([straight[:-1], corner])
    window = SlopeWindow(lengths_m=(1.2, 4.0))
    length = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(way, axis=0), axis=1))])
    for number, (here, at) in enumerate(zip(way, length, strict=True)):
        slant = JACOBIAN if number >= 20 else -JACOBIAN
        window.append(here, slant @ (here - GOAL), float(at))
    np.testing.assert_allclose(window.slope(way[-1]).jacobian, JACOBIAN, atol=0.1)


def test_images_from_one_spot_are_averaged_and_too_few_are_none():
    window = SlopeWindow()
    for _ in range(50):
        window.append(np.zeros(2), np.ones(3), 0.0)
    assert window.slope(np.zeros(2)) is None


def test_what_it_keeps_is_bounded():
    window = SlopeWindow(lengths_m=(1.0, 2.0))
    for number in range(5000):
        window.append(np.array([0.1 * number, 0.0]), np.ones(3), 0.1 * number)
    assert len(window._rows) <= 22
