"""Slow-feature gradient navigation as in the thesis (algorithm 1 of chapter 9, its errata mended).

The robot drives a V, fits a plane to what its images cost there, and goes down. There is no map of metres, no
planner, no guard and no second thought: where it hits something, the trial has failed.

Two errata. The algorithm says to go on "while c < 0.3 or iterations == 200", and means while c >= 0.3 and fewer than
200. And it moves along +eta g at first but along -eta g later; down is -eta g throughout.

The method is patented (EP3367061B1, US10955852B2): see docs/navigation.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray, Pose2D
from andante.errors import ConfigError
from andante.navigation.limits import Limits
from andante.navigation.navigator import LimitedNavigator
from andante.navigation.plane import EstimationMatrix, plane_gradient, unit
from andante.navigation.slow_cost import SlowCost
from andante.protocols import DriveState, VelocityCommand, View

_ALIGNED_RAD = 0.08
_THERE_M = 0.02
_TURN_GAIN = 2.5
_SECONDS_AHEAD = 0.4


@dataclass(frozen=True, slots=True)
class GradientSettings:
    """The thesis' constants (9.3, 9.4).

    ``v_length_m`` is the way of the V-shaped start, both legs together, and ``v_turn_rad`` the turn between them, which
    the thesis does not tell; steps are metres. ``window_m`` of ``None`` keeps the whole history, as in the open; around
    obstacles the thesis keeps a subset, which it does not size.
    """

    v_length_m: float = 1.96
    v_turn_rad: float = 2.0
    eta: float = 0.5
    gamma: float = 0.3
    threshold: float = 0.3
    iterations: int = 200
    window_m: float | None = None


class GradientNavigator(LimitedNavigator):
    """Thesis algorithm 1 as a ``Navigator``: needs ``View.slow`` and odometry, and asks for no pose."""

    def __init__(
        self,
        cost: SlowCost,
        settings: GradientSettings | None = None,
        limits: Limits | None = None,
        *,
        name: str = "gradient",
    ) -> None:
        super().__init__(name, limits)
        self._cost, self._settings = cost, settings or GradientSettings()
        self._matrix = EstimationMatrix(self._settings.window_m)
        self._targets: list[FloatArray] | None = None
        self._step: FloatArray | None = None
        self.iterations = 0

    def _steer(self, view: View) -> VelocityCommand:
        here, cost = np.array([view.odometry.x_m, view.odometry.y_m]), self._cost.of(slow_of(view))
        self._matrix.append(float(here[0]), float(here[1]), cost)
        if view.bumped:
            self._enter(DriveState.BLOCKED, f"hit something after {self.iterations} iterations")
            return VelocityCommand(0.0, 0.0)
        if self._targets is None:
            self._enter(DriveState.DRIVING, "the V-shaped start")
            self._targets = self._legs(view.odometry)
        if self._targets and np.hypot(*(self._targets[0] - here)) < self._near_m():
            self._targets.pop(0)
        if not self._targets and not self._next_step(here, cost):
            return VelocityCommand(0.0, 0.0)
        return towards(self._targets[0], view.odometry, self.limits)

    def _near_m(self) -> float:
        """A control step is as far as the robot cannot be told to stop in between."""
        return max(_THERE_M, 0.1 * self.limits.forward_m_s)

    def _legs(self, start: Pose2D) -> list[FloatArray]:
        """The corner and the end of the V."""
        heading, leg = start.heading_rad or 0.0, self._settings.v_length_m / 2.0
        corner = np.array([start.x_m, start.y_m]) + leg * np.array([np.cos(heading), np.sin(heading)])
        back = heading + self._settings.v_turn_rad
        return [corner, corner + leg * np.array([np.cos(back), np.sin(back)])]

    def _next_step(self, here: FloatArray, cost: float) -> bool:
        """Lines 13 to 23 of the algorithm; whether the drive goes on."""
        settings = self._settings
        if cost < settings.threshold:
            self._enter(DriveState.ARRIVED, f"cost {cost:.2f} below {settings.threshold:g}")
            return False
        if self.iterations >= settings.iterations:
            self._enter(DriveState.TIMED_OUT, f"cost {cost:.2f} after {self.iterations} iterations")
            return False
        descent = -settings.eta * unit(plane_gradient(self._matrix.rows))
        self._step = descent if self._step is None else settings.gamma * self._step + descent
        self.iterations += 1
        self._targets = [here + self._step]
        self._enter(DriveState.DRIVING, f"iteration {self.iterations}, cost {cost:.2f}")
        return True


def slow_of(view: View) -> FloatArray:
    """The slow features of a view; raises ``ConfigError`` where nobody computed them."""
    if view.slow is None:
        raise ConfigError(
            "navigation by slow features needs them in every view, got None; let localize return slowmap.slow_features "
            "of the image besides the estimate"
        )
    return view.slow


def towards(target: FloatArray, pose: Pose2D, limits: Limits) -> VelocityCommand:
    """Turn on the spot until ``target`` (2,) is ahead, then go there, slower at the end."""
    ahead = target - (pose.x_m, pose.y_m)
    off = wrapped(float(np.arctan2(ahead[1], ahead[0])) - (pose.heading_rad or 0.0))
    turn = float(np.clip(_TURN_GAIN * off, -limits.turn_rad_s, limits.turn_rad_s))
    aligned = abs(off) < 2.0 * _ALIGNED_RAD
    forward = min(limits.forward_m_s, float(np.hypot(*ahead)) / _SECONDS_AHEAD) if aligned else 0.0
    return VelocityCommand(forward, turn)
