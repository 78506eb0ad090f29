"""What a tracker remembers from one frame to the next."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from andante.data import Estimate, FloatArray
from andante.localization.faults import Pulse
from andante.localization.filters import Gauss
from andante.localization.judge import Belief, Judge, Opinion
from andante.localization.motion import Odometer, Step
from andante.localization.sighting import Sighting
from andante.localization.trail import Trail
from andante.localization.witness import Novelty

_FAST, _SLOW, _LEAST_SLOW = 0.3, 0.03, 0.5
_RADIUS_GAIN, _RADIUS_SHARE = 0.1, 0.7
_STRAIN_GAIN, _STRAIN_RADII = 0.3, 1.5


@dataclass(frozen=True, eq=False)
class Memory:
    """Everything besides the filter; replaced as a whole with every frame, and of one size however long a drive is.

    ``good`` and ``last`` (k,) are slow features of the last image that did not jump and of the last one. ``fast`` and
    ``slow`` are running means of how often images agree with the prediction (augmented MCL, theory 8),
    ``image_radius_m`` is that of the radii they come with, ``strain_m`` that of how far they are from the prediction.
    """

    odometer: Odometer = field(default_factory=Odometer)
    trail: Trail = field(default_factory=Trail.empty)
    pulse: Pulse = field(default_factory=Pulse)
    image_news: Novelty = field(default_factory=Novelty)
    fix_news: Novelty = field(default_factory=Novelty)
    judge: Judge = field(default_factory=Judge)
    fast: float = 1.0
    slow: float = 1.0
    image_radius_m: float = 0.0
    strain_m: float = 0.0
    good: FloatArray | None = None
    last: FloatArray | None = None

    @property
    def doubt(self) -> float:
        """From 0 to 1: how much less often images agree of late than they used to."""
        return max(0.0, 1.0 - self.fast / max(self.slow, _LEAST_SLOW))

    def news(self, sighting: Sighting) -> Novelty:
        """What is new of a sighting of its kind."""
        return self.fix_news if sighting.from_fix else self.image_news

    def moved(self, step: Step, walk_m: float) -> Memory:
        """After a step; ``walk_m`` is its length where odometry does not know it."""
        return replace(
            self,
            trail=self.trail.moved(step),
            pulse=self.pulse.moved(step),
            image_news=self.image_news.moved(step, walk_m),
            fix_news=self.fix_news.moved(step, walk_m),
            judge=self.judge.moved(step, walk_m),
        )

    def with_sighting(self, sighting: Sighting, opinion: Opinion, predicted: Gauss | None) -> Memory:
        """After a sighting with an opinion on what was predicted."""
        known = Novelty(0.0, 0.0)
        told = replace(self, fix_news=known) if sighting.from_fix else replace(self, image_news=known)
        if sighting.trusted:
            place = sighting.xy[0].tolist()
            told = replace(told, trail=told.trail.with_place(*place, agreed=opinion == "agrees"))
        if opinion == "agrees" and predicted is not None:
            strain = float(np.hypot(*(sighting.xy[0] - predicted.mean[:2])))
            told = replace(told, strain_m=_mean(told.strain_m, strain, _STRAIN_GAIN))
        if opinion == "silent":
            return told
        agrees = float(opinion == "agrees")
        return replace(told, fast=_mean(told.fast, agrees, _FAST), slow=_mean(told.slow, agrees, _SLOW))

    def with_radius(self, estimate: Estimate) -> Memory:
        """After an image, whose radius goes into the running mean where it names a pose."""
        radius, known = estimate.radius_m, self.image_radius_m
        if radius is None or not math.isfinite(radius):
            return self
        return replace(self, image_radius_m=radius if known == 0 else _mean(known, radius, _RADIUS_GAIN))

    def informed(self, belief: Belief | None) -> Belief | None:
        """A filter's belief in the light of the last images.

        They err alike for long, so that a filter is hardly more exact than they are, whatever its spread says. Nor is
        it where images keep pulling it away from where odometry leads, as when wheels slip.
        """
        if belief is None:
            return None
        radius = max(belief.radius_m, _RADIUS_SHARE * self.image_radius_m, _STRAIN_RADII * self.strain_m)
        return replace(
            belief,
            radius_m=radius,
            image_radius_m=self.image_radius_m,
            misfit_m=self.trail.misfit_m,
            agreement=self.fast,
        )


def _mean(mean: float, value: float, gain: float) -> float:
    """A running mean."""
    return mean + gain * (value - mean)
