"""The ways to follow a ride that experiments compare: every image by itself, and what trackers make of them."""

from __future__ import annotations

from collections.abc import Callable

from andante.data import Estimate, Status
from andante.evaluation.experiments.rides import Ride, followed
from andante.localization import TrackerKind, make_tracker
from andante.mapping import SlowMap

Follow = Callable[[SlowMap, Ride, int], list[Estimate]]
"""A map, what was sensed and a seed -> an estimate for every frame."""

SINGLE, KALMAN, PARTICLES, SMOOTHED = "single images", "kalman", "particles", "particles, smoothed"


def single_images(slowmap: SlowMap, ride: Ride, seed: int) -> list[Estimate]:
    """Every image by itself."""
    return [Estimate(Status.LOST, "no picture") if seen is None else seen.estimate for seen in ride.evidence]


def tracked_by(kind: TrackerKind) -> Follow:
    """A tracker that begins without knowing where it is."""

    def follow(slowmap: SlowMap, ride: Ride, seed: int) -> list[Estimate]:
        return followed(make_tracker(slowmap, kind, seed=seed), ride)

    return follow


TRACKERS: dict[str, Follow] = {KALMAN: tracked_by("kalman"), PARTICLES: tracked_by("particles")}
"""The filters alone."""
