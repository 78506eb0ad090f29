"""Between one estimate and the next, and where they fail for a while, the wheels say where the robot is."""

from __future__ import annotations

import cmath
import math
from collections import deque
from dataclasses import dataclass

from andante.angles import wrapped
from andante.data import Pose2D, Status
from andante.protocols import View

_GAIN = 0.4
_JUMP_M = 0.8
_JUMPS = 3
_SPACING_M, _PAIRS = 0.08, 40
_LEAST_SPREAD_M = 0.25


@dataclass(frozen=True, slots=True)
class LivePose:
    """Where the robot is now, in the frame of the map; ``bridged_m`` is the way since an estimate said so."""

    x_m: float
    y_m: float
    heading_rad: float
    bridged_m: float = 0.0
    doubtful: bool = False

    def ahead(self, metres: float) -> tuple[float, float]:
        """The point straight ahead."""
        return self.x_m + metres * math.cos(self.heading_rad), self.y_m + metres * math.sin(self.heading_rad)


class Bridge:
    """Keeps the place of the odometry's frame in the map, as estimates tell it.

    Each estimate moves it by a share, so that the jitter of images does not reach the steering, while the wheels
    carry the motion without delay. An estimate that is far off is followed once three in a row agree. Where estimates
    tell no heading, it follows from how their positions and the odometry's went along together: an unknown heading
    becomes known after a way of about half a metre.
    """

    def __init__(self, *, reach_m: float = 1.5, reach_s: float = 10.0) -> None:
        self._reach_m, self._reach_s = reach_m, reach_s
        self._turn: float | None = None  # of the odometry's frame in the map
        self._origin = 0j
        self._pairs: deque[tuple[complex, complex]] = deque(maxlen=_PAIRS)
        self._before: complex | None = None
        self._bridged_m = math.inf
        self._heard_s = -math.inf
        self._far = 0
        self._doubtful = True

    @property
    def waits_for_heading(self) -> bool:
        """Whether there are positions but no heading yet: a short way straight on would tell it."""
        return self._turn is None and bool(self._pairs)

    def update(self, view: View) -> LivePose | None:
        """The pose now; ``None`` where none is known or the last estimate is too far away in way or time."""
        odometry = complex(view.odometry.x_m, view.odometry.y_m)
        if self._before is not None:
            self._bridged_m += abs(odometry - self._before)
        self._before = odometry
        if view.estimate.status.has_pose and view.estimate.x_m is not None and view.estimate.y_m is not None:
            self._hear(view, odometry)
        if self._turn is None or self._bridged_m > self._reach_m or view.timestamp_s - self._heard_s > self._reach_s:
            return None
        here = self._origin + cmath.rect(1.0, self._turn) * odometry
        heading = wrapped(self._turn + _heading(view.odometry))
        return LivePose(here.real, here.imag, heading, self._bridged_m, self._doubtful)

    def _hear(self, view: View, odometry: complex) -> None:
        estimate = view.estimate
        seen = complex(estimate.x_m or 0.0, estimate.y_m or 0.0)
        if not self._pairs or abs(odometry - self._pairs[-1][0]) >= _SPACING_M:
            self._pairs.append((odometry, seen))
        turn = None if estimate.heading_rad is None else estimate.heading_rad - _heading(view.odometry)
        if turn is None:
            turn = _turn_of(self._pairs)
        if turn is None:
            return
        fresh = self._turn is None or math.isinf(self._bridged_m)
        off = abs(seen - self._origin - cmath.rect(1.0, self._turn or 0.0) * odometry)
        self._far = self._far + 1 if off > _JUMP_M else 0
        if not fresh and 0 < self._far < _JUMPS:
            return
        gain = 1.0 if fresh or self._far >= _JUMPS else _GAIN
        before = turn if self._turn is None else self._turn
        self._turn = before + gain * wrapped(turn - before)
        self._origin += gain * (seen - self._origin - cmath.rect(1.0, self._turn) * odometry)
        self._bridged_m, self._heard_s, self._far = 0.0, view.timestamp_s, 0
        self._doubtful = estimate.status == Status.DEGRADED


def _turn_of(pairs: deque[tuple[complex, complex]]) -> float | None:
    """The rotation that best lays odometry onto estimates (Procrustes); ``None`` where they hardly moved."""
    count = len(pairs)
    first, second = (sum(pair[side] for pair in pairs) / count for side in (0, 1))
    spread = sum(abs(odometry - first) ** 2 for odometry, _ in pairs) / count
    if spread < _LEAST_SPREAD_M**2:
        return None
    return cmath.phase(sum((odometry - first).conjugate() * (seen - second) for odometry, seen in pairs))


def _heading(pose: Pose2D) -> float:
    return pose.heading_rad or 0.0
