"""Between any navigator and the wheels: brakes before contact, backs off after one."""

from __future__ import annotations

import cmath
import math
from collections import deque
from dataclasses import replace

from andante.data import Pose2D
from andante.navigation.limits import STAND
from andante.navigation.manoeuvre import Manoeuvre, Move
from andante.protocols import DriveState, Navigator, VelocityCommand, View

_BACK_M = 0.15
_SPACING_M, _TRAIL, _TRAIL_WIDTH_M = 0.05, 10, 0.06


class Guarded:
    """A ``Navigator`` that asks another one and holds back what would end in something.

    Forward as far as the range sensor sees free way, at a speed from which the robot can stop within it; backward,
    where no sensor looks, only along the way it just came. ``margin_m`` is kept from everything, ``deceleration_m_s2``
    is how hard the robot brakes, ``step_s`` how long a command holds. Turning on the spot is always allowed: robots
    are round. Without a range sensor all it does is back off from what was bumped into.
    """

    def __init__(
        self, inner: Navigator, *, margin_m: float = 0.03, deceleration_m_s2: float = 0.5, step_s: float = 0.2
    ) -> None:
        self.inner = inner
        self._margin_m, self._deceleration_m_s2, self._step_s = margin_m, deceleration_m_s2, step_s
        self._here, self._heading = 0j, 0.0
        self._trail: deque[complex] = deque(maxlen=4 * _TRAIL)
        self._last_m_s = 0.0
        self._off: Manoeuvre | None = None

    @property
    def name(self) -> str:
        """That of the navigator it guards."""
        return self.inner.name

    @property
    def state(self) -> DriveState:
        """That of the navigator, or recovering while it backs off."""
        return DriveState.RECOVERING if self._off is not None and not self.inner.state.over else self.inner.state

    @property
    def reason(self) -> str:
        """Why."""
        return "backing off from what was bumped into" if self._off is not None else self.inner.reason

    def stop(self, reason: str = "stopped from outside") -> None:
        """Drive no more."""
        self.inner.stop(reason)

    def command(self, view: View) -> VelocityCommand:
        """The inner navigator's command, held back; it is told of everything all the same."""
        self._remember(view.odometry)
        wanted = self.inner.command(view)
        if self.inner.state.over:
            self._off = None
            return STAND
        if view.bumped and self._off is None:
            self._off = Manoeuvre([Move("straight", math.copysign(_BACK_M, -self._last_m_s))])
        if self._off is not None:
            wanted_off = self._off.command(replace(view, bumped=False))
            if wanted_off is None:
                self._off = None
            else:
                wanted = wanted_off
        held = self._held(wanted, view)
        self._last_m_s = held.forward_m_s
        return held

    def _held(self, wanted: VelocityCommand, view: View) -> VelocityCommand:
        forward = wanted.forward_m_s
        if forward > 0.0 and view.range_m is not None:
            forward = min(forward, self._speed(view.range_m - self._margin_m))
        elif forward < 0.0 and view.range_m is not None:
            forward = -min(-forward, self._speed(self._behind_m))
        return VelocityCommand(forward, wanted.turn_rad_s)

    def _speed(self, free_m: float) -> float:
        """From which the robot can stop within ``free_m``, a step of delay included; and what a step can use up."""
        free, late = max(free_m, 0.0), self._deceleration_m_s2 * self._step_s
        return min(math.sqrt(late**2 + 2.0 * self._deceleration_m_s2 * free) - late, free / self._step_s)

    def _remember(self, odometry: Pose2D) -> None:
        here = complex(odometry.x_m, odometry.y_m)
        self._heading = odometry.heading_rad or 0.0
        self._here = here
        if not self._trail or abs(here - self._trail[-1]) >= _SPACING_M:
            self._trail.append(here)

    @property
    def _behind_m(self) -> float:
        """How far the way that was just driven leads straight back."""
        back = -cmath.rect(_SPACING_M, self._heading)
        for steps in range(1, _TRAIL + 1):
            point = self._here + steps * back
            if min(abs(point - one) for one in self._trail) > _TRAIL_WIDTH_M:
                return (steps - 1) * _SPACING_M
        return _TRAIL * _SPACING_M
