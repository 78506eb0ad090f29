import numpy as np
import pytest

from andante.navigation import CommuteNavigator, CommuteSettings, Limits, SlowCost
from andante.protocols import DriveState

GOAL = np.array([3.0, 2.0])
SCALE = np.array([[1.0, 0.3], [-0.4, 0.8], [0.2, 0.2]]) / 0.13
"""Three features that change by about one with each step of 0.13 m."""


def linear(position):
    return SCALE @ position


def bent(position):
    """Feature that fold far from the goal, as slow features do."""
    return np.concatenate([3.0 / 0.13 * np.tanh(position / 3.0), np.sin(2.0 * position)])


def navigator(slow=linear, **settings):
    goal = slow(GOAL)
    cost = SlowCost(goal, np.full(len(goal), 1.0 / len(goal)))
    return CommuteNavigator(cost, CommuteSettings(**settings), Limits(timeout_s=400.0))


@pytest.mark.parametrize("slow", [linear, bent])
@pytest.mark.parametrize("start", [(0.0, 0.0, 0.0), (5.0, 5.0, 2.0), (-2.0, 4.0, -1.0)])
def test_it_arrives(plain_robot, slow, start):
    robot = plain_robot(slow, start, noise=0.3)
    found = robot.drive(navigator(slow))
    assert found.state == DriveState.ARRIVED
    assert np.linalg.norm(robot.pose[:2] - GOAL) < 0.5
    way = np.linalg.norm(np.diff(np.array(robot.track)[:, :2], axis=0), axis=1).sum()
    assert way < 2.0 * np.linalg.norm(np.array(start[:2]) - GOAL) + 2.0


def test_it_goes_around_a_wall_that_it_sees(plain_robot):
    # A wall across the way, from y = -0.5 on upwards to 1.5; the sensor looks straight ahead.
    def ahead(pose):
        reach = np.linspace(0.0, 1.5, 60)
        points = pose[:2] + reach[:, None] * [np.cos(pose[2]), np.sin(pose[2])]
        hit = (np.abs(points[:, 0] - 1.5) < 0.25) & (points[:, 1] > -0.5) & (points[:, 1] < 1.7)
        return float(reach[hit.argmax()]) if hit.any() else 1.5

    robot = plain_robot(linear, (0.0, 0.5, 0.0), ahead=ahead)
    found = robot.drive(navigator())
    track = np.array(robot.track)
    inside = (np.abs(track[:, 0] - 1.5) < 0.2) & (track[:, 1] > -0.45) & (track[:, 1] < 1.65)
    assert found.state == DriveState.ARRIVED
    assert not inside.any()


def test_it_backs_away_from_what_it_bumps_into(plain_robot):
    robot = plain_robot(linear, (0.0, 0.0, 0.5), bump=lambda pose: 1.0 < pose[0] < 1.05 and pose[1] < 1.0)
    assert robot.drive(navigator()).state == DriveState.ARRIVED


def test_it_turns_back_from_what_was_not_mapped(plain_robot):
    robot = plain_robot(linear, (0.0, 0.0, 0.0), off_map=lambda position: position[1] < -0.3)
    assert robot.drive(navigator()).state == DriveState.ARRIVED
    assert np.array(robot.track)[:, 1].min() > -1.0


def test_where_everything_looks_strange_it_believes_its_eyes_but_claims_nothing(plain_robot):
    robot = plain_robot(linear, off_map=lambda position: True)
    found = robot.drive(navigator())
    assert found.state == DriveState.BLOCKED
    assert "nothing on the way looked like what was mapped" in found.reason
    assert np.linalg.norm(robot.pose[:2] - GOAL) < 0.5


def test_being_alike_is_not_being_there(plain_robot):
    # Features that do not change with place, and are those of the goal.
    robot = plain_robot(lambda position: linear(GOAL), noise=0.3)
    assert robot.drive(navigator(recoveries=2)).state != DriveState.ARRIVED


def test_who_strays_again_and_again_gives_up(plain_robot):
    robot = plain_robot(linear, off_map=lambda position: position[0] > 1.0)
    found = robot.drive(navigator(strays=3))
    assert found.state == DriveState.BLOCKED
    assert "strayed 4 times" in found.reason
    assert np.array(robot.track)[:, 0].max() < 2.0


def test_on_a_flat_cost_it_recovers_and_then_gives_up(plain_robot):
    robot = plain_robot(lambda position: np.full(3, 40.0))
    found, states = navigator(recoveries=3), set()
    for _ in range(1500):
        robot.drive(found, steps=1)
        states.add(found.state)
    assert DriveState.RECOVERING in states
    assert found.state in (DriveState.BLOCKED, DriveState.TIMED_OUT)
    assert np.abs(np.array(robot.track)[:, :2]).max() < 15.0
