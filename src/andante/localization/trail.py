"""The last few images along the way that odometry tells: which heading they agree on.

An image without a heading says where a robot is, not which way it looks. Two of them, and what odometry says of the
way between, do: the direction between the places turned against the direction of the way.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from andante.data import FloatArray, Pose2D
from andante.localization.motion import Step

_ROWS, _SPACING_M, _REACH_M = 24, 0.06, 1.5
_LEAST_M, _SLACK_M, _SLACK_SHARE, _AGREED_RAD = 0.3, 0.15, 0.1, 0.5


@dataclass(frozen=True, eq=False)
class Trail:
    """``pose`` by odometry alone, in a frame of its own, and the newest images along it.

    ``rows`` (24, 5), newest first: x and y there, x and y in the map, and one where the image agreed with the
    prediction, else zero.
    """

    pose: Pose2D
    rows: FloatArray

    @classmethod
    def empty(cls) -> Trail:
        """At the beginning."""
        return cls(Pose2D(0.0, 0.0, 0.0), np.full((_ROWS, 5), np.nan))

    def moved(self, step: Step) -> Trail:
        """After a step; one of unknown length cuts the trail."""
        return replace(self, pose=step.after(self.pose)) if step.known else Trail.empty()

    def with_place(self, x_m: float, y_m: float, *, agreed: bool = True) -> Trail:
        """After an image that names a place, unless the last one is from here."""
        row = np.array([self.pose.x_m, self.pose.y_m, x_m, y_m, float(agreed)])
        if np.hypot(*(row[:2] - self.rows[0, :2])) < _SPACING_M:
            return self
        return replace(self, rows=np.vstack([row, self.rows[:-1]]))

    def begun_anew(self) -> Trail:
        """After the robot turned out to be elsewhere: what agreed before says nothing any more."""
        return replace(self, rows=self.rows * [1.0, 1.0, 1.0, 1.0, 0.0])

    @property
    def misfit_m(self) -> float:
        """How far images that agreed lie from the way of the last metre and a half, laid over them as well as it fits.

        The root mean square after the best turn and shift (Umeyama 1991, without scale); zero for fewer than four.
        """
        way = self.rows[:, 0] + 1j * self.rows[:, 1]
        near = (np.abs(way - complex(self.pose.x_m, self.pose.y_m)) < _REACH_M) & (self.rows[:, 4] > 0)
        if near.sum() < 4:
            return 0.0
        way, seen = way[near], self.rows[near, 2] + 1j * self.rows[near, 3]
        way, seen = way - way.mean(), seen - seen.mean()
        turn = np.vdot(way, seen)
        turn = turn / abs(turn) if abs(turn) > 0 else 1.0
        return float(np.sqrt(np.mean(np.abs(seen - turn * way) ** 2)))

    def headings(self, xy: FloatArray, rng: np.random.Generator) -> FloatArray:
        """A heading for each of some places (n, 2) of the robot now: what the way tells, else any."""
        chosen = self.rows[rng.integers(0, _ROWS, len(xy))]
        told, length = self._told(chosen, xy)
        told = told + rng.normal(0.0, 0.05, len(xy)) / np.maximum(length, _LEAST_M)
        return np.where(np.isfinite(told), told, rng.uniform(-math.pi, math.pi, len(xy)))

    def heading(self, xy: FloatArray) -> tuple[float, float] | None:
        """The heading and its deviation of the robot at a place (2,), where two of the images tell and agree."""
        told, length = self._told(self.rows, xy)
        tells = np.isfinite(told)
        if tells.sum() < 2:
            return None
        vector = (length[tells] * np.exp(1j * told[tells])).sum() / length[tells].sum()
        spread = math.sqrt(max(-2.0 * math.log(max(abs(vector), 1e-9)), 0.0))
        return (math.atan2(vector.imag, vector.real), max(spread, 0.1)) if spread < _AGREED_RAD else None

    def consistent(self, count: int) -> bool:
        """Whether the newest ``count`` images are as far apart as the way between them."""
        rows = self.rows[:count]
        if not np.isfinite(rows).all():
            return False
        way, seen = (np.hypot(*(rows[:-1, part] - rows[1:, part]).T) for part in (slice(0, 2), slice(2, 4)))
        return bool((np.abs(way - seen) < _SLACK_M + _SLACK_SHARE * way).all())

    def _told(self, rows: FloatArray, xy: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Headings by rows (n, 5) for places (n, 2) or (2,), NaN where a row does not tell, and how long the way is."""
        way, seen = np.array([self.pose.x_m, self.pose.y_m]) - rows[:, :2], xy - rows[:, 2:4]
        length, apart = np.hypot(*way.T), np.hypot(*seen.T)
        tells = (length > _LEAST_M) & (np.abs(length - apart) < _SLACK_M + _SLACK_SHARE * length)
        turn = np.arctan2(seen[:, 1], seen[:, 0]) - np.arctan2(way[:, 1], way[:, 0])
        return np.where(tells, (self.pose.heading_rad or 0.0) + turn, np.nan), np.nan_to_num(length)
