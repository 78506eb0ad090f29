"""Where landmarks stand, and what the boxes of several say together: the pose that fits all of it best.

A landmark's position in the map follows from the directions in which the mapped drives saw it. Then the azimuths of two
boxes say something of the position that no heading and no light changes (the angle between them), that of one gives the
heading, and how high a box reaches says how far away it is. Slow features say roughly where the robot is, which
triangulation alone does not: with one landmark there is none, with two it has a circle of answers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import Self

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray
from andante.landmarks.boxes import Box

_LEAST_FRAMES = 8
_LEAST_SPREAD_RAD = 0.1
_LEAST_BEARING_RAD = float(np.radians(0.3))
_LEAST_REACH = 0.02
_NORMAL_MAD = 1.4826
_ROUNDS = 30
_MOST_DISTRUST = 2.0
"""Deviations from which on something counts less and less: a box half hidden, a place taken for another (Cauchy)."""
_LEAST_DISTANCE_M = 0.3
_ANOTHER_DAY = 2.0
_STOP_M, _STUCK = 1e-4, 1e3
_DESCENTS = 2


@dataclass(frozen=True, slots=True)
class Geometry:
    """A landmark seen as a thing in the map frame: its position, and how far boxes deviate from what it predicts.

    ``x_m, y_m`` is the position; the azimuth of a box deviates by ``bearing_rad`` from the direction to it. The top of
    a box is at elevation t with log tan t = ``rise`` - log distance, and deviates by ``rise_sigma``.
    """

    x_m: float
    y_m: float
    bearing_rad: float
    rise: float
    rise_sigma: float

    @classmethod
    def fit(cls, boxes: Sequence[Box], poses: FloatArray) -> Self | None:
        """From boxes and the poses (n, 3) that saw them; ``None`` where headings or different directions are lacking.

        Robust least squares: a box that is half hidden has its middle elsewhere.
        """
        known = np.isfinite(poses).all(axis=1)
        angles = np.array([(box.azimuth_rad, _top(box)) for box in boxes]).reshape(-1, 2)[known]
        xy, direction = poses[known, :2], angles[:, 0] + poses[known, 2]
        if len(xy) < _LEAST_FRAMES or np.hypot(np.cos(direction).mean(), np.sin(direction).mean()) > 1 - (
            _LEAST_SPREAD_RAD**2 / 2
        ):
            return None
        place, off = _intersection(xy, direction)
        distance = np.maximum(np.linalg.norm(place - xy, axis=1), _LEAST_DISTANCE_M)
        rises = np.log(np.tan(angles[:, 1])) + np.log(distance)
        rise = float(np.median(rises))
        return cls(
            float(place[0]),
            float(place[1]),
            max(_deviation(off), _LEAST_BEARING_RAD),
            rise,
            max(_deviation(rises - rise), _LEAST_REACH),
        )

    @property
    def numbers(self) -> list[float]:
        """For a file."""
        return [self.x_m, self.y_m, self.bearing_rad, self.rise, self.rise_sigma]


@dataclass(frozen=True, slots=True, eq=False)
class Adjusted:
    """A pose (x, y, heading), its covariance (3, 3), and what it costs: the lower, the better all fits."""

    pose: FloatArray
    covariance: FloatArray
    cost: float


def adjusted(xy: FloatArray, covariance: FloatArray, boxes: Sequence[Box], geometries: Sequence[Geometry]) -> Adjusted:
    """The pose that m landmarks agree on best.

    Landmark i puts the robot at ``xy`` (m, 2) with ``covariance`` (m, 2, 2), and is seen in ``boxes`` (m) as the thing
    of ``geometries`` (m). Robust maximum likelihood by Gauss-Newton steps from the two likeliest of these positions and
    their mean; what disagrees with the rest loses its weight.
    """
    terms = _Terms.of(xy, covariance, boxes, geometries)
    information = terms.position_information
    mean = np.linalg.solve(information.sum(axis=0), np.einsum("mij,mj->i", information, xy))
    starts = np.concatenate([mean[None], xy]) if len(xy) > 1 else xy
    likeliest = sorted((terms.standing(start) for start in starts), key=terms.cost)[:_DESCENTS]
    return min((terms.descend(pose) for pose in likeliest), key=lambda found: found.cost)


@dataclass(frozen=True, slots=True, eq=False)
class Refined:
    """A pose (x, y, heading), its covariance (3, 3), and how well boxes ``fit`` it (m,).

    That is the deviation of each azimuth from what the pose that was known before lets expect, in standard deviations
    of both together: one that has pulled the pose to itself fits no better for that. Where the heading was not known,
    it is from the heading that suits all boxes best, so that a single one always fits.
    """

    pose: FloatArray
    covariance: FloatArray
    fit: FloatArray


def refined(pose: FloatArray, covariance: FloatArray, boxes: Sequence[Box], geometries: Sequence[Geometry]) -> Refined:
    """A pose (3,) that is known already, with its covariance (3, 3), by where landmarks (m >= 1) are seen from it.

    Boxes of another day, by a detector, deviate twice as far as those of the mapped drives did. Robust as ``adjusted``:
    a box at a wrong place says nothing. Where the covariance of the heading is NaN, it is not known.
    """
    known = np.isfinite(covariance[2, 2])
    information, spread = np.zeros((3, 3)), np.zeros((3, 3))
    size = 3 if known else 2
    spread[:size, :size] = covariance[:size, :size]
    information[:size, :size] = np.linalg.inv(spread[:size, :size])
    looser = [
        replace(one, bearing_rad=_ANOTHER_DAY * one.bearing_rad, rise_sigma=_ANOTHER_DAY * one.rise_sigma)
        for one in geometries
    ]
    terms = _Terms.of(np.empty((0, 2)), np.empty((0, 2, 2)), boxes, looser)
    start = pose.copy() if known else terms.standing(pose[:2])
    terms = replace(terms, prior=start, prior_information=information)
    slope = terms.slope(start)
    fit = np.abs(terms.turned(start)) / np.sqrt(1.0 + np.einsum("mi,ij,mj->m", slope, spread, slope))
    found = terms.descend(start)
    return Refined(found.pose, found.covariance, fit)


@dataclass(frozen=True, slots=True, eq=False)
class _Terms:
    """Everything that pulls at the pose, in arrays over m landmarks and k positions that their views say.

    Besides, the pose itself may be known (3,), with an information (3, 3).
    """

    xy: FloatArray
    position_information: FloatArray
    azimuth: FloatArray
    log_top: FloatArray
    things: FloatArray
    bearing_sigma: FloatArray
    rise: FloatArray
    rise_sigma: FloatArray
    prior: FloatArray = field(default_factory=lambda: np.zeros(3))
    prior_information: FloatArray = field(default_factory=lambda: np.zeros((3, 3)))

    @classmethod
    def of(cls, xy: FloatArray, covariance: FloatArray, boxes: Sequence[Box], geometries: Sequence[Geometry]) -> _Terms:
        things = np.array([one.numbers for one in geometries])
        return cls(
            xy,
            np.asarray(np.linalg.inv(covariance), np.float64),
            np.array([box.azimuth_rad for box in boxes]),
            np.log(np.tan([_top(box) for box in boxes])),
            things[:, :2],
            things[:, 2],
            things[:, 3],
            things[:, 4],
        )

    def standing(self, xy: FloatArray) -> FloatArray:
        """The pose (3,) at a position, with the heading that suits it best."""
        offset = self.things - xy
        turn = np.arctan2(offset[:, 1], offset[:, 0]) - self.azimuth
        pull = 1.0 / self.bearing_sigma**2
        return np.array([*xy, np.arctan2((pull * np.sin(turn)).sum(), (pull * np.cos(turn)).sum())])

    def turned(self, pose: FloatArray) -> FloatArray:
        """(m,) how far azimuths deviate from what is expected at a pose, in standard deviations."""
        offset = self.things - pose[:2]
        expected = np.arctan2(offset[:, 1], offset[:, 0]) - pose[2]
        return np.asarray(wrapped(expected - self.azimuth) / self.bearing_sigma, np.float64)

    def slope(self, pose: FloatArray) -> FloatArray:
        """(m, 3) by how much ``turned`` grows with x, y and the heading."""
        offset = self.things - pose[:2]
        square = np.maximum(np.linalg.norm(offset, axis=1), _LEAST_DISTANCE_M) ** 2
        across = np.stack([offset[:, 1], -offset[:, 0], -square], 1)
        return np.asarray(across / (square * self.bearing_sigma)[:, None], np.float64)

    def cost(self, pose: FloatArray) -> float:
        """How badly a pose fits."""
        return self._linearised(pose)[2]

    def descend(self, pose: FloatArray) -> Adjusted:
        """To the pose near this one that fits best."""
        hessian, gradient, cost = self._linearised(pose)
        damping = 1e-3
        for _ in range(_ROUNDS):
            step = -np.linalg.solve(hessian + damping * np.diag(np.diag(hessian)), gradient)
            tried = self._linearised(pose + step)
            if tried[2] <= cost:
                pose, damping = pose + step, damping / 5
                hessian, gradient, cost = tried
                if np.hypot(*step[:2]) < _STOP_M:
                    break
            elif damping > _STUCK:
                break
            else:
                damping *= 10
        pose[2] = wrapped(float(pose[2]))
        return Adjusted(pose, np.asarray(np.linalg.inv(hessian), np.float64), cost)

    def _linearised(self, pose: FloatArray) -> tuple[FloatArray, FloatArray, float]:
        """Hessian (3, 3), gradient (3,) and cost at a pose, with the weights that hold there."""
        hessian, gradient, cost = np.zeros((3, 3)), np.zeros(3), 0.0
        apart = pose[:2] - self.xy
        pulled = np.einsum("mij,mj->mi", self.position_information, apart)
        weight, loss = _cauchy((apart * pulled).sum(axis=1))
        hessian[:2, :2] += np.einsum("m,mij->ij", weight, self.position_information)
        gradient[:2] += weight @ pulled
        cost += loss
        moved = pose - self.prior
        moved[2] = wrapped(float(moved[2]))
        pulled = self.prior_information @ moved
        (pull,), loss = _cauchy(np.array([moved @ pulled]))
        hessian += pull * self.prior_information
        gradient += pull * pulled
        cost += loss
        offset = self.things - pose[:2]
        distance = np.maximum(np.linalg.norm(offset, axis=1), _LEAST_DISTANCE_M)
        reach = (self.rise - np.log(distance) - self.log_top) / self.rise_sigma
        along = np.stack([offset[:, 0], offset[:, 1], 0 * distance], 1) / (distance**2 * self.rise_sigma)[:, None]
        for residual, slope in ((self.turned(pose), self.slope(pose)), (reach, along)):
            weight, loss = _cauchy(residual**2)
            hessian += np.einsum("m,mi,mj->ij", weight, slope, slope)
            gradient += (weight * residual) @ slope
            cost += loss
        return hessian, gradient, cost


def _cauchy(squared: FloatArray) -> tuple[FloatArray, float]:
    """Weights (m,) of residuals with these squares, and their cost."""
    share = squared / _MOST_DISTRUST**2
    return 1.0 / (1.0 + share), float(_MOST_DISTRUST**2 / 2 * np.log1p(share).sum())


def _intersection(xy: FloatArray, direction: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Where rays from ``xy`` (n, 2) in ``direction`` (n,) meet, and how far each is off, in radians."""
    normal = np.stack([-np.sin(direction), np.cos(direction)], 1)
    target = (normal * xy).sum(axis=1)
    weight = np.ones(len(xy))
    for _ in range(_ROUNDS):
        place = np.linalg.lstsq(normal * weight[:, None], target * weight)[0]
        offset = place - xy
        distance = np.maximum(np.linalg.norm(offset, axis=1), _LEAST_DISTANCE_M)
        off = wrapped(np.arctan2(offset[:, 1], offset[:, 0]) - direction)
        sigma = max(_deviation(off), _LEAST_BEARING_RAD)
        # What is across a ray is an angle times a distance; what points backwards is no evidence.
        weight = np.sqrt(1.0 / (1.0 + (off / (_MOST_DISTRUST * sigma)) ** 2)) / distance
    return place, off


def _top(box: Box) -> float:
    """Elevation of the upper edge, kept where its tangent is of use."""
    return float(np.clip(box.elevation_rad + box.height_rad / 2, 1e-3, 1.5))


def _deviation(values: FloatArray) -> float:
    return _NORMAL_MAD * float(np.median(np.abs(values)))
