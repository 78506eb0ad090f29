import numpy as np
import pytest

from andante.data import Estimate, Status
from andante.errors import ConfigError
from andante.navigation import STAND, LimitedNavigator, Limits, drive, tracked
from andante.protocols import DriveState, VelocityCommand


class Straight(LimitedNavigator):
    """Straight on; arrives after ``seconds``, raises what it is told to."""

    def __init__(self, seconds=2.0, error=None, limits=None):
        super().__init__("straight", limits)
        self._seconds, self._error = seconds, error

    def _steer(self, view):
        if self._error is not None and view.timestamp_s > 0.5:
            raise self._error
        if view.timestamp_s >= self._seconds:
            self._enter(DriveState.ARRIVED, "far enough")
        return VelocityCommand(10.0, 0.0)


def test_what_is_kept_of_a_drive(flat_robot, truth):
    robot = flat_robot((0.0, 0.0, 0.5))
    run = drive(robot, truth(robot, lost=lambda time_s: 0.9 < time_s < 1.3), Straight(), step_s=0.1)
    assert (run.arrived, run.outcome, run.reason) == (True, DriveState.ARRIVED, "far enough")
    assert len(run) == len(run.status) == len(run.state) == len(run.milliseconds) == 21
    assert run.seconds == pytest.approx(2.0)
    lost = np.array(run.status) == Status.LOST
    np.testing.assert_array_equal(np.isnan(run.estimate[:, 0]), lost)
    assert lost.sum() == 3
    assert run.command[:, 0].max() == 0.5
    assert (np.diff(run.command[:-1, 0]) <= 0.1 + 1e-9).all()  # 1 m/s² for a tenth of a second
    np.testing.assert_allclose(run.odometry[-1, :2], [robot.pose[0] / np.cos(0.5), 0.0], atol=1e-9)


def test_the_robot_stands_still_at_the_end(flat_robot, truth):
    commands = []

    class Noting(flat_robot):
        def step(self, command, duration_s):
            commands.append((command, duration_s))
            return super().step(command, duration_s)

    robot = Noting((0.0, 0.0, 0.0))
    drive(robot, truth(robot), Straight())
    assert commands[-1] == (STAND, 0.0)


@pytest.mark.parametrize("error", [ValueError("broken"), KeyboardInterrupt()])
def test_it_stands_still_when_something_raises(flat_robot, truth, error):
    robot, navigator = flat_robot((0.0, 0.0, 0.0)), Straight(error=error)
    with pytest.raises(type(error)):
        drive(robot, truth(robot), navigator)
    assert (navigator.state, navigator.reason) == (DriveState.STOPPED, f"interrupted by {type(error).__name__}")
    assert robot.poses[-1] == pytest.approx(robot.poses[-2])


def test_time_runs_out(flat_robot, truth):
    robot = flat_robot((0.0, 0.0, 0.0))
    run = drive(robot, truth(robot), Straight(100.0, limits=Limits(timeout_s=1.0)))
    assert (run.outcome, run.reason) == (DriveState.TIMED_OUT, "not there after 1 s")
    assert run.seconds == pytest.approx(1.0)


@pytest.mark.parametrize("step_s", [0.0, -1.0, float("nan")])
def test_steps_take_time(flat_robot, truth, step_s):
    robot = flat_robot((0.0, 0.0, 0.0))
    with pytest.raises(ConfigError, match=r"step_s = .* is not allowed; a control step takes a finite time"):
        drive(robot, truth(robot), Straight(), step_s=step_s)


def test_progress_is_told(flat_robot, truth):
    robot, seen = flat_robot((0.0, 0.0, 0.0)), []
    run = drive(robot, truth(robot), Straight(), progress=lambda view, command, state: seen.append(state))
    assert tuple(seen) == run.state


def test_a_tracker_is_told_all_that_the_robot_senses(flat_robot):
    frames = []

    class Tracker:
        name = "noting"

        def update(self, frame, fix=None):
            frames.append(frame.info)
            return Estimate(Status.LOST, "")

    robot = flat_robot((0.0, 0.0, 0.0))
    run = drive(robot, tracked(Tracker()), Straight())
    assert [frame.index for frame in frames] == list(range(len(run)))
    np.testing.assert_allclose([frame.timestamp_s for frame in frames], run.timestamp_s)
    np.testing.assert_allclose([frame.odometry.x_m for frame in frames], run.odometry[:, 0])
