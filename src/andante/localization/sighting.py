"""Images and fixes in one form: a few places, how sharp they are, and how likely they are all wrong."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from andante.data import Estimate, Fix, FloatArray, Status
from andante.localization.config import SightingConfig

RADIUS_PER_SIGMA = 2.146
"""The 90 % radius of a Gaussian in the plane whose deviation along each axis is one."""
_FIX_FLOOR = 0.02
_WIDE = 0.03
_FIX_MIN_SIGMA_M = 0.02


@dataclass(frozen=True, eq=False)
class Sighting:
    """One measurement as a mixture.

    ``xy`` (m, 2), ``weight`` (m,) summing to one, ``heading`` (m,) NaN where unknown, ``sigma_m`` and
    ``heading_sigma_rad`` of all of them; ``floor`` is the share of the likelihood that is left far from all places.
    ``trusted`` says whether the first one was given as a pose; only that may confirm or contradict a prediction.
    """

    xy: FloatArray
    weight: FloatArray
    heading: FloatArray
    sigma_m: float
    heading_sigma_rad: float
    floor: float
    trusted: bool
    status: Status
    from_fix: bool = False

    def likelihood(self, pose: FloatArray, sharpness: float = 1.0, floor: float | None = None) -> FloatArray:
        """(n, 3) x, y, heading -> (n,) from ``floor`` to one; ``sharpness`` below one widens the bells."""
        floor = self.floor if floor is None else floor
        squared = ((pose[:, None, :2] - self.xy) ** 2).sum(axis=2) / self.sigma_m**2
        known = np.isfinite(self.heading)
        if known.any():
            turned = np.where(known, pose[:, 2:] - self.heading, 0.0)
            squared += (2 - 2 * np.cos(turned)) / self.heading_sigma_rad**2
        squared *= sharpness
        # A second, wider bell leads particles that are near by towards the place.
        bells = (1 - _WIDE) * np.exp(-0.5 * squared) + _WIDE * np.exp(-0.5 * squared / 16)
        likelihood: FloatArray = floor + (1 - floor) * np.minimum(bells @ self.weight / self.weight.max(), 1)
        return likelihood

    def draw(self, count: int, rng: np.random.Generator) -> tuple[FloatArray, FloatArray]:
        """``count`` places (count, 2) with headings (count,), NaN where unknown."""
        chosen = rng.choice(len(self.weight), count, p=self.weight)
        xy = self.xy[chosen] + rng.normal(0.0, self.sigma_m, (count, 2))
        return xy, self.heading[chosen] + rng.normal(0.0, self.heading_sigma_rad, count)


def sighting_of_image(estimate: Estimate, config: SightingConfig, *, faulty: bool = False) -> Sighting | None:
    """What an image says, believed little where it is faulty; ``None`` where it names no place."""
    usable = [one for one in estimate.hypotheses if one.weight > 0 and math.isfinite(one.x_m + one.y_m + one.weight)]
    if not usable:
        return None
    xy = np.array([[one.x_m, one.y_m] for one in usable])
    weight = np.array([one.weight for one in usable])
    heading = np.array([math.nan if one.heading_rad is None else one.heading_rad for one in usable])
    first = estimate.hypotheses[0]
    trusted = estimate.status.has_pose and estimate.x_m is not None and usable[0] is first
    if trusted and estimate.heading_rad is not None and math.isfinite(estimate.heading_rad):
        heading[0] = estimate.heading_rad
    return Sighting(
        xy=xy,
        weight=weight / weight.sum(),
        heading=heading,
        sigma_m=_sigma(estimate, config) if trusted else config.blind_sigma_m,
        heading_sigma_rad=_heading_sigma(estimate, config),
        floor=max(_floor(estimate.status, config), config.floor_lost if faulty else 0.0),
        trusted=trusted,
        status=estimate.status,
    )


def sighting_of_fix(fix: Fix | None) -> Sighting | None:
    """A position from elsewhere; ``None`` where it is not finite or its deviation not positive."""
    if fix is None or not math.isfinite(fix.x_m + fix.y_m + fix.sigma_m) or fix.sigma_m <= 0:
        return None
    return Sighting(
        xy=np.array([[fix.x_m, fix.y_m]]),
        weight=np.ones(1),
        heading=np.full(1, math.nan),
        sigma_m=max(fix.sigma_m, _FIX_MIN_SIGMA_M),
        heading_sigma_rad=1.0,
        floor=_FIX_FLOOR,
        trusted=True,
        status=Status.OK,
        from_fix=True,
    )


def _sigma(estimate: Estimate, config: SightingConfig) -> float:
    radius = estimate.radius_m
    if radius is None or not math.isfinite(radius):
        return config.blind_sigma_m
    return min(max(radius / RADIUS_PER_SIGMA, config.min_sigma_m), config.max_sigma_m)


def _heading_sigma(estimate: Estimate, config: SightingConfig) -> float:
    variance = math.nan if estimate.covariance is None else float(estimate.covariance[2, 2])
    return math.sqrt(variance) if math.isfinite(variance) and variance > 0 else config.heading_sigma_rad


def _floor(status: Status, config: SightingConfig) -> float:
    floors = {
        Status.OK: config.floor_ok,
        Status.DEGRADED: config.floor_degraded,
        Status.LOST: config.floor_lost,
        Status.OFF_MAP: config.floor_off_map,
    }
    return floors[status]
