"""Short motions by the wheels alone: back a little, turn, go a little on."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable
from dataclasses import dataclass
from typing import Literal

from andante.angles import wrapped
from andante.data import Pose2D
from andante.protocols import VelocityCommand, View

_SPEED_M_S, _TURN_RAD_S = 0.2, 0.7
_PATIENCE = 3.0
_NEAR_M = 0.15


@dataclass(frozen=True, slots=True)
class Move:
    """A part of a manoeuvre: metres straight on (negative: backwards) or radians on the spot."""

    kind: Literal["straight", "turn"]
    amount: float

    @property
    def seconds(self) -> float:
        """How long it takes when nothing is in the way."""
        return abs(self.amount) / (_SPEED_M_S if self.kind == "straight" else _TURN_RAD_S)


class Manoeuvre:
    """Moves one after the other; one that something is in the way of is over, and so is one that takes too long."""

    def __init__(self, moves: Iterable[Move]) -> None:
        self._left = deque(moves)
        self._begun: tuple[float, Pose2D] | None = None
        self._turned = 0.0
        self._heading = 0.0

    def command(self, view: View) -> VelocityCommand | None:
        """What to do now; ``None`` once all moves are done."""
        while self._left:
            if self._begun is None:
                self._begun, self._turned = (view.timestamp_s, view.odometry), 0.0
                self._heading = view.odometry.heading_rad or 0.0
                barred = False
            else:
                barred = view.bumped
            if not barred and not self._done(self._left[0], view):
                return _towards(self._left[0])
            self._left.popleft()
            self._begun = None
        return None

    def _done(self, move: Move, view: View) -> bool:
        assert self._begun is not None
        since, start = self._begun
        if view.timestamp_s - since > _PATIENCE * move.seconds + 1.0:
            return True
        if move.kind == "turn":
            heading = view.odometry.heading_rad or 0.0
            self._turned += wrapped(heading - self._heading)
            self._heading = heading
            return abs(self._turned) >= abs(move.amount)
        if move.amount > 0.0 and view.range_m is not None and view.range_m < _NEAR_M:
            return True
        gone = math.hypot(view.odometry.x_m - start.x_m, view.odometry.y_m - start.y_m)
        return gone >= abs(move.amount)


def _towards(move: Move) -> VelocityCommand:
    if move.kind == "turn":
        return VelocityCommand(0.0, math.copysign(_TURN_RAD_S, move.amount))
    return VelocityCommand(math.copysign(_SPEED_M_S, move.amount), 0.0)
