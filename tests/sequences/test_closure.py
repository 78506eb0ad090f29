"""Closing a lap: what is exact stays, what drifted comes back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.errors import ArrayError, ConfigError, RecordingError
from andante.sequences import DriftNoise, close_wire_loop


def seen_from(pose, other):
    """Pose ``other`` in the robot frame of ``pose``."""
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    dx, dy, turn = other - pose
    return np.array([cos * dx + sin * dy, cos * dy - sin * dx, turn])


@pytest.mark.parametrize("clockwise", [False, True])
def test_exact_odometry_is_not_changed(drives, clockwise):
    truth = drives.border()
    if clockwise:
        truth = truth[::-1] + np.array([0, 0, np.pi])
    exact = drives.odometry(truth)
    full = np.array([0, 0, 2 * np.pi * (-1 if clockwise else 1)])
    closed = close_wire_loop(exact, relative=seen_from(truth[-1], truth[0] + full))
    np.testing.assert_allclose(closed.poses, exact, atol=1e-6)
    assert closed.turns == (-1 if clockwise else 1)
    assert abs(closed.heading_error_rad) < 1e-9
    assert closed.position_error_m < 1e-9


def test_default_closure_is_one_more_step(drives):
    truth = drives.border(n=400)
    exact = drives.odometry(truth)
    closed = close_wire_loop(exact)
    np.testing.assert_allclose(closed.poses, exact, atol=0.01)
    assert closed.position_error_m < 0.02


@pytest.mark.parametrize("laps", [1.0, 3.0])
@pytest.mark.parametrize("total_rad", [0.4, -0.7])
def test_a_gyro_bias_is_removed_nearly_exactly(drives, laps, total_rad):
    truth = drives.border(n=int(200 * laps), laps=laps)
    drifted = drives.odometry(truth, bias_rad=total_rad / len(truth))
    relative = seen_from(truth[-1], truth[0])
    closed = close_wire_loop(drifted, relative=relative, noise=DriftNoise(gyro_rad_s=0.03))
    assert closed.heading_error_rad == pytest.approx(total_rad, rel=0.02)
    assert closed.turns == laps
    assert drives.rigid_error_m(drifted, truth).max() > 0.5
    assert drives.rigid_error_m(closed.poses, truth).max() < 0.02
    assert closed.gyro_bias_rad_s == pytest.approx(total_rad / len(truth) / 0.2, rel=0.02)


def test_time_stamps_say_where_a_bias_grew(drives):
    truth = drives.border()
    # The robot waits for a minute at the middle of the lap; its gyro does not.
    waiting = np.concatenate([np.arange(100), np.full(300, 100), np.arange(100, 200)])
    truth = truth[waiting]
    time = 0.2 * np.arange(len(truth))
    drifted = drives.odometry(truth, bias_rad=0.001)
    keep = np.r_[0:100, 399:500]  # pictures are taken only on the way
    relative = seen_from(truth[-1], truth[0])
    with_time = close_wire_loop(drifted[keep], time[keep], relative=relative).poses
    without = close_wire_loop(drifted[keep], relative=relative, max_gap_share=0.1).poses
    assert drives.rigid_error_m(with_time, truth[keep]).max() < 0.05
    assert drives.rigid_error_m(without, truth[keep]).max() > 0.2


@settings(max_examples=15, deadline=None)
@given(seed=st.integers(0, 100), heading=st.floats(-3, 3), x=st.floats(-50, 50))
def test_the_start_frame_does_not_matter(drives, seed, heading, x):
    rng = np.random.default_rng(seed)
    drifted = drives.odometry(drives.border(n=60), rng, bias_rad=0.005, turn_rad=0.01, wheel=0.02)
    start = np.array([x, 3.0, heading])
    here, there = close_wire_loop(drifted).poses, close_wire_loop(drives.placed(drifted, start)).poses
    np.testing.assert_allclose(drives.placed(here, start), there, atol=1e-4)


def test_headings_may_be_wrapped(drives):
    drifted = drives.odometry(drives.border(laps=2.0, n=300), bias_rad=0.001)
    wrapped = drifted.copy()
    wrapped[:, 2] = np.mod(wrapped[:, 2] + np.pi, 2 * np.pi) - np.pi
    np.testing.assert_allclose(close_wire_loop(wrapped).poses, close_wire_loop(drifted).poses, atol=1e-8)


def test_random_drift_becomes_smaller(drives):
    before, after = [], []
    for seed in range(8):
        truth = drives.border(n=250)
        rng = np.random.default_rng(seed)
        drifted = drives.odometry(truth, rng, bias_rad=rng.normal(0, 0.0006), turn_rad=0.0015, wheel=0.02)
        before.append(drives.rigid_error_m(drifted, truth).mean())
        after.append(drives.rigid_error_m(close_wire_loop(drifted).poses, truth).mean())
    assert np.mean(after) < 0.5 * np.mean(before)


def test_pairs_close_a_part_and_carry_the_rest_along(drives):
    truth = drives.border(n=330, laps=1.5)
    drifted = drives.odometry(truth, bias_rad=0.001)
    pairs = np.column_stack([np.arange(0, 100, 10), np.arange(0, 100, 10) + 220])
    closed = close_wire_loop(drifted, pairs=pairs)
    assert len(closed.poses) == 330
    assert closed.turns == 1
    np.testing.assert_allclose(closed.poses[0], drifted[0], atol=1e-12)
    assert drives.rigid_error_m(closed.poses, truth).max() < 0.05
    single = close_wire_loop(drifted, pairs=[(50, 270)])
    assert drives.rigid_error_m(single.poses, truth).max() < 0.1


def test_one_wrong_pair_among_many_does_little_harm(drives):
    truth = drives.border(n=400, laps=2.0)
    drifted = drives.odometry(truth, bias_rad=0.0005)
    pairs = [(frame, frame + 200) for frame in range(0, 200, 10)]
    closed = close_wire_loop(drifted, pairs=[*pairs, (20, 320)])
    assert drives.rigid_error_m(closed.poses, truth).max() < 0.15


def test_what_is_not_closed_is_refused(drives):
    lap = drives.odometry(drives.border(n=200))
    with pytest.raises(RecordingError, match=r"no closed loop: its headings at start and end differ by 2\.\d+ rad"):
        close_wire_loop(lap[:100])
    line = np.column_stack([np.arange(50.0), np.zeros((50, 2))])
    with pytest.raises(RecordingError, match=r"no closed loop: a gap of 50\.00 m is left after 49\.0 m, up to 6%"):
        close_wire_loop(line)
    with pytest.raises(RecordingError, match="no closed loop"):
        close_wire_loop(lap, pairs=[(10, 120)])
    there_and_back = np.concatenate([line, line[::-1]])
    with pytest.raises(RecordingError, match="no lap: it made no full turn"):
        close_wire_loop(there_and_back, relative=np.zeros(3))


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"odometry": np.zeros((9, 2))}, ArrayError, r"\(n, 3\), got shape \(9, 2\)"),
        ({"odometry": np.full((9, 3), np.nan)}, ArrayError, "unknown in 9 of 9 frames; leave"),
        ({"timestamp_s": np.zeros(3)}, ArrayError, "one time each"),
        ({"timestamp_s": np.zeros(60)}, ArrayError, "increase from frame to frame"),
        ({"pairs": [(5, 5)]}, ConfigError, "earlier < later < 60"),
        ({"pairs": [(0, 60)]}, ConfigError, "earlier < later < 60"),
        ({"pairs": []}, ArrayError, "at least one"),
        ({"relative": np.zeros(2)}, ArrayError, r"relative has to be x, y, heading \(3,\)"),
        ({"max_gap_share": 0.0}, ConfigError, "max_gap_share=0.0"),
        ({"max_heading_rad": 4.0}, ConfigError, "max_heading_rad=4.0"),
    ],
)
def test_faults(drives, change, error, message):
    given = {"odometry": drives.odometry(drives.border(n=60)), **change}
    with pytest.raises(error, match=message):
        close_wire_loop(**given)


def test_noise_is_checked():
    with pytest.raises(ConfigError, match=r"wheel_m=0: a standard deviation of odometry is above 0, below 1"):
        DriftNoise(wheel_m=0)
