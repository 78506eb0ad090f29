import numpy as np
import pytest

from andante.angles import wrapped
from andante.data import Pose2D
from andante.errors import ConfigError
from andante.navigation import GradientNavigator, GradientSettings, Limits, SlowCost
from andante.navigation.gradient import towards
from andante.protocols import DriveState, View

GOAL = np.array([3.0, 2.0])


def linear(position):
    return 0.5 * position


def navigator(**settings):
    return GradientNavigator(SlowCost.plain(linear(GOAL)), GradientSettings(**settings), Limits(timeout_s=1e4))


@pytest.mark.parametrize("heading", [-3.0, -1.0, 0.5, 2.0])
def test_it_goes_down_a_smooth_cost(plain_robot, heading):
    robot = plain_robot(linear, (0.0, 0.0, heading))
    found = robot.drive(navigator(window_m=2.0))
    assert found.state == DriveState.ARRIVED
    assert np.linalg.norm(robot.pose[:2] - GOAL) < 0.3 / 0.5


def test_the_start_is_a_v_of_the_given_length(plain_robot):
    robot = plain_robot(linear, (0.0, 0.0, 0.0))
    found = navigator(v_turn_rad=2.0)
    while found.iterations == 0:
        robot.drive(found, steps=1)
    corner = max(robot.track, key=lambda pose: pose[0])
    assert corner[0] == pytest.approx(0.98, abs=0.06)
    assert abs(corner[1]) < 0.05
    leg = robot.pose[:2] - corner[:2]
    assert np.hypot(*leg) == pytest.approx(0.98, abs=0.08)
    assert np.arctan2(leg[1], leg[0]) == pytest.approx(2.0, abs=0.1)


def test_errata_it_goes_on_while_the_cost_is_high_and_iterations_are_left(plain_robot):
    robot = plain_robot(lambda position: np.array([5.0, 5.0]) + 1e-3 * position)
    found = robot.drive(navigator(iterations=7))
    assert (found.state, found.iterations) == (DriveState.TIMED_OUT, 7)
    assert "after 7 iterations" in found.reason


def test_errata_the_first_step_goes_down_too(plain_robot):
    robot = plain_robot(linear, (0.0, 0.0, 0.0))
    found = navigator()
    while found.iterations < 2:
        robot.drive(found, steps=1)
    at = np.linalg.norm(np.array([pose[:2] for pose in robot.track]) - GOAL, axis=1)
    assert at[-1] < at[-8]


def test_a_collision_ends_it(plain_robot):
    found = plain_robot(linear, bump=lambda pose: pose[0] > 0.5).drive(navigator())
    assert found.state == DriveState.BLOCKED
    assert "hit something" in found.reason


def test_views_without_slow_features_are_told_what_to_do(plain_robot):
    view = plain_robot(linear).view()
    blind = View(view.timestamp_s, view.estimate, view.odometry)
    with pytest.raises(ConfigError, match=r"needs them in every view, got None; let localize return"):
        navigator().command(blind)


def test_towards_turns_before_it_drives():
    limits = Limits()
    turning = towards(np.array([0.0, 1.0]), Pose2D(0.0, 0.0, 0.0), limits)
    assert turning.forward_m_s == 0.0
    assert turning.turn_rad_s > 0.0
    ahead = towards(np.array([1.0, 0.0]), Pose2D(0.0, 0.0, 0.0), limits)
    assert (ahead.forward_m_s, ahead.turn_rad_s) == (limits.forward_m_s, 0.0)


def test_angles_are_wrapped():
    assert wrapped(3 * np.pi + 0.1) == pytest.approx(-np.pi + 0.1)
