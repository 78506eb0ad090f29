"""What all navigators share: limits, a clock that runs out, and an end that stays one."""

from __future__ import annotations

from abc import ABC, abstractmethod

from andante.navigation.limits import STAND, Limits
from andante.protocols import DriveState, VelocityCommand, View


class LimitedNavigator(ABC):
    """A ``Navigator`` that leaves only the steering to be said.

    A subclass says in ``_steer`` how it would like to move, and sets ``_enter`` when its state changes; this class
    holds that within ``limits``, ends the drive when its time is up, and stands still once it is over.
    """

    def __init__(self, name: str, limits: Limits | None = None) -> None:
        self._name = name
        self.limits = limits or Limits()
        self._state = DriveState.DRIVING
        self._reason = "not started yet"
        self._started_s: float | None = None
        self._before_s = 0.0
        self._last = STAND

    @property
    def name(self) -> str:
        """The name in tables."""
        return self._name

    @property
    def state(self) -> DriveState:
        """What it is about."""
        return self._state

    @property
    def reason(self) -> str:
        """Why, in words."""
        return self._reason

    def command(self, view: View) -> VelocityCommand:
        """One control step, within the limits; stands still once the drive is over."""
        if self._started_s is None:
            self._started_s = self._before_s = view.timestamp_s
        if not self._state.over and view.timestamp_s - self._started_s >= self.limits.timeout_s:
            self._enter(DriveState.TIMED_OUT, f"not there after {self.limits.timeout_s:g} s")
        wanted = STAND if self._state.over else self._steer(view)
        if self._state.over:
            wanted = STAND
        self._last = self.limits.held(wanted, self._last, view.timestamp_s - self._before_s)
        self._before_s = view.timestamp_s
        return self._last

    def stop(self, reason: str = "stopped from outside") -> None:
        """Drive no more."""
        if not self._state.over:
            self._enter(DriveState.STOPPED, reason)

    def _enter(self, state: DriveState, reason: str) -> None:
        self._state, self._reason = state, reason

    @abstractmethod
    def _steer(self, view: View) -> VelocityCommand:
        """How to move now; asked only while the drive is not over."""
