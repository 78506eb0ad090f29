"""What may be promised of images that were taken away from all mapped places."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from andante.mapping.scenery import Drives, Scenery, Spot, mirrored

_TESTS = 30
"""Frames of each half that are looked for in what the other half shows."""
_BLOCK_RADII = 6.0
_FEWEST = 8
_SURE = 30.0
"""How fast doubt between a mapped and an imagined view vanishes as one of them is more alike."""


@dataclass(frozen=True)
class ViewBounds:
    """What held-out frames allow to promise of imagined views (theory 9).

    A view shows the place of an image where it is more alike than ``found_above``, which no mirrored image reached: a
    garden that does not exist, but is much like this. ``radius_factor`` in metres and ``heading_factor`` in radians,
    divided by how alike the view is, held the truth for the configured share of frames.
    """

    found_above: float
    radius_factor: float
    heading_factor: float

    def found(self, spot: Spot) -> bool:
        """Whether the spot is where the image was taken."""
        return spot.alike > self.found_above

    def radius_m(self, spot: Spot) -> float:
        """Calibrated radius."""
        return self.radius_factor / max(spot.alike, self.found_above)

    def heading_rad(self, spot: Spot) -> float:
        """As much as the heading may be off."""
        return self.heading_factor / max(spot.alike, self.found_above)


def share_of_view(alike: float, peak: float) -> float:
    """How much of the evidence speaks for an imagined view, against a mapped one that is alike by ``peak``."""
    return float(1 / (1 + np.exp(-_SURE * (alike - peak))))


def try_views(drives: Drives, *, coverage: float, seed: int = 0) -> ViewBounds | None:
    """Find frames of half the sessions, or of every second stretch of one, in what the others show, and vice versa.

    ``None`` where too few are found to promise anything.
    """
    alike, foreign, errors, turns = list[float](), list[float](), list[float](), list[float]()
    for train, test in _halves(drives):
        scenery = Scenery.fit(train, seed=seed)
        if scenery is None:
            return None
        signatures = test.phase.rows()
        for pose, own, other in zip(test.poses, signatures, mirrored(drives.encoder, signatures), strict=True):
            spot = scenery.search(own)
            alike.append(spot.alike)
            foreign.append(scenery.search(other).alike)
            errors.append(float(np.hypot(spot.x_m - pose[0], spot.y_m - pose[1])))
            turns.append(float(np.abs(np.mod(spot.heading_rad - pose[2] + np.pi, 2 * np.pi) - np.pi)))
    found = np.array(alike) > max(foreign, default=1.0)
    if found.sum() < _FEWEST:
        return None
    likely = np.array(alike)[found]
    radius, turn = (np.quantile(np.array(values)[found] * likely, coverage) for values in (errors, turns))
    return ViewBounds(max(foreign), float(radius), float(turn))


def _halves(drives: Drives) -> Iterator[tuple[Drives, Drives]]:
    """Frames to see things from, and some to look for."""
    sessions, number = np.unique(drives.session, return_inverse=True)
    half = number % 2
    if len(sessions) == 1:
        travelled = np.cumsum(
            np.linalg.norm(np.diff(drives.poses[:, :2], axis=0, prepend=drives.poses[:1, :2]), axis=1)
        )
        half = (travelled // (_BLOCK_RADII * drives.radius_m)).astype(np.int64) % 2
    known = np.isfinite(drives.poses).all(axis=1)
    for one in (0, 1):
        train, test = np.flatnonzero((half != one) & known), np.flatnonzero((half == one) & known)
        if len(train) and len(test):
            some = test[np.linspace(0, len(test) - 1, min(len(test), _TESTS)).astype(np.intp)]
            yield drives.subset(train), drives.subset(some)
