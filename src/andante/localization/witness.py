"""How much of a sighting is news, and whether it agrees with what was expected."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.data import FloatArray
from andante.localization.config import JudgeConfig, SightingConfig
from andante.localization.filters import Gauss, Weighted
from andante.localization.judge import Opinion
from andante.localization.motion import Step
from andante.localization.sighting import Sighting

_FIX_CORRELATION_M = 0.1
_ALSO_NAMED = 0.2
_WIDEST_M2 = 1.0


@dataclass(frozen=True, slots=True)
class Novelty:
    """Way and turn since the last sighting of a kind; infinite before the first.

    Sightings that are taken close to each other err alike, and a hundred from one place are not better than one. So a
    likelihood is raised to a power below one, that which makes the sum over the way what it would be for one sighting
    every correlation length.
    """

    way_m: float = math.inf
    turn_rad: float = math.inf

    def moved(self, step: Step, walk_m: float) -> Novelty:
        """After a step; ``walk_m`` is its length where odometry does not know it."""
        if not step.known:
            return Novelty(self.way_m + walk_m, self.turn_rad)
        return Novelty(self.way_m + step.way_m, self.turn_rad + abs(step.turn_rad))

    def weighted(
        self, sighting: Sighting, predicted: Gauss | None, config: SightingConfig, *, contradicts: bool
    ) -> Weighted:
        """The sighting with what is new of it.

        It is the more news the less exact the prediction is, wherever it was made. And the wider the prediction, the
        smaller is the chance that a wrong sighting falls into it, so the lower is the floor.
        """
        correlation = _FIX_CORRELATION_M if sighting.from_fix else config.correlation_m
        fresh = -math.expm1(-(self.way_m / correlation + self.turn_rad / config.correlation_rad))
        variance = math.inf if predicted is None else predicted.variance_m2
        exact = max(fresh, 1.0 - sighting.sigma_m**2 / max(variance, 1e-12))
        if predicted is not None and math.isfinite(sighting.heading[0]):
            exact = max(exact, 1.0 - sighting.heading_sigma_rad**2 / max(predicted.covariance[2, 2], 1e-12))
        decision = max(exact, -math.expm1(-self.way_m / config.decision_m))
        if decision <= 0:
            return Weighted(sighting, 1.0, 0.0, sighting.floor, contradicts)
        narrow = sighting.sigma_m**2 / exact if exact > 0 else math.inf
        share = 1.0 if math.isinf(narrow) else narrow / (narrow + min(variance, _WIDEST_M2))
        return Weighted(sighting, exact / decision, decision, sighting.floor * share, contradicts)


def opinion_of(sighting: Sighting, predicted: Gauss | None, config: JudgeConfig) -> tuple[Opinion, str]:
    """Whether a sighting agrees with the prediction, and in words why not.

    Only what was given as a pose may contradict, and not where the prediction lies among its other places.
    """
    if predicted is None:
        return ("agrees" if sighting.trusted else "silent"), "the first place that is named"
    if not sighting.trusted:
        return "silent", "the image names no place"
    inside = _inside(sighting, predicted, config)
    apart = float(np.hypot(*(sighting.xy[0] - predicted.mean[:2])))
    if inside[0]:
        return "agrees", ""
    if (inside & (sighting.weight >= _ALSO_NAMED)).any():
        return "silent", f"the image may also be from {apart:.1f} m away"
    what = "the fix" if sighting.from_fix else "the image"
    return "contradicts", f"{what} is from {apart:.1f} m away from where odometry leads"


def _inside(sighting: Sighting, predicted: Gauss, config: JudgeConfig) -> NDArray[np.bool_]:
    """(m,) which places are inside the gate around the prediction."""
    spread = predicted.covariance[:2, :2] + np.eye(2) * (sighting.sigma_m**2 + config.slack_m**2)
    offset: FloatArray = sighting.xy - predicted.mean[:2]
    inside = (offset * np.linalg.solve(spread, offset.T).T).sum(axis=1) <= config.gate
    if predicted.heading_known:
        turned = wrapped(sighting.heading - predicted.mean[2])
        variance = predicted.covariance[2, 2] + sighting.heading_sigma_rad**2 + config.slack_rad**2
        inside &= ~(turned**2 > config.gate * variance)  # an unknown heading agrees with any
    return np.asarray(inside, dtype=np.bool_)
