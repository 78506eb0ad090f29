"""What may be promised of images that were taken away from all mapped places."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from andante.angles import wrapped
from andante.data import Estimate, FloatArray, Hypothesis, Status
from andante.mapping.compass import Compass
from andante.mapping.scenery import Drives, Scenery, Spot
from andante.mapping.uncertainty import conformal_factor, covariance_of

_TESTS = 30
"""Frames of each half that are looked for in what the other half shows."""
_BLOCK_RADII = 6.0
_FEWEST = 8
_UNMISTAKABLE = 1.4
"""How much more alike than its mirror image an image has to be; of images from other gardens one in 100 is."""
_AS_GOOD = 0.87
"""Halfway off the mapped path an imagined view is as much alike as this share of a mapped one; at least."""
_SURE, _SLIM = 16.0, 0.03
"""How fast the odds grow with how alike a view is, and a chance that does not count."""


@dataclass(frozen=True)
class ViewBounds:
    """What held-out frames allow to promise of imagined views (theory 9).

    An image was taken where a view is more alike than ``alike_above``, which one mirrored image in twenty reaches, and
    much more than its own mirror image, which is one of a place much like it that does not exist. ``radius_factor`` in
    metres and ``heading_factor`` in radians, divided by how alike the view is, held the truth for the configured share
    of frames. On the mapped path hardly any view is more alike than ``as_good`` times the mapped one.
    """

    alike_above: float
    radius_factor: float
    heading_factor: float
    as_good: float = _AS_GOOD

    def found(self, spot: Spot) -> bool:
        """Whether an image was taken there."""
        return spot.alike > max(self.alike_above, _UNMISTAKABLE * spot.alike_mirrored)

    def share(self, alike: float, peak: float) -> float:
        """How much of the evidence speaks for an imagined view, against a mapped one that is alike by ``peak``."""
        odds = max(alike, 1e-6) / max(self.as_good * peak, 1e-6)
        return float(1 / (1 + odds**-_SURE))

    def least_alike(self, on_path: Estimate, peak: float) -> float:
        """How alike a view has to be to change anything."""
        if not on_path.status.has_pose:
            return self.alike_above
        least: float = self.as_good * peak * (_SLIM / (1 - _SLIM)) ** (1 / _SURE)
        return max(self.alike_above, least)

    def radius_m(self, spot: Spot) -> float:
        """Calibrated radius."""
        return self.radius_factor / spot.alike

    def off_rad(self, spot: Spot) -> float:
        """As much as the heading may be off."""
        return self.heading_factor / spot.alike


def weighed(on_path: Estimate, peak: float, spot: Spot, bounds: ViewBounds) -> Estimate:
    """An imagined view against the mapped ones, of which the best is alike by ``peak``: the better one is believed."""
    if not bounds.found(spot):
        return on_path
    likeness = max(on_path.likeness or 0.0, 1 - spot.alike_mirrored / spot.alike)
    share, radius = bounds.share(spot.alike, peak), bounds.radius_m(spot)
    view = Hypothesis(spot.x_m, spot.y_m, share, spot.heading_rad)
    rivals = [replace(one, weight=one.weight * (1 - share)) for one in on_path.hypotheses]
    if on_path.x_m is not None and on_path.y_m is not None and on_path.radius_m is not None:
        gap = float(np.hypot(on_path.x_m - spot.x_m, on_path.y_m - spot.y_m))
        if gap <= on_path.radius_m:
            return on_path  # both mean the same place, and mapped ones tell it more finely
        # The second moment of the two together: as far as the other one may be right, the error is the way to it.
        if share < 0.5:
            return replace(_widened(on_path, gap * np.sqrt(share)), hypotheses=(*rivals, view), likeness=likeness)
        radius = float(np.hypot(radius, gap * np.sqrt(1 - share)))
    reason = (
        f"between mapped places: the view imagined from there is alike by {spot.alike:.2f}, "
        f"{spot.alike / spot.alike_mirrored:.1f} times as much as it is to its mirror image"
    )
    covariance = covariance_of(np.eye(2), radius, bounds.off_rad(spot))
    return Estimate(
        Status.OK,
        reason,
        spot.x_m,
        spot.y_m,
        spot.heading_rad,
        covariance,
        radius,
        likeness=likeness,
        hypotheses=(view, *rivals),
    )


def _widened(estimate: Estimate, by_m: float) -> Estimate:
    """The same with an error of so much more, and no other shape of its covariance."""
    if estimate.radius_m is None or estimate.covariance is None:
        return estimate
    radius, covariance = float(np.hypot(estimate.radius_m, by_m)), estimate.covariance.copy()
    covariance[:2, :2] *= (radius / estimate.radius_m) ** 2
    return replace(estimate, radius_m=radius, covariance=covariance)


def try_views(drives: Drives, *, coverage: float, seed: int = 0) -> ViewBounds | None:
    """Find frames of half the sessions, or of every second stretch of one, in what the others show, and vice versa.

    ``None`` where too few are found to promise anything.
    """
    tried, ratios = list[tuple[Spot, float, float]](), list[float]()
    for train, test in _halves(drives):
        scenery = Scenery.fit(train, seed=seed)
        if scenery is None:
            return None
        for (x, y, heading), signature in zip(test.poses.tolist(), test.phase.rows(), strict=True):
            spot = scenery.search(signature)
            assert spot is not None  # as nothing is too little alike
            turn = abs(wrapped(spot.heading_rad - heading))
            tried.append((spot, float(np.hypot(spot.x_m - x, spot.y_m - y)), turn))
            ratios.append(spot.alike)
        ratios[-len(test) :] = (np.array(ratios[-len(test) :]) / _mapped_peaks(train, test)).tolist()
    if not tried:
        return None
    nothing_there = ViewBounds(float(np.quantile([spot.alike_mirrored for spot, _, _ in tried], 0.95)), 0.0, 0.0)
    right = [(spot.alike, error, turn) for spot, error, turn in tried if nothing_there.found(spot)]
    if len(right) < _FEWEST:
        return None
    alike, error, turn = np.array(right).T
    radius, off = (conformal_factor(values, 1 / alike, coverage) for values in (error, turn))
    # Between blocks of a single drive there is no mapped path that the others could be compared with.
    several = len(np.unique(drives.session)) > 1
    as_good = max(_AS_GOOD, float(np.quantile(ratios, 0.95))) if several else _AS_GOOD
    return ViewBounds(nothing_there.alike_above, radius, off, as_good)


def _mapped_peaks(train: Drives, test: Drives) -> FloatArray:
    """How alike frames are to the mapped places where they were taken (n,)."""
    xy, heading = train.poses[:, :2], train.poses[:, 2]
    compass = Compass.fit(train.encoder, train.phase, xy, heading, train.radius_m)
    assert compass is not None  # of the frames of a half all headings are known
    return np.maximum(compass.bearings(test.phase.rows(), test.poses[:, :2]).peak, 1e-3)


def _halves(drives: Drives) -> Iterator[tuple[Drives, Drives]]:
    """Frames to see things from, and some to look for."""
    sessions, number = np.unique(drives.session, return_inverse=True)
    half = number % 2
    if len(sessions) == 1:
        steps = np.diff(drives.poses[:, :2], axis=0, prepend=drives.poses[:1, :2])
        travelled = np.cumsum(np.linalg.norm(steps, axis=1))
        half = (travelled // (_BLOCK_RADII * drives.radius_m)).astype(np.int64) % 2
    known = np.isfinite(drives.poses).all(axis=1)
    for one in (0, 1):
        train, test = np.flatnonzero((half != one) & known), np.flatnonzero((half == one) & known)
        if len(train) and len(test):
            some = test[np.linspace(0, len(test) - 1, min(len(test), _TESTS)).astype(np.intp)]
            yield drives.subset(train), drives.subset(some)
