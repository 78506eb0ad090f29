"""How slow features change around the robot: a local linear fit with the evidence's own noise.

The cost has a kink at the goal and folds around obstacles, and a plane fits it badly there; the slow features
themselves are smooth. So each of them is fitted, offset to the goal and in units of the cost, z(p) = z_0 + J (p -
p_0), and gradient and distance follow from all of them: the gradient of |z|^2 / 2 is J^T z_0, and the goal lies, as
far as the fit reaches, at p_0 - (J^T J)^-1 J^T z_0. Residuals of the fit are the noise, which says how certain the
direction is.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from andante.data import FloatArray

_HUBER = 1.5
_ROUNDS = 3
_DAMPING = 0.05
_LEAST_ROWS = 6
_LEAST_SPREAD_M = 0.01
"""Deviation of the positions across the way that a slope across it takes at least."""
_STEADY_M = 0.02
"""Images that are nearer to each other than this are averaged: they tell of noise, not of direction."""


@dataclass(frozen=True, slots=True, eq=False)
class Slope:
    """Around one place: ``offset`` (k,) to the goal and its derivative ``jacobian`` (k, 2) per metre.

    ``information`` (2, 2) is the inverse covariance of a derivative of unit noise, and ``noise`` (k,) the deviation of
    an image's features from the fit.
    """

    offset: FloatArray
    jacobian: FloatArray
    information: FloatArray
    noise: FloatArray

    @property
    def cost(self) -> float:
        """The distance to the goal in the unit of the cost, noise averaged away."""
        return float(np.linalg.norm(self.offset))

    @property
    def gradient(self) -> FloatArray:
        """(2,) uphill, of half the squared cost per metre."""
        gradient: FloatArray = self.jacobian.T @ self.offset
        return gradient

    @property
    def significance(self) -> float:
        """The gradient in standard deviations of itself: below 3 its direction is not worth much."""
        g, scale = self.gradient, float((self.offset * self.noise) @ (self.offset * self.noise))
        return float(np.sqrt(np.maximum(g @ self.information @ g, 0.0) / max(scale, 1e-18)))

    @property
    def visibility(self) -> float:
        """How much features change over the window, in units of their noise (root mean square).

        Near one or below there is nothing to be seen: the map has no idea of where this is.
        """
        change = np.einsum("ki,ij,kj->k", self.jacobian, self.information, self.jacobian) / 2.0
        return float(np.sqrt((change / np.maximum(self.noise, 1e-12) ** 2).mean()))

    @property
    def to_goal_m(self) -> FloatArray:
        """(2,) metres: where the linear fit has its minimum, damped where it hardly changes along some direction."""
        normal = self.jacobian.T @ self.jacobian
        damped = normal + _DAMPING * np.trace(normal) / 2.0 * np.eye(2)
        if not np.linalg.det(damped) > 0.0:
            return np.zeros(2)
        way: FloatArray = -np.linalg.solve(damped, self.gradient)
        return way


class SlopeWindow:
    """What the last images showed, and the slope that follows from the shortest stretch of the way that decides it."""

    def __init__(self, lengths_m: Sequence[float] = (0.8, 1.2, 1.8, 2.6), significance: float = 4.0) -> None:
        self._lengths_m, self._significance = tuple(lengths_m), significance
        self._rows: deque[_Row] = deque()

    def append(self, here: FloatArray, offset: FloatArray, way_m: float) -> None:
        """One more image: where (2,) by odometry, after which way, and its offset (k,) to the goal."""
        last = self._rows[-1] if self._rows else None
        if last is not None and np.hypot(*(here - last.here)) < _STEADY_M:
            last.count += 1
            last.offset = last.offset + (offset - last.offset) / last.count
            return
        self._rows.append(_Row(here, offset, way_m))
        while self._rows[0].way_m < way_m - self._lengths_m[-1]:
            self._rows.popleft()

    def forget(self) -> None:
        """Begin with nothing."""
        self._rows.clear()

    def slope(self, here: FloatArray) -> Slope | None:
        """The slope at ``here`` (2,); ``None`` while there is too little to fit."""
        fitted = None
        for length_m in self._lengths_m:
            rows = [row for row in self._rows if row.way_m >= self._rows[-1].way_m - length_m]
            if len(rows) < _LEAST_ROWS:
                continue
            fitted = _fitted(here, rows)
            if fitted.significance >= self._significance:
                break
        return fitted


@dataclass(slots=True, eq=False)
class _Row:
    here: FloatArray
    offset: FloatArray
    way_m: float
    count: int = 1


def _fitted(here: FloatArray, rows: Sequence[_Row]) -> Slope:
    """Weighted least squares; images that fit badly count less (Huber), as those with someone in front of the lens."""
    position = np.array([row.here for row in rows]) - here
    offset = np.array([row.offset for row in rows])
    count = np.minimum([row.count for row in rows], 4.0)
    design = np.column_stack([np.ones(len(rows)), position])
    weight = count
    for _ in range(_ROUNDS):
        coefficients = _least_squares(design, offset, weight)
        residual = offset - design @ coefficients
        size = np.sqrt((residual**2).sum(axis=1))
        bound = _HUBER * max(float(np.median(size)), 1e-12)
        weight = np.asarray(count * np.minimum(1.0, bound / np.maximum(size, 1e-12)), np.float64)
    spare = max(len(rows) - 3, 1)
    noise = np.asarray(np.sqrt((weight[:, None] * residual**2).sum(axis=0) / weight.mean() / spare), np.float64)
    centred = position - np.average(position, axis=0, weights=weight)
    return Slope(coefficients[0], coefficients[1:].T, (centred * weight[:, None]).T @ centred, noise)


def _least_squares(design: FloatArray, target: FloatArray, weight: FloatArray) -> FloatArray:
    """Coefficients (3, k) of ``design`` (n, 3); a direction in which the robot has not moved is given no slope."""
    weighted = design.T * weight
    normal = weighted @ design
    normal[[1, 2], [1, 2]] += _LEAST_SPREAD_M**2 * weight.sum()
    return np.asarray(np.linalg.solve(normal, weighted @ target), np.float64)
