import numpy as np
import pytest

from andante.data import Estimate, Pose2D, Status
from andante.navigation import Guarded, drive
from andante.protocols import DriveState, Navigator, VelocityCommand, View

NOWHERE = Estimate(Status.LOST, "for a test")
WALL = (2.0, -5.0, 2.0, 5.0)


class Stubborn:
    """Wants the commands of a list, the last of them for ever, until ``steps`` are over."""

    name = "stubborn"
    reason = ""

    def __init__(self, *wanted, steps=100):
        self.state = DriveState.DRIVING
        self._wanted, self._left = list(wanted), steps

    def command(self, view):
        self._left -= 1
        if self._left < 0:
            self.stop()
        return self._wanted.pop(0) if len(self._wanted) > 1 else self._wanted[0]

    def stop(self, reason="stopped from outside"):
        self.state, self.reason = DriveState.STOPPED, reason


def go(robot, *wanted, steps=100):
    guarded = Guarded(Stubborn(*wanted, steps=steps))
    return drive(robot, lambda observation: (NOWHERE, None), guarded)


def test_it_is_a_navigator():
    assert isinstance(Guarded(Stubborn(VelocityCommand(0.0, 0.0))), Navigator)


@pytest.mark.parametrize("speed", [0.2, 0.5, 2.0])
@pytest.mark.parametrize("turn", [0.0, 0.2])
def test_with_a_range_sensor_nothing_is_touched(flat_robot, speed, turn):
    robot = flat_robot((0.0, 0.0, 0.0), [WALL], reach_m=1.5)
    go(robot, VelocityCommand(speed, turn), steps=200)
    assert robot.bumps == 0
    if turn == 0.0:
        assert 1.6 < robot.pose[0] <= 1.8  # close to the wall all the same


def test_far_from_everything_nothing_is_held_back(flat_robot):
    robot = flat_robot((0.0, 0.0, 0.0), reach_m=1.5)
    go(robot, VelocityCommand(0.5, 0.1), steps=20)
    free = flat_robot((0.0, 0.0, 0.0))
    for _ in range(20):
        free.step(VelocityCommand(0.5, 0.1), 0.2)
    np.testing.assert_allclose(robot.pose, free.pose)


def test_without_one_it_backs_off_after_contact(flat_robot):
    robot = flat_robot((1.0, 0.0, 0.0), [WALL])
    go(robot, VelocityCommand(0.5, 0.0), steps=40)
    x = np.array(robot.poses)[:, 0]
    hit = int(x.argmax())
    assert robot.bumps > 0
    assert x[hit : hit + 8].min() < x[hit] - 0.14


def test_what_was_hit_backwards_is_left_forwards(flat_robot):
    robot = flat_robot((2.5, 0.0, 0.0), [WALL])
    go(robot, VelocityCommand(-0.5, 0.0), steps=20)
    x = np.array(robot.poses)[:, 0]
    assert robot.bumps > 0
    assert x[int(x.argmin()) :].max() > x.min() + 0.14


def test_backwards_it_goes_only_where_it_came_from(flat_robot):
    robot = flat_robot((1.0, 0.0, 0.0), reach_m=1.5)
    go(robot, *[VelocityCommand(0.5, 0.1)] * 6, VelocityCommand(-0.5, 0.0), steps=60)
    assert 1.0 - 0.07 < robot.pose[0] < 1.3  # along its own way, and no farther
    turned = flat_robot((1.0, 0.0, 0.0), reach_m=1.5)
    go(turned, *[VelocityCommand(0.5, 0.0)] * 6, *[VelocityCommand(0.0, 1.0)] * 8, VelocityCommand(-0.5, 0.0), steps=60)
    assert abs(turned.pose[1]) < 0.06  # what is behind now was never seen


def test_it_tells_what_it_is_about_and_ends_with_the_one_it_guards(flat_robot):
    inner = Stubborn(VelocityCommand(0.5, 0.0))
    guarded = Guarded(inner)
    view = View(0.0, NOWHERE, Pose2D(0.0, 0.0, 0.0))
    guarded.command(view)
    assert guarded.state == DriveState.DRIVING
    assert guarded.name == "stubborn"
    guarded.command(View(0.2, NOWHERE, Pose2D(0.1, 0.0, 0.0), bumped=True))
    assert guarded.state == DriveState.RECOVERING
    assert "bumped" in guarded.reason
    guarded.stop("enough")
    assert (guarded.state, guarded.command(view)) == (DriveState.STOPPED, VelocityCommand(0.0, 0.0))
    assert guarded.reason == "enough"
