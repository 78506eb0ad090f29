import numpy as np
import pytest

from andante.data import Estimate, Status
from andante.navigation import STAND
from andante.navigation.manoeuvre import Manoeuvre, Move
from andante.protocols import View

NOWHERE = Estimate(Status.LOST, "for a test")


def perform(robot, *moves, most=300):
    """Step until the manoeuvre is over; how many steps that took."""
    manoeuvre, seen = Manoeuvre(moves), robot.step(STAND, 0.0)
    for count in range(most):
        command = manoeuvre.command(View(seen.timestamp_s, NOWHERE, seen.odometry, seen.bumped, seen.range_m))
        if command is None:
            return count
        seen = robot.step(command, 0.1)
    raise AssertionError("the manoeuvre has no end")


@pytest.mark.parametrize("metres", [0.4, -0.3])
def test_straight(flat_robot, metres):
    robot = flat_robot((1.0, 1.0, 0.0))
    perform(robot, Move("straight", metres))
    assert robot.pose == pytest.approx([1.0 + metres, 1.0, 0.0], abs=0.03)


@pytest.mark.parametrize("turn", [0.5, -1.2, 2 * np.pi])
def test_turns_count_all_the_way_around(flat_robot, turn):
    robot = flat_robot((0.0, 0.0, 3.0))
    perform(robot, Move("turn", turn))
    assert robot.pose == pytest.approx([0.0, 0.0, 3.0 + turn], abs=0.08)


def test_one_after_the_other(flat_robot):
    robot = flat_robot((0.0, 0.0, 0.0))
    perform(robot, Move("straight", 0.5), Move("turn", np.pi / 2), Move("straight", 0.5))
    assert robot.pose == pytest.approx([0.5, 0.5, np.pi / 2], abs=0.08)


def test_a_move_that_bumps_is_over(flat_robot):
    robot = flat_robot((0.0, 0.0, 0.0), [(0.5, -1.0, 0.5, 1.0)])
    perform(robot, Move("straight", 3.0), Move("turn", 1.0))
    assert robot.pose == pytest.approx([0.3, 0.0, 1.0], abs=0.08)
    assert robot.bumps == 1


def test_a_move_that_sees_something_ahead_is_over(flat_robot):
    robot = flat_robot((0.0, 0.0, 0.0), [(1.0, -1.0, 1.0, 1.0)], reach_m=1.0)
    perform(robot, Move("straight", 3.0))
    assert robot.bumps == 0
    assert 0.5 < robot.pose[0] < 0.8


def test_wheels_that_spin_do_not_go_on_for_ever(flat_robot):
    class Stuck(flat_robot):
        def step(self, command, duration_s):
            return super().step(STAND, duration_s)

    assert perform(Stuck((0.0, 0.0, 0.0)), Move("straight", 0.2)) == pytest.approx(
        41, abs=2
    )  # three times 1 s, and one
