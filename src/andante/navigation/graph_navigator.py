"""The default navigator: along the shortest way that was driven before, with the live pose."""

from __future__ import annotations

import math
from collections import deque

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray, Pose2D
from andante.navigation.bridge import Bridge, LivePose
from andante.navigation.limits import STAND, Limits
from andante.navigation.manoeuvre import Manoeuvre, Move
from andante.navigation.navigator import LimitedNavigator
from andante.navigation.place_graph import PlaceGraph, length_m
from andante.protocols import DriveState, VelocityCommand, View

_AHEAD_M = 0.5
_PLAN_S = 1.0
_ON_THE_SPOT_RAD = 0.7
_HEADING_RAD = 0.15
_CONFIRMED = 4
"""Steps in a row within the tolerance: one estimate alone may be wrong."""
_NEAR_M = 0.12
_BODY_M = 0.25
_STUCK_S, _STEP_M = 12.0, 0.2
_CREEP_M_S, _SEARCH_RAD_S = 0.15, 0.5
_SEARCH_M = 0.6
_KEPT_PLANS = 50
_DEAD_ENDS = 2
"""Plans without a way before it gives up; each but the last forgets what was thought to be blocked."""
_SQUEEZE = 0.6
"""Of the clearance, in the last round: with all of it a narrow way is closed by a touch of one of its sides."""
_RECOVERIES, _AT_GOAL = 40, 4
"""As often it tries something else before it gives up, and where something stands at the goal itself."""


class PlaceGraphNavigator(LimitedNavigator):
    """Implements ``Navigator``: plans on a ``PlaceGraph``, steers by pure pursuit, replans where a way is blocked.

    ``goal`` is in the frame of the map, with a heading or without; it is reached within ``tolerance_m`` of the pose
    that estimates and odometry tell together. What it bumps into, or what the range sensor sees close ahead, closes the
    edges around it. Lost it stops, turns and looks, and then goes a little. Uses no gradient of slow features.
    ``plans`` are the ways that it planned and when: at first, and after every obstacle or trouble.
    """

    def __init__(
        self, graph: PlaceGraph, goal: Pose2D, limits: Limits | None = None, *, tolerance_m: float = 0.3
    ) -> None:
        super().__init__("place graph", limits)
        self.replans = 0
        self.plans: deque[tuple[float, FloatArray]] = deque(maxlen=_KEPT_PLANS)
        self._graph, self._goal, self._tolerance_m = graph, goal, tolerance_m
        self._goal_m = np.array([goal.x_m, goal.y_m])
        graph.path(self._goal_m, self._goal_m)  # raises for a goal off the map, before anything moves
        self._bridge = Bridge()
        self._blocked: list[tuple[float, float]] = []
        self._way: FloatArray | None = None
        self._planned_s = self._better_s = -math.inf
        self._left_m = math.inf
        self._confirmed, self._dead_ends, self._recoveries, self._at_goal = 0, 0, 0, 0
        self._moves: Manoeuvre | None = None

    def _steer(self, view: View) -> VelocityCommand:
        pose = self._bridge.update(view)
        if view.bumped and (self._moves is None or self.state == DriveState.DRIVING):
            self._hit(pose, 0.0, "bumped into something")
        if self._moves is not None:
            if pose is not None and self.reason == "lost":
                self._moves = None
            else:
                command = self._moves.command(view)
                if command is not None:
                    return command
                self._moves = None
        if pose is None:
            return self._search(view)
        return self._there(pose) if self._arriving(pose) else self._follow(pose, view)

    def _arriving(self, pose: LivePose) -> bool:
        near = math.dist((pose.x_m, pose.y_m), self._goal_m) <= self._tolerance_m and pose.bridged_m < self._tolerance_m
        self._confirmed = self._confirmed + 1 if near else 0
        return self._confirmed >= _CONFIRMED

    def _there(self, pose: LivePose) -> VelocityCommand:
        off = 0.0 if self._goal.heading_rad is None else wrapped(self._goal.heading_rad - pose.heading_rad)
        if abs(off) <= _HEADING_RAD:
            self._enter(DriveState.ARRIVED, f"within {self._tolerance_m:g} m of the goal")
            return STAND
        return VelocityCommand(0.0, 1.5 * off)

    def _follow(self, pose: LivePose, view: View) -> VelocityCommand:
        here = np.array([pose.x_m, pose.y_m])
        if self._way is None or view.timestamp_s - self._planned_s >= _PLAN_S:
            self._plan(here, view.timestamp_s)
        if self._way is None or self.state.over:
            return STAND
        if view.timestamp_s - self._better_s > _STUCK_S:
            return self._recover(view)
        self._enter(DriveState.DRIVING, "on the way")
        target, left = _ahead(self._way, here, _AHEAD_M)
        bearing = wrapped(math.atan2(*(target - here)[::-1]) - pose.heading_rad)
        if abs(bearing) > _ON_THE_SPOT_RAD:
            return VelocityCommand(0.0, math.copysign(min(2.0 * abs(bearing), 1.0), bearing))
        if view.range_m is not None and view.range_m < min(_NEAR_M, left) and abs(bearing) < 0.3:
            self._hit(pose, view.range_m, "something is in the way")
            return STAND
        speed = self.limits.forward_m_s * math.cos(bearing) ** 2 * min(1.0, 0.2 + left)
        if pose.doubtful or pose.bridged_m > _AHEAD_M:
            speed *= 0.5
        distance = max(float(np.hypot(*(target - here))), 0.2)
        return VelocityCommand(speed, 2.0 * speed * math.sin(bearing) / distance + 0.5 * bearing)

    def _plan(self, here: FloatArray, now_s: float) -> None:
        self._way = self._graph.path(here, self._goal_m, self._blocked)
        if self._way is None and self._dead_ends == _DEAD_ENDS - 1:
            narrow = _SQUEEZE * self._graph.radius_m
            self._way = self._graph.path(here, self._goal_m, self._blocked, narrow)
        self._planned_s = now_s
        if self._way is None:
            self._dead_ends += 1
            if self._dead_ends >= _DEAD_ENDS:
                self._enter(DriveState.BLOCKED, "every mapped way to the goal is blocked")
            self._blocked.clear()
            return
        if math.isinf(self._left_m):
            self.plans.append((now_s, self._way))
        left = length_m(self._way)
        if left < self._left_m - _STEP_M:
            self._left_m, self._better_s = left, now_s

    def _hit(self, pose: LivePose | None, ahead_m: float, why: str) -> None:
        """Something is ahead: other edges from now on, and a little back, or the next way would begin at it too.

        Met again, it is not where the pose says that it is, or the pose is off beside it: on, from another side.
        """
        again = False
        if pose is not None:
            spot = pose.ahead(ahead_m + _BODY_M)
            again = any(math.dist(spot, one) < _BODY_M for one in self._blocked)
            self._blocked.append(spot)
            self.replans += 1
            self._at_goal += math.dist(spot, self._goal_m) < _BODY_M  # no way leads around that
        if self._at_goal >= _AT_GOAL:
            self._enter(DriveState.BLOCKED, "something stands at the goal")
        else:
            self._try(why, Move("straight", -0.2), *(self._sideways() if again else ()))

    def _recover(self, view: View) -> VelocityCommand:
        """No progress: back, and on from another side."""
        self._better_s = view.timestamp_s
        self._try("no progress", Move("straight", -0.2), *self._sideways())
        return STAND

    def _sideways(self) -> tuple[Move, Move]:
        """To the left and to the right in turn."""
        return Move("turn", 1.2 if self._recoveries % 2 else -1.2), Move("straight", 0.4)

    def _try(self, why: str, *moves: Move) -> None:
        """Something else, after which it plans anew and progress counts anew; not for ever."""
        self._recoveries += 1
        if self._recoveries > _RECOVERIES:
            self._enter(DriveState.BLOCKED, f"{why}, and {_RECOVERIES} attempts to get around it failed")
            return
        self._enter(DriveState.RECOVERING, why)
        self._moves, self._way, self._left_m = Manoeuvre(moves), None, math.inf

    def _search(self, view: View) -> VelocityCommand:
        """Without a pose: straight on slowly where only the heading is missing, else look around and go a little."""
        self._way, self._left_m, self._confirmed = None, math.inf, 0
        free = view.range_m is None or view.range_m > _SEARCH_M
        if self._bridge.waits_for_heading and view.estimate.status.has_pose:
            self._enter(DriveState.RECOVERING, "heading unknown")
            return VelocityCommand(_CREEP_M_S, 0.0) if free else VelocityCommand(0.0, _SEARCH_RAD_S)
        self._enter(DriveState.RECOVERING, "lost")
        self._moves = Manoeuvre([Move("turn", math.tau), *([Move("straight", 0.5)] if free else [])])
        return STAND


def _ahead(way: FloatArray, here: FloatArray, ahead_m: float) -> tuple[FloatArray, float]:
    """The point of a way so far beyond the one nearest to ``here``, and the metres left from there to its end."""
    steps = np.diff(way, axis=0)
    square = np.maximum((steps**2).sum(1), 1e-12)
    share = np.clip(((here - way[:-1]) * steps).sum(1) / square, 0.0, 1.0)
    off = np.linalg.norm(way[:-1] + share[:, None] * steps - here, axis=1)
    arc = np.concatenate([[0.0], np.cumsum(np.sqrt(square))])
    nearest = int(off.argmin())
    at = arc[nearest] + share[nearest] * math.sqrt(float(square[nearest]))
    target = np.array([np.interp(at + ahead_m, arc, way[:, axis]) for axis in (0, 1)])
    return target, float(arc[-1] - at)
