"""Steps from odometry: what is added up again is the odometry, and what cannot be is not believed."""

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.data import FrameInfo, Pose2D
from andante.localization.config import MotionConfig
from andante.localization.motion import Odometer, Step

CONFIG = MotionConfig()
small = st.floats(-0.3, 0.3)


def frames(poses):
    return [FrameInfo(n, "", 0.2 * n, odometry=pose) for n, pose in enumerate(poses)]


def steps(infos, config=CONFIG):
    odometer, out = Odometer(), []
    for info in infos:
        odometer, step = odometer.take(info, config)
        out.append(step)
    return out


@given(st.lists(st.tuples(small, small, st.floats(-3, 3)), min_size=1, max_size=20), st.floats(-50, 50))
def test_steps_add_up_to_the_odometry_wherever_that_began(moves, offset):
    poses = [Pose2D(offset, -offset, offset)]
    for dx, dy, turn in moves:
        poses.append(Pose2D(poses[-1].x_m + dx, poses[-1].y_m + dy, poses[-1].heading_rad + turn))
    pose = poses[0]
    for step in steps(frames(poses))[1:]:
        assert step.known
        assert step.duration_s == pytest.approx(0.2)
        pose = step.after(pose)
    assert (pose.x_m, pose.y_m) == pytest.approx((poses[-1].x_m, poses[-1].y_m), abs=1e-9)
    assert math.remainder(pose.heading_rad - poses[-1].heading_rad, 2 * math.pi) == pytest.approx(0, abs=1e-9)


def test_the_first_frame_is_no_step():
    assert steps(frames([Pose2D(5, 5, 1)])) == [Step()]


def test_jumps_are_told_and_not_believed():
    far, spin = steps(frames([Pose2D(0, 0, 0), Pose2D(9, 0, 0), Pose2D(9.1, 0, 3.1)]), replace_turn(3.0))[1:]
    assert not far.known
    assert far.way_m == 0
    assert far.note == "odometry jumped 9.0 m in 0.20 s and was not believed"
    assert not spin.known
    assert spin.note == "odometry turned 178° in 0.20 s and was not believed"


def replace_turn(limit):
    return MotionConfig(max_turn_rad_s=limit)


def test_a_long_way_in_a_long_gap_is_no_jump():
    infos = frames([Pose2D(0, 0, 0), Pose2D(9, 0, 0)])
    infos[1] = replace(infos[1], timestamp_s=10.0)
    assert steps(infos)[1].way_m == 9


@pytest.mark.parametrize("bad", [None, Pose2D(np.nan, 0, 0), Pose2D(0, -np.inf, 0)])
def test_missing_odometry_is_unknown_and_so_is_the_step_after_it(bad):
    out = steps(frames([Pose2D(0, 0, 0), bad, Pose2D(0.2, 0, 0), Pose2D(0.3, 0, 0)]))
    assert [step.known for step in out] == [True, False, False, True]
    assert "missing" in out[1].note
    assert out[3].forward_m == pytest.approx(0.1)


@pytest.mark.parametrize("heading", [None, np.nan])
def test_without_headings_the_direction_of_travel_stands_in(heading):
    turn = np.linspace(0, 2, 30)
    x, y = np.cos(turn), np.sin(turn)
    out = steps(frames([Pose2D(*xy, heading) for xy in zip(x.tolist(), y.tolist(), strict=True)]))[2:]
    assert [step.turn_rad for step in out] == pytest.approx([2 / 29] * 28)
    still = steps(frames([Pose2D(0, 0, None), Pose2D(0.2, 0, None), Pose2D(0.2, 0, None)]))[2]
    assert (still.way_m, still.turn_rad) == (0, 0)


@pytest.mark.parametrize("time", [1.0, 0.9, np.nan, np.inf])
def test_frames_that_are_old_or_repeated_are_no_step(time):
    odometer, _ = Odometer().take(FrameInfo(0, "", 1.0, odometry=Pose2D(0, 0, 0)), CONFIG)
    after, step = odometer.take(FrameInfo(1, "", time, odometry=Pose2D(0.1, 0, 0)), CONFIG)
    assert step is None
    assert after.odometry == odometer.odometry
    assert Odometer().take(FrameInfo(0, "", np.nan), CONFIG) == (Odometer(), None)


def test_a_clock_that_is_set_back_is_followed_but_not_at_once():
    odometer, _ = Odometer().take(FrameInfo(0, "", 5000.0, odometry=Pose2D(0, 0, 0)), CONFIG)
    taken = []
    for info in frames([Pose2D(0.1 * n, 0, 0) for n in range(30)]):
        odometer, step = odometer.take(info, CONFIG)
        taken.append(step)
    assert taken[:19] == [None] * 19
    assert not taken[19].known
    assert taken[19].note == "the clock was set back"
    assert all(step.forward_m == pytest.approx(0.1) for step in taken[20:])


def test_latecomers_do_not_set_the_clock_back():
    odometer = Odometer()
    for n in range(200):
        for time in (0.2 * n, 0.2 * n - 1.0):
            odometer, step = odometer.take(FrameInfo(n, "", time), CONFIG)
    assert odometer.timestamp_s == pytest.approx(39.8)
    for _ in range(40):  # nor does one that comes again and again
        odometer, step = odometer.take(FrameInfo(0, "", 3.0), CONFIG)
        assert step is None
