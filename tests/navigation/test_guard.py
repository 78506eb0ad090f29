"""A guard between a navigator and the wheels, and the bridge over what images do not tell."""

import numpy as np
import pytest

from andante.data import Estimate, Pose2D, Status
from andante.navigation.bridge import Bridge
from andante.navigation.guard import Guarded
from andante.protocols import DriveState, VelocityCommand, View

STEP_S = 0.2


class Ahead:
    """A navigator that knows nothing but full speed ahead."""

    name, reason, state = "ahead", "", DriveState.DRIVING

    def stop(self, reason="stopped from outside"):
        self.state = DriveState.STOPPED

    def command(self, view):
        return VelocityCommand(0.5, 0.0)


def driven(robot, guard, steps=100):
    """What the robot did, told what its sensors say."""
    observation = robot.step(VelocityCommand(0.0, 0.0), STEP_S)
    nothing = Estimate(Status.LOST, "for a test")
    for _ in range(steps):
        seen = View(observation.timestamp_s, nothing, observation.odometry, observation.bumped, observation.range_m)
        observation = robot.step(guard.command(seen), STEP_S)
    return robot


@pytest.mark.parametrize("start", [0.0, 0.55, 0.9])
def test_with_a_range_sensor_nothing_is_touched(flat_robot, start):
    robot = driven(flat_robot((start, 0, 0), walls=[(2, -1, 2, 1)], reach_m=1.5), Guarded(Ahead(), step_s=STEP_S))
    assert robot.bumps == 0
    assert robot.pose[0] > 1.6  # but it comes close


def test_without_one_it_backs_off_from_what_was_hit(flat_robot):
    robot = flat_robot((0, 0, 0), walls=[(2, -1, 2, 1)])
    driven(robot, Guarded(Ahead(), step_s=STEP_S))
    xs = np.array(robot.poses)[:, 0]
    hit = int(xs.argmax())
    assert robot.bumps > 0
    assert xs[hit:].min() < xs[hit] - 0.1


def test_a_guarded_navigator_stops_when_told():
    guard = Guarded(Ahead())
    guard.stop()
    assert guard.command(View(0.0, Estimate(Status.LOST, ""), Pose2D(0, 0, 0))) == VelocityCommand(0.0, 0.0)


def told(time_s, true, odometry, heading=True):
    """A view whose estimate tells the truth (x, y, heading), or nothing."""
    if true is None:
        estimate = Estimate(Status.LOST, "for a test")
    else:
        estimate = Estimate(Status.OK, "", true[0], true[1], true[2] if heading else None)
    return View(time_s, estimate, Pose2D(*odometry))


def moved(pose, turn=0.7, shift=(3.0, -1.0)):
    """A pose of odometry in the frame of the map."""
    cos, sin = np.cos(turn), np.sin(turn)
    return shift[0] + cos * pose[0] - sin * pose[1], shift[1] + sin * pose[0] + cos * pose[1], pose[2] + turn


@pytest.mark.parametrize("heading", [True, False])
def test_wheels_tell_the_pose_while_images_tell_nothing(heading):
    bridge = Bridge()
    for step in range(20):
        odometry = (0.1 * step, 0.0, 0.0)
        bridge.update(told(0.2 * step, moved(odometry), odometry, heading))
    odometry = (2.3, 0.3, 0.4)
    pose = bridge.update(told(4.2, None, odometry))
    assert (pose.x_m, pose.y_m, pose.heading_rad) == pytest.approx(moved(odometry), abs=1e-6)
    assert pose.bridged_m > 0
    assert bridge.update(told(4.4, None, (5.0, 0.3, 0.4))) is None  # too far
    assert bridge.update(told(60.0, None, (5.0, 0.3, 0.4))) is None  # too long ago


def test_an_estimate_far_off_is_followed_once_three_agree():
    bridge = Bridge()
    for step in range(5):
        bridge.update(told(0.2 * step, (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)))
    far = [bridge.update(told(1.0 + 0.2 * step, (5.0, 0.0, 0.0), (0.0, 0.0, 0.0))).x_m for step in range(3)]
    assert far[:2] == pytest.approx([0.0, 0.0])
    assert far[2] == pytest.approx(5.0)


def test_nothing_heard_nothing_said():
    assert Bridge().update(told(0.0, None, (0.0, 0.0, 0.0))) is None
