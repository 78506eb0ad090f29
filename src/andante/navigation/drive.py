"""The loop: look, say where that is, decide, move; and what is kept of it."""

from __future__ import annotations

import itertools
import time
from array import array
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import Estimate, FloatArray, Frame, FrameInfo, Pose2D, Status
from andante.errors import ConfigError
from andante.navigation.limits import STAND
from andante.protocols import DriveState, Navigator, Observation, Robot, Tracker, VelocityCommand, View

Localize = Callable[[Observation], tuple[Estimate, FloatArray | None]]
"""What the robot senses -> where it is, and the slow features (k,) of its image where they are known."""
StepCallback = Callable[[View, VelocityCommand, DriveState], None]
"""Called after every decision."""

_COLUMNS = 12


@dataclass(frozen=True, slots=True)
class Drive:
    """What is known of a drive of n steps from the robot itself; where it truly was is not.

    ``timestamp_s`` (n,); ``estimate`` and ``odometry`` (n, 3) x, y, heading, NaN where unknown; ``radius_m`` (n,) 90 %
    radii; ``status`` of every estimate and ``state`` of the navigator after it; ``command`` (n, 2) forward and turn;
    ``bumped`` (n,); ``milliseconds`` (n,) from observation to command. ``outcome`` is the last state, and why.
    """

    timestamp_s: FloatArray
    estimate: FloatArray
    radius_m: FloatArray
    odometry: FloatArray
    command: FloatArray
    bumped: NDArray[np.bool_]
    milliseconds: FloatArray
    status: tuple[Status, ...]
    state: tuple[DriveState, ...]
    outcome: DriveState
    reason: str

    def __len__(self) -> int:
        return len(self.timestamp_s)

    @property
    def arrived(self) -> bool:
        """Whether the navigator believes to be there."""
        return self.outcome == DriveState.ARRIVED

    @property
    def seconds(self) -> float:
        """From the first observation to the last."""
        return float(self.timestamp_s[-1] - self.timestamp_s[0]) if len(self) else 0.0


def tracked(tracker: Tracker) -> Localize:
    """A tracker told all that the robot senses; it tells poses, no slow features."""
    count = itertools.count()

    def localize(observation: Observation) -> tuple[Estimate, FloatArray | None]:
        info = FrameInfo(next(count), "", observation.timestamp_s, observation.odometry)
        return tracker.update(Frame(info, observation.image)), None

    return localize


def drive(
    robot: Robot, localize: Localize, navigator: Navigator, *, step_s: float = 0.2, progress: StepCallback | None = None
) -> Drive:
    """Drive until the navigator has arrived or gives up.

    Whatever happens, the robot is told to stand still at the end, also when ``localize`` or ``navigator`` raise. A step
    keeps a hundred bytes, so that a drive of an hour takes 2 MB. Raises ``ConfigError`` for a ``step_s`` that is not
    positive.
    """
    if not (np.isfinite(step_s) and step_s > 0.0):
        raise ConfigError(f"step_s = {step_s} is not allowed; a control step takes a finite time greater than 0")
    log = _Log()
    try:
        observation = robot.step(STAND, 0.0)
        while not navigator.state.over:
            started = time.perf_counter()
            estimate, slow = localize(observation)
            view = View(
                observation.timestamp_s, estimate, observation.odometry, observation.bumped, observation.range_m, slow
            )
            command = navigator.command(view)
            log.add(view, command, navigator.state, 1e3 * (time.perf_counter() - started))
            if progress is not None:
                progress(view, command, navigator.state)
            if not navigator.state.over:
                observation = robot.step(command, step_s)
    except BaseException as error:
        navigator.stop(f"interrupted by {type(error).__name__}")
        raise
    finally:
        robot.step(STAND, 0.0)
    return log.drive(navigator.state, navigator.reason)


class _Log:
    """Columns of numbers that grow: objects would take twenty times as much memory."""

    def __init__(self) -> None:
        self._rows = array("d")
        self._status: list[Status] = []
        self._state: list[DriveState] = []

    def add(self, view: View, command: VelocityCommand, state: DriveState, milliseconds: float) -> None:
        estimate, odometry = view.estimate, view.odometry
        row = (view.timestamp_s, *_pose(estimate), estimate.radius_m, *_pose(odometry))
        moved = (command.forward_m_s, command.turn_rad_s, float(view.bumped), milliseconds)
        self._rows.extend(np.nan if value is None else value for value in (*row, *moved))
        self._status.append(estimate.status)
        self._state.append(state)

    def drive(self, outcome: DriveState, reason: str) -> Drive:
        rows = np.array(self._rows, np.float64).reshape(-1, _COLUMNS)
        return Drive(
            timestamp_s=rows[:, 0],
            estimate=rows[:, 1:4],
            radius_m=rows[:, 4],
            odometry=rows[:, 5:8],
            command=rows[:, 8:10],
            bumped=rows[:, 10] > 0.0,
            milliseconds=rows[:, 11],
            status=tuple(self._status),
            state=tuple(self._state),
            outcome=outcome,
            reason=reason,
        )


def _pose(pose: Estimate | Pose2D) -> tuple[float | None, float | None, float | None]:
    return pose.x_m, pose.y_m, pose.heading_rad
