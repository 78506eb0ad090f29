import numpy as np
import pytest

from andante.simulator import BorderRun, OdometryNoise
from andante.simulator.odometry import Odometer, drifting

SILENT = OdometryNoise(scale=0, gyro_rad_s=0, wheel_m=0, turn_rad=0)


def rng(seed=0):
    return np.random.default_rng(seed)


def test_without_noise_odometry_is_the_truth_seen_from_the_first_pose(garden):
    truth = BorderRun().drive(garden, rng())
    poses = np.array([(p.x_m, p.y_m, p.heading_rad) for p in drifting(truth, SILENT, rng())])
    cos, sin = np.cos(truth.heading_rad[0]), np.sin(truth.heading_rad[0])
    own = (truth.xy_m - truth.xy_m[0]) @ np.array([[cos, -sin], [sin, cos]])
    np.testing.assert_allclose(poses[:, :2], own, atol=1e-9)
    np.testing.assert_allclose(np.cos(poses[:, 2] + truth.heading_rad[0] - truth.heading_rad), 1.0, atol=1e-9)


def after_a_straight(noise, runs=400):
    """Believed poses after 10 m straight on in 15 s, (runs, 3)."""
    ends = []
    for seed in range(runs):
        odometer = Odometer(noise, rng(seed))
        for _ in range(75):
            odometer.advance(10 / 75, 0.0, 0.0, 0.2)
        ends.append((odometer.pose.x_m, odometer.pose.y_m, odometer.pose.heading_rad))
    return np.array(ends)


def test_the_scale_error_is_one_for_a_whole_drive():
    x = after_a_straight(OdometryNoise(scale=0.02, gyro_rad_s=0, wheel_m=0, turn_rad=0))[:, 0]
    assert x.mean() == pytest.approx(10.0, abs=0.03)
    assert x.std() == pytest.approx(0.2, rel=0.15)


def test_the_gyro_drifts_with_time():
    heading = after_a_straight(OdometryNoise(scale=0, gyro_rad_s=0.01, wheel_m=0, turn_rad=0))[:, 2]
    assert heading.std() == pytest.approx(0.15, rel=0.15)


def test_wheel_noise_grows_with_the_root_of_the_way():
    x = after_a_straight(OdometryNoise(scale=0, gyro_rad_s=0, wheel_m=0.05, turn_rad=0))[:, 0]
    assert x.std() == pytest.approx(0.05 * np.sqrt(10), rel=0.15)


def test_turn_noise_grows_with_the_root_of_the_turn():
    ends = []
    for seed in range(400):
        odometer = Odometer(OdometryNoise(scale=0, gyro_rad_s=0, wheel_m=0, turn_rad=0.05), rng(seed))
        for _ in range(20):
            odometer.advance(0.0, 0.0, 0.2, 0.1)
        ends.append(odometer.pose.heading_rad)
    assert np.mean(ends) == pytest.approx(4.0, abs=0.02)
    assert np.std(ends) == pytest.approx(0.1, rel=0.15)
