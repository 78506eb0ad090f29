"""Down the slope of a spectral distance, and on where the slope says nothing: gradient navigation that arrives.

What differs from the thesis' algorithm: all slow features count, each by its slowness (theory 6); they are fitted one
by one instead of their distance; the window grows until the evidence decides the direction; the robot weaves, so that
it does; and where the robot bumps, sees something close ahead, leaves what was mapped or makes no progress, it does
something about it.

It follows a gradient in slow-feature space, which is patented (EP3367061B1, US10955852B2): see docs/navigation.md.
"""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray, Status
from andante.navigation.gradient import slow_of
from andante.navigation.limits import STAND, Limits
from andante.navigation.navigator import LimitedNavigator
from andante.navigation.plane import unit
from andante.navigation.slope import Slope, SlopeWindow
from andante.navigation.slow_cost import SlowCost
from andante.protocols import DriveState, VelocityCommand, View

_TURN_GAIN = 2.5
_THERE_M = 0.25
_SETTLED_M = 3.0
"""After so much way on the map, what was strayed from before does not count any more."""
_INWARDS_M = 0.6
_LEAST_VISIBILITY = 3.0
"""In fits of pure noise it is about 1, and above 2 now and then where there are few images."""
_BACKWARD_M, _BACKWARD_M_S = 0.12, 0.15
_GOLDEN_RAD = 2.399963
"""Multiples of the golden angle are spread evenly, however many there are."""


@dataclass(frozen=True, slots=True)
class CommuteSettings:
    """Lengths in metres; costs in steps of the training drive, the unit of ``SlowCost.spectral``.

    The drive begins with an arc of ``probe_m`` and ``probe_radius_m``. It has arrived where the cost is below
    ``arrived_steps``, or below twice that and the fit puts the goal nearer than ``arrived_m``. The course is decided
    every ``decide_m``; ``weave_rad`` is how far the heading swings about it, once in ``weave_m``. Below ``near_m`` of
    free way the robot goes around what it sees: it turns until ``clear_m`` are free and goes on for ``around_m``.
    Where the cost has not fallen by the share ``progress`` for ``patience_m`` of the way, it goes back to where it
    was lowest, or ``excursion_m`` beside that, farther each time, and begins anew, ``recoveries`` times at most.
    Where it strays from what was mapped, it goes back beyond the most familiar place of the last ``return_m``,
    farther each time; after ``strays`` in a row it gives up.
    """

    probe_m: float = 1.3
    probe_radius_m: float = 0.35
    arrived_steps: float = 1.0
    arrived_m: float = 0.15
    decide_m: float = 0.1
    weave_rad: float = 0.45
    weave_m: float = 1.2
    near_m: float = 0.25
    clear_m: float = 0.6
    around_m: float = 0.5
    progress: float = 0.03
    patience_m: float = 4.0
    excursion_m: float = 0.3
    recoveries: int = 12
    return_m: float = 3.0
    strays: int = 12


class CommuteNavigator(LimitedNavigator):
    """Needs ``View.slow`` and odometry, asks for no pose; uses bump, range and the status off_map where they are."""

    def __init__(
        self,
        cost: SlowCost,
        settings: CommuteSettings | None = None,
        limits: Limits | None = None,
        *,
        name: str = "commute gradient",
    ) -> None:
        super().__init__(name, limits)
        self._cost, self._settings = cost, settings or CommuteSettings()
        self._window = SlopeWindow()
        self._begun, self._way_m = False, 0.0
        self._here = np.zeros(2)
        self._heading = 0.0
        self._course: tuple[float, float] | None = None  # downhill, and the way at which that was decided
        self._lowest, self._lowest_at = np.inf, np.zeros(2)
        self._best, self._best_at_m = np.inf, 0.0
        # Where to begin anew, and the way at which to give that up.
        self._errand: tuple[FloatArray, float] | None = None
        self._recoveries = self._strays = 0
        self._home: tuple[float, FloatArray] = (-1.0, np.zeros(2))
        self._returning, self._strayed_at_m = False, -np.inf
        self._trail: deque[tuple[float, FloatArray]] = deque(
            maxlen=max(round(self._settings.return_m / self._settings.decide_m), 1)
        )
        self._backward_until_m = -np.inf
        self._side, self._side_until_m = 0.0, -np.inf

    def _steer(self, view: View) -> VelocityCommand:
        self._move(view)
        mapped = self._mapped(view)
        if self._state.over:
            return STAND
        if mapped:
            self._window.append(self._here, self._cost.scaled(slow_of(view)), self._way_m)
        slope = self._window.slope(self._here)
        if mapped and slope is not None and self._arrived(slope):
            return STAND
        evasion = self._evasion(view, slope)
        if evasion is not None:
            return evasion
        elsewhere = self._elsewhere(view)
        if elsewhere is not None:
            return elsewhere
        if slope is None or self._way_m < self._settings.probe_m:
            return self._arc()
        self._watch(slope)
        return self._along(self._downhill(slope), view)

    def _move(self, view: View) -> None:
        here = np.array([view.odometry.x_m, view.odometry.y_m])
        if not self._begun:
            self._begun, self._here = True, here
            self._enter(DriveState.DRIVING, "an arc to begin with")
        self._way_m += float(np.hypot(*(here - self._here)))
        self._here, self._heading = here, view.odometry.heading_rad or 0.0

    def _arrived(self, slope: Slope) -> bool:
        distance, steps = float(np.hypot(*slope.to_goal_m)), self._settings.arrived_steps
        near = slope.cost < steps or (slope.cost < 2.0 * steps and distance < self._settings.arrived_m)
        # Where features do not change with place, being alike is not being there.
        if near and slope.visibility > _LEAST_VISIBILITY:
            reason = f"{slope.cost:.1f} steps and about {distance:.2f} m from the goal"
            if self._trail:
                self._enter(DriveState.ARRIVED, reason)
            else:
                self._enter(DriveState.BLOCKED, f"{reason}, but nothing on the way looked like what was mapped")
        return self._state.over

    # Downhill.

    def _arc(self) -> VelocityCommand:
        """Points that are not on a line, to begin with."""
        speed = min(self.limits.forward_m_s, 0.3)
        return VelocityCommand(speed, speed / self._settings.probe_radius_m)

    def _downhill(self, slope: Slope) -> float:
        # A robot that turns on the spot learns nothing new of the slope: it sticks to what it decided.
        if self._course is None or self._way_m - self._course[1] >= self._settings.decide_m:
            ahead = slope.to_goal_m
            self._course = float(np.arctan2(ahead[1], ahead[0])), self._way_m
        return self._course[0] + self._settings.weave_rad * float(
            np.sin(2.0 * np.pi * self._way_m / self._settings.weave_m)
        )

    def _along(self, wanted: float, view: View) -> VelocityCommand:
        off = wrapped(wanted - self._heading)
        speed = self.limits.forward_m_s * max(float(np.cos(off)), 0.0) ** 2
        if view.range_m is not None:
            speed = min(speed, max(view.range_m - 0.1, 0.0) / 0.8)
        return VelocityCommand(speed, float(np.clip(_TURN_GAIN * off, -self.limits.turn_rad_s, self.limits.turn_rad_s)))

    # Around what is ahead: back where it bumped, turn to one side until the way is free, then along for a while.

    def _evasion(self, view: View, slope: Slope | None) -> VelocityCommand | None:
        if view.bumped:
            self._backward_until_m = self._way_m + _BACKWARD_M
        if self._way_m < self._backward_until_m:
            self._begin_around(slope)
            return VelocityCommand(-_BACKWARD_M_S, 0.0)
        around = self._way_m < self._side_until_m
        if view.range_m is not None and view.range_m < (self._settings.clear_m if around else self._settings.near_m):
            self._begin_around(slope)
            return VelocityCommand(0.0, self._side * self.limits.turn_rad_s)
        return VelocityCommand(0.6 * self.limits.forward_m_s, 0.0) if around else None

    def _begin_around(self, slope: Slope | None) -> None:
        # To the same side as a moment ago, or two walls that meet would be looked at in turn.
        if self._side == 0.0 or self._way_m > self._side_until_m + 1.0:
            ahead = np.zeros(2) if slope is None else slope.to_goal_m
            self._side = 1.0 if wrapped(float(np.arctan2(ahead[1], ahead[0])) - self._heading) >= 0.0 else -1.0
        self._side_until_m = self._way_m + self._settings.around_m

    # Strayed from what was mapped: away from the edge.

    def _mapped(self, view: View) -> bool:
        """Whether the view may be believed; where it is of nothing that was mapped, the way leads back."""
        if view.estimate.status != Status.OFF_MAP:
            if not self._trail or np.hypot(*(self._here - self._trail[-1][1])) >= self._settings.decide_m:
                self._trail.append((view.estimate.likeness or 0.0, self._here))
                self._home = max(self._home, self._trail[-1], key=lambda place: place[0])
            if self._way_m > self._strayed_at_m + _SETTLED_M:
                self._strays = 0
            return True
        if not self._trail:  # nothing has looked like the map yet: better a doubtful view than none
            return True
        self._strayed_at_m = self._way_m
        if not self._returning:
            self._strays += 1
            self._begin_anew_at(self._inwards())
            self._returning = True
            self._window.forget()  # the last images before the edge are no good guides either
            self._enter(DriveState.RECOVERING, "this is not what was mapped; back along the way")
        if self._strays > self._settings.strays:
            self._enter(DriveState.BLOCKED, f"strayed {self._strays} times from what was mapped")
        return False

    def _inwards(self) -> FloatArray:
        """A place beyond the most familiar one of the last metres, farther with each stray: away from the edge."""
        familiar = max(self._trail, key=lambda place: place[0])[1]
        if np.hypot(*(familiar - self._here)) < _THERE_M:
            familiar = self._home[1]
        return self._here + unit(familiar - self._here) * (_INWARDS_M + self._settings.excursion_m * self._strays)

    # No progress: back to the best place so far, to one side of it, and from there once more.

    def _watch(self, slope: Slope) -> None:
        if slope.cost < self._lowest:
            self._lowest, self._lowest_at = slope.cost, self._here
        if slope.cost < (1.0 - self._settings.progress) * self._best:
            self._best, self._best_at_m = slope.cost, self._way_m
        if self._way_m - self._best_at_m < self._settings.patience_m:
            return
        self._recoveries += 1
        if self._recoveries > self._settings.recoveries:
            self._enter(DriveState.BLOCKED, f"no way down found, {slope.cost:.1f} steps from the goal")
            return
        angle, radius = _GOLDEN_RAD * self._recoveries, self._settings.excursion_m * self._recoveries
        self._begin_anew_at(self._lowest_at + radius * np.array([np.cos(angle), np.sin(angle)]))
        self._enter(DriveState.RECOVERING, f"no progress at {slope.cost:.1f} steps; back to where it was lower")

    def _begin_anew_at(self, target: FloatArray) -> None:
        self._errand = target, self._way_m + 2.0 * float(np.hypot(*(target - self._here))) + 1.0

    def _elsewhere(self, view: View) -> VelocityCommand | None:
        """Towards the place to begin anew from; ``None`` once there, or when it takes too long."""
        if self._errand is None:
            return None
        target, until = self._errand
        ahead = target - self._here
        if np.hypot(*ahead) > _THERE_M and self._way_m < until:
            return self._along(float(np.arctan2(ahead[1], ahead[0])), view)
        self._errand = self._course = None
        self._best, self._best_at_m = np.inf, self._way_m
        self._returning = False
        self._enter(DriveState.DRIVING, "down the slope again")
        return None
