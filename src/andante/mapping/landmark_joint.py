"""The whole image and the landmarks in it, each with an estimate of its own: what is made of both.

The whole image sees everything, moved things and another season too; it says where the robot is. Landmarks at known
places, seen where that pose expects them, refine it: directions do not change with the light, as the looks of a
landmark do. Where the whole image does not know the place, what landmarks look like says it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from andante.data import Estimate, FloatArray, Hypothesis, Status
from andante.mapping.landmark_geometry import Refined, refined
from andante.mapping.landmark_sights import Sight
from andante.mapping.uncertainty import RADIUS_OF_90_PERCENT

_FITS = 3.0
"""Deviations from which on a landmark is not where the pose expects it."""
_FAR_APART = 9.21
"""Squared distance in deviations that 99 % of honest pairs do not reach (chi square of two degrees of freedom)."""


def joined(whole: Estimate, landmarks: Estimate, sights: Sequence[Sight]) -> Estimate:
    """One estimate from that of the whole image, that of the ``landmarks``, and what is seen of these.

    An image that looks like no mapped place stays off the map, whatever a detector sees in it, unless the landmarks are
    sure of the pose. Where no landmark is where the whole image expects it, the pose is degraded, and the landmarks
    have the word only if the whole image was not sure. Of views that are like no mapped one, boxes that are elsewhere
    are taken for wrong, and say nothing.
    """
    if not whole.status.has_pose:
        return _without_whole(whole, landmarks)
    placed = [(one.box, one.model.geometry) for one in sights if one.model.geometry is not None]
    both = replace(whole, hypotheses=_shared(whole.hypotheses, landmarks.hypotheses))
    if not placed:
        return replace(both, reason=f"{whole.reason}; {landmarks.reason}")
    pose, covariance = _pose(whole)
    found = refined(pose, covariance, *zip(*placed, strict=True))
    if (found.fit <= _FITS).any():
        return _refined(whole, landmarks, found)
    if not any(one.familiar for one in sights if one.model.geometry is not None):
        return replace(both, reason=f"{whole.reason}; {landmarks.reason}")
    if whole.status is not Status.OK and landmarks.status is Status.OK:
        reason = f"no landmark is where the whole image expects it, which is not sure: {landmarks.reason}"
        hypotheses = _shared(landmarks.hypotheses, whole.hypotheses)
        return replace(landmarks, status=Status.DEGRADED, reason=reason, likeness=whole.likeness, hypotheses=hypotheses)
    reason = f"{whole.reason}; no landmark is where that expects it"
    return replace(both, status=Status.DEGRADED, reason=reason)


def _without_whole(whole: Estimate, landmarks: Estimate) -> Estimate:
    """Landmarks alone, if they may."""
    if not landmarks.status.has_pose:
        return replace(whole, reason=f"{whole.reason}; {landmarks.reason}")
    if whole.status is Status.OFF_MAP and landmarks.status is not Status.OK:
        return replace(whole, reason=f"{whole.reason}; landmarks say something else, but are not sure")
    return replace(landmarks, likeness=whole.likeness, reason=f"{landmarks.reason}; the whole image: {whole.reason}")


def _refined(whole: Estimate, landmarks: Estimate, found: Refined) -> Estimate:
    """The pose of the whole image, moved to where landmarks are seen where they should be."""
    x, y, heading = found.pose.tolist()
    position = Hypothesis(x, y, 1.0, heading)
    agreed = whole.status is Status.OK or (landmarks.status is Status.OK and _agree(whole, landmarks))
    return Estimate(
        Status.OK if agreed else Status.DEGRADED,
        f"{whole.reason}; {landmarks.reason}",
        x,
        y,
        heading,
        found.covariance,
        float(RADIUS_OF_90_PERCENT * np.sqrt(np.trace(found.covariance[:2, :2]) / 2)),
        likeness=whole.likeness,
        hypotheses=_shared((position,), _shared(whole.hypotheses, landmarks.hypotheses)),
    )


def _agree(whole: Estimate, landmarks: Estimate) -> bool:
    """Whether two estimates with poses may be of one place."""
    (pose, covariance), (other, spread) = _pose(whole), _pose(landmarks)
    apart = (other - pose)[:2]
    return float(apart @ np.linalg.solve((covariance + spread)[:2, :2], apart)) <= _FAR_APART


def _pose(estimate: Estimate) -> tuple[FloatArray, FloatArray]:
    """Mean (3,) and covariance (3, 3) of an estimate with a pose, NaN for an unknown heading."""
    assert estimate.covariance is not None
    heading = np.nan if estimate.heading_rad is None else estimate.heading_rad
    return np.array([estimate.x_m, estimate.y_m, heading], np.float64), np.array(estimate.covariance, np.float64)


def _shared(first: tuple[Hypothesis, ...], second: tuple[Hypothesis, ...]) -> tuple[Hypothesis, ...]:
    """Both, the best of the first in front; their weights sum to one."""
    if not first or not second:
        return first or second
    halved = [replace(one, weight=one.weight / 2) for one in (*first[1:], *second)]
    head = tuple(replace(one, weight=one.weight / 2) for one in first[:1])
    return (*head, *sorted(halved, key=lambda one: -one.weight))
