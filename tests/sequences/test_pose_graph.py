"""The most likely path: against a dense, numerically differentiated solution of the same problem."""

import numpy as np
import pytest
from scipy.optimize import least_squares

from andante.sequences import Anchors, Closures, DriftNoise, fit_path


def test_anchors_place_a_drive_and_take_its_drift_out(drives):
    truth = drives.border(n=120)
    drifted = drives.odometry(truth, np.random.default_rng(1), bias_rad=0.002, turn_rad=0.003, wheel=0.02, scale=1.01)
    frames = np.arange(0, 120, 5)
    anchors = Anchors(frames, truth[frames, :2], np.full(len(frames), 0.02))
    fitted = fit_path(
        drifted, 0.2 * np.arange(120), DriftNoise(), anchors=anchors, initial=drives.placed(drifted, truth[0])
    )
    assert np.hypot(*(fitted.poses - truth)[:, :2].T).max() < 0.05
    assert np.abs(fitted.poses[:, 2] - truth[:, 2]).max() < 0.05
    assert fitted.gyro_bias_rad_s == pytest.approx(0.01, rel=0.3)
    assert fitted.scale == pytest.approx(-0.01, abs=0.01)


def test_a_wrong_anchor_pulls_only_so_much(drives):
    truth = drives.border(n=120)
    exact = drives.placed(drives.odometry(truth), truth[0])
    frames = np.arange(0, 120, 5)
    places = truth[frames, :2].copy()
    places[7] += 3.0
    anchors = Anchors(frames, places, np.full(len(frames), 0.05))
    fitted = fit_path(exact, 0.2 * np.arange(120), DriftNoise(), anchors=anchors)
    assert np.hypot(*(fitted.poses - truth)[:, :2].T).max() < 0.15


def residuals(state, odometry, noise, closure):
    """The whitened errors of the same model, written down pose by pose."""
    poses, bias, scale = state[:-2].reshape(-1, 3), state[-2], state[-1]
    found = [1e3 * (poses[0] - odometry[0]), [bias / noise.gyro_rad_s, scale / noise.scale]]
    for i in range(len(poses) - 1):
        steps = []
        for path in (odometry, poses):
            (dx, dy, turn), angle = path[i + 1] - path[i], (path[i + 1, 2] + path[i, 2]) / 2
            steps.append([np.cos(angle) * dx + np.sin(angle) * dy, np.cos(angle) * dy - np.sin(angle) * dx, turn])
        measured, now = np.array(steps)
        way = np.hypot(noise.wheel_m * np.sqrt(np.hypot(measured[0], measured[1])), 1e-3)
        turning = np.hypot(noise.turn_rad * np.sqrt(abs(measured[2])), 1e-3)
        found.append((now[:2] - (1 + scale) * measured[:2]) / way)
        found.append([(now[2] - measured[2] + 0.2 * bias) / turning])
    a, b = poses[closure.first[0]], poses[closure.second[0]]
    dx, dy = (b - a)[:2]
    seen = np.array([np.cos(a[2]) * dx + np.sin(a[2]) * dy, np.cos(a[2]) * dy - np.sin(a[2]) * dx, b[2] - a[2]])
    wrong = seen - closure.relative[0]
    found.append([wrong[0] / 0.05, wrong[1] / 0.05, (np.mod(wrong[2] + np.pi, 2 * np.pi) - np.pi) / 0.03])
    return np.concatenate(found)


def test_it_is_the_least_squares_solution(drives):
    odometry = drives.odometry(drives.border(n=25), np.random.default_rng(2), bias_rad=0.004, turn_rad=0.01, wheel=0.02)
    closure = Closures(np.array([24]), np.array([0]), np.array([[1.3, 0.2, 0.25]]))
    noise = DriftNoise(gyro_rad_s=0.02, wheel_m=0.05)
    fitted = fit_path(odometry, 0.2 * np.arange(25), noise, closures=closure)
    state = np.concatenate([fitted.poses.ravel(), [fitted.gyro_bias_rad_s, fitted.scale]])
    slow = least_squares(residuals, np.append(odometry.ravel(), [0, 0]), args=(odometry, noise, closure))
    # The closure is near enough not to be taken for a wrong one.
    assert np.abs(residuals(state, odometry, noise, closure)[-3:]).max() < 3
    np.testing.assert_allclose(state, slow.x, atol=2e-4)
