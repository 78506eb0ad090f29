"""The extended Kalman filter of the thesis (8.6): x, y and heading, moved by odometry, corrected by images."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, Hypothesis
from andante.errors import ArrayError
from andante.localization.config import KalmanConfig, MotionConfig
from andante.localization.filters import Gauss, Weighted
from andante.localization.judge import Belief
from andante.localization.motion import Step
from andante.localization.sighting import RADIUS_PER_SIGMA, Sighting
from andante.localization.trail import Trail

_ANY_HEADING_RAD2 = math.pi**2 / 3
"""The variance of a heading of which nothing is known."""
_SLIP_VARIANCE = 1 / 12
"""Of wheels that turn half as far as the robot goes, or half as far again, or anything between."""
_DRIFT_M, _DRIFT_S = 10.0, 20.0
"""How long a constant error of wheels and gyro goes on before images have taken it out."""


class KalmanFilter:
    """One Gaussian.

    What is farther than the gate from the prediction is rejected; when ``rejections`` in a row agree among each other,
    the filter begins anew with them (theory 8). Without headings in images the filter knows none until two images and
    the way between them tell it (``Trail``).
    """

    def __init__(self, config: KalmanConfig) -> None:
        self._config = config
        self._gauss: Gauss | None = None
        self._rejected = 0
        self._moved_m = 0.0

    @property
    def best(self) -> Gauss | None:
        """The place that is believed in most; ``None`` while empty."""
        return self._gauss

    @property
    def belief(self) -> Belief | None:
        """What decides how far it is believed."""
        if self._gauss is None:
            return None
        radius = RADIUS_PER_SIGMA * math.sqrt(float(np.linalg.eigvalsh(self._gauss.covariance[:2, :2])[-1]))
        return Belief(radius, radius, 1.0, self._moved_m)

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """All places, best first."""
        if self._gauss is None:
            return ()
        x, y, heading = self._gauss.mean.tolist()
        return (Hypothesis(x, y, 1.0, heading if self._gauss.heading_known else None),)

    def move(self, step: Step) -> None:
        """Follow odometry."""
        self._moved_m = 0.0
        if self._gauss is not None:
            self._gauss = moved(self._gauss, step, self._config.motion)

    def correct(self, seen: list[Weighted], trail: Trail, *, doubt: float) -> None:
        """Take in what was seen; see ``Filter``."""
        del doubt  # three rejections decide here
        for one in seen:
            if self._gauss is None:
                self._gauss = _begun(one.sighting, trail)
            elif one.decision > 0:
                self._take(one, self._gauss, trail)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Its state, for a file."""
        if self._gauss is None:
            return {}
        return {
            "mean": self._gauss.mean,
            "covariance": self._gauss.covariance,
            "rejected": np.array([float(self._rejected)]),
        }

    @property
    def generator_state(self) -> None:
        """It draws nothing."""
        return None

    def resume(self, arrays: Mapping[str, FloatArray], generator: dict[str, Any] | None) -> None:
        """The inverse of both; raises ``ValueError``, ``KeyError`` or ``TypeError`` for what does not fit."""
        del generator
        if not arrays:
            return
        shapes = {name: array.shape for name, array in arrays.items()}
        if shapes != {"mean": (3,), "covariance": (3, 3), "rejected": (1,)}:
            raise ArrayError(f"a state of the Kalman filter is a mean (3,), a covariance (3, 3), a count, got {shapes}")
        if (
            not np.array_equal(arrays["covariance"], arrays["covariance"].T)
            or (np.linalg.eigvalsh(arrays["covariance"]) <= 0).any()
        ):
            raise ArrayError("a covariance is symmetric and positive definite")
        self._gauss = Gauss(arrays["mean"], arrays["covariance"])
        self._rejected = int(arrays["rejected"][0])

    def _take(self, one: Weighted, gauss: Gauss, trail: Trail) -> None:
        """Correct by a sighting, or count it among those rejected."""
        corrected = _corrected(gauss, one, self._config.gate)
        if corrected is not None:
            self._gauss, self._rejected = _with_told_heading(corrected, trail), 0
            return
        if not one.sighting.trusted:
            return
        self._rejected += 1
        if self._rejected >= self._config.rejections and trail.consistent(self._config.rejections):
            begun = _begun(one.sighting, trail)
            self._moved_m = float(np.hypot(*(begun.mean[:2] - gauss.mean[:2])))
            self._gauss, self._rejected = begun, 0


def moved(gauss: Gauss, step: Step, config: MotionConfig) -> Gauss:
    """After a step of odometry, or a random walk where it is unknown.

    Wheel scale and gyro bias are no part of the state; their deviations count as if they erred in every step anew but
    in one direction, so that drift grows with the way and not with its root.
    """
    if not step.known:
        walk = np.array([config.walk_m**2, config.walk_m**2, config.walk_rad**2]) * step.duration_s
        return Gauss(gauss.mean, gauss.covariance + np.diag(walk))
    if step.way_m == 0 and step.turn_rad == 0:
        return gauss
    mean, covariance = gauss.mean.copy(), gauss.covariance
    if not gauss.heading_known:
        # It went somewhere within a circle.
        mean[2] = math.remainder(mean[2] + step.turn_rad, 2 * math.pi)
        return Gauss(mean, covariance + np.diag([step.way_m**2, step.way_m**2, 0.0]))
    cos, sin = math.cos(mean[2] + step.turn_rad / 2), math.sin(mean[2] + step.turn_rad / 2)
    (dx, dy), by_pose = step.seen_from(mean[2]), by_pose_before(step, mean[2])
    mean += dx, dy, step.turn_rad
    mean[2] = math.remainder(mean[2], 2 * math.pi)
    slip = config.slip_share * _SLIP_VARIANCE * step.way_m**2
    along = config.wheel_m**2 * step.way_m + (_DRIFT_M * config.scale**2) * step.way_m + slip
    turn = (
        config.turn_rad**2 * (abs(step.turn_rad) + 0.1 * step.way_m) + _DRIFT_S * config.gyro_rad_s**2 * step.duration_s
    )
    by_noise = np.array([[cos, -dy / 2], [sin, dx / 2], [0.0, 1.0]])
    covariance = by_pose @ covariance @ by_pose.T + by_noise @ np.diag([along, turn]) @ by_noise.T
    return Gauss(mean, (covariance + covariance.T) / 2)


def by_pose_before(step: Step, heading: float) -> FloatArray:
    """(3, 3) derivative of where a step leads by the pose before it, whose heading that was."""
    dx, dy = step.seen_from(heading)
    return np.array([[1.0, 0.0, -dy], [0.0, 1.0, dx], [0.0, 0.0, 1.0]])


def _begun(sighting: Sighting, trail: Trail) -> Gauss:
    """At a sighting alone."""
    xy, heading, variance = sighting.xy[0], sighting.heading[0], sighting.heading_sigma_rad**2
    if not math.isfinite(heading):
        told = trail.heading(xy)
        heading, variance = (0.0, _ANY_HEADING_RAD2) if told is None else (told[0], told[1] ** 2)
    position = sighting.sigma_m**2
    return Gauss(np.array([*xy, heading]), np.diag([position, position, variance]))


def _with_told_heading(gauss: Gauss, trail: Trail) -> Gauss:
    """With the heading that the way tells, where there is none."""
    told = None if gauss.heading_known else trail.heading(gauss.mean[:2])
    if told is None:
        return gauss
    covariance = gauss.covariance.copy()
    covariance[2], covariance[:, 2] = 0.0, 0.0
    covariance[2, 2] = told[1] ** 2
    return Gauss(np.array([*gauss.mean[:2], told[0]]), covariance)


def _corrected(gauss: Gauss, one: Weighted, gate: float) -> Gauss | None:
    """By the nearest of a sighting's places, ``None`` where that is outside the gate.

    A sighting that is only in part news counts as one that is so much less exact.
    """
    sighting = one.sighting
    share = max(one.sharpness * one.decision, 1e-6)
    nearest = int(np.argmin(((sighting.xy - gauss.mean[:2]) ** 2).sum(axis=1)))
    offset = sighting.xy[nearest] - gauss.mean[:2]
    innovation = gauss.covariance[:2, :2] + np.eye(2) * sighting.sigma_m**2
    if float(offset @ np.linalg.solve(innovation, offset)) > gate:
        return None
    rows, noise = np.eye(3)[:2], np.full(2, sighting.sigma_m**2 / share)
    heading = float(sighting.heading[nearest])
    if math.isfinite(heading):
        turned = math.remainder(heading - gauss.mean[2], 2 * math.pi)
        if gauss.heading_known and turned**2 > gate * (gauss.covariance[2, 2] + sighting.heading_sigma_rad**2):
            return None
        rows, offset = np.eye(3), np.append(offset, turned)
        noise = np.append(noise, sighting.heading_sigma_rad**2 / share)
    spread = rows @ gauss.covariance @ rows.T + np.diag(noise)
    gain = np.linalg.solve(spread, rows @ gauss.covariance).T
    mean = gauss.mean + gain @ offset
    mean[2] = math.remainder(mean[2], 2 * math.pi)
    # Joseph's form keeps the covariance positive definite.
    kept = np.eye(3) - gain @ rows
    covariance = kept @ gauss.covariance @ kept.T + gain @ np.diag(noise) @ gain.T
    return Gauss(mean, (covariance + covariance.T) / 2)
