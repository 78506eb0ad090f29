"""The ways to follow a ride that experiments compare: every image by itself, and what trackers make of them."""

from __future__ import annotations

from collections.abc import Callable

from andante.data import Estimate, Status
from andante.evaluation.experiments.rides import Ride, followed
from andante.localization import ParticleTracker, TrackerKind, make_tracker, smooth
from andante.mapping import SlowMap

Follow = Callable[[SlowMap, Ride, int], list[Estimate]]
"""A map, what was sensed and a seed -> an estimate for every frame."""

SINGLE, KALMAN, PARTICLES, SMOOTHED = "single images", "kalman", "particles", "smoothed"


def single_images(slowmap: SlowMap, ride: Ride, seed: int) -> list[Estimate]:
    """Every image by itself."""
    return [Estimate(Status.LOST, "no picture") if seen is None else seen.estimate for seen in ride.evidence]


def tracked_by(kind: TrackerKind) -> Follow:
    """A tracker that begins without knowing where it is."""

    def follow(slowmap: SlowMap, ride: Ride, seed: int) -> list[Estimate]:
        return followed(make_tracker(slowmap, kind, seed=seed), ride)

    return follow


def smoothed(slowmap: SlowMap, ride: Ride, seed: int) -> list[Estimate]:
    """The particle filter, every pose corrected by the frames that follow it."""
    moments = ((seen, info, None) for seen, info in zip(ride.evidence, ride.infos, strict=True))
    return list(smooth(ParticleTracker(slowmap, seed=seed), moments))


TRACKERS: dict[str, Follow] = {KALMAN: tracked_by("kalman"), PARTICLES: tracked_by("particles")}
"""The filters alone."""
FOLLOWERS: dict[str, Follow] = {SINGLE: single_images, **TRACKERS, SMOOTHED: smoothed}
"""All ways."""
