"""The whole image and the landmarks in it, each with an estimate of its own: what is made of both.

The whole image sees everything, moved things and another season too; landmarks are few, and known. Both come from the
same picture, so they are not taken to be independent: their errors are correlated, one that is twice as unsure as the
other adds nothing, and what both agree on is no more certain than the surer one alone.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from andante.angles import wrapped
from andante.data import Estimate, FloatArray, Hypothesis, Status
from andante.mapping.uncertainty import RADIUS_OF_90_PERCENT

_CORRELATION = 0.5
"""Of the errors of both, as wide a guess as there is: none and all would be equally wrong."""
_FAR_APART = 9.21
"""Squared distance in deviations that 99 % of honest pairs do not reach (chi square of two degrees of freedom)."""


def joined(whole: Estimate, landmarks: Estimate) -> Estimate:
    """One estimate from the two; whichever has no pose changes nothing but the reason.

    An image that looks like no mapped place stays off the map, whatever a detector sees in it, unless the landmarks are
    sure of the pose. Where the two disagree, the surer one counts, degraded, and the other stays a hypothesis.
    """
    if not landmarks.status.has_pose:
        return replace(whole, reason=f"{whole.reason}; {landmarks.reason}")
    if not whole.status.has_pose:
        if whole.status is Status.OFF_MAP and landmarks.status is not Status.OK:
            return replace(whole, reason=f"{whole.reason}; landmarks say something else, but are not sure")
        reason = f"{landmarks.reason}; the whole image: {whole.reason}"
        return replace(landmarks, likeness=whole.likeness, reason=reason)
    (xy, covariance), (other, spread) = _position(whole), _position(landmarks)
    apart = other - xy
    distance = float(apart @ np.linalg.solve(covariance + spread, apart))
    surer, less = (whole, landmarks) if np.trace(covariance) <= np.trace(spread) else (landmarks, whole)
    if distance > _FAR_APART:
        reason = f"the whole image and the landmarks disagree by {np.linalg.norm(apart):.2g} m: {surer.reason}"
        return replace(
            surer,
            status=Status.DEGRADED,
            reason=reason,
            likeness=whole.likeness,
            hypotheses=_shared(surer.hypotheses, less.hypotheses),
        )
    share = _share_of_less(covariance, spread) if surer is whole else 1.0 - _share_of_less(spread, covariance)
    mean, fused = xy + share * apart, _position(surer)[1]
    heading, variance = _heading(whole, landmarks)
    both = np.full((3, 3), np.nan)
    both[:2, :2] = fused
    if heading is not None:
        both[2] = both[:, 2] = 0.0
        both[2, 2] = variance
    x, y = mean.tolist()
    return Estimate(
        Status.OK if Status.OK in (whole.status, landmarks.status) else Status.DEGRADED,
        f"{whole.reason}; {landmarks.reason}",
        x,
        y,
        heading,
        both,
        float(RADIUS_OF_90_PERCENT * np.sqrt(np.trace(fused) / 2)),
        likeness=whole.likeness,
        hypotheses=_shared((Hypothesis(x, y, 1.0, heading),), _shared(whole.hypotheses, landmarks.hypotheses)),
    )


def _share_of_less(surer: FloatArray, less: FloatArray) -> float:
    """Weight of the less sure of two with these covariances (2, 2): that of least variance for correlated errors.

    It is not below zero; from 1 / correlation times the deviation of the surer one on, it brings nothing.
    """
    ratio = float(np.sqrt(np.trace(less) / np.trace(surer)))
    return max(0.0, (1.0 - _CORRELATION * ratio) / (1.0 + ratio**2 - 2.0 * _CORRELATION * ratio))


def _position(estimate: Estimate) -> tuple[FloatArray, FloatArray]:
    """Mean (2,) and covariance (2, 2) of an estimate with a pose."""
    covariance = estimate.covariance
    assert covariance is not None
    return np.array([estimate.x_m, estimate.y_m], np.float64), np.asarray(covariance[:2, :2], np.float64)


def _heading(whole: Estimate, landmarks: Estimate) -> tuple[float | None, float]:
    """The mean of both headings, weighted as positions are, and the variance of the surer one."""
    known = [
        (float(one.covariance[2, 2]), one.heading_rad)
        for one in (whole, landmarks)
        if one.heading_rad is not None and one.covariance is not None and np.isfinite(one.covariance[2, 2])
    ]
    if not known:
        return None, np.nan
    (variance, surer), (other, less) = min(known), max(known)
    share = _share_of_less(np.array([[variance]]), np.array([[other]]))
    return wrapped(surer + share * wrapped(less - surer)), variance


def _shared(first: tuple[Hypothesis, ...], second: tuple[Hypothesis, ...]) -> tuple[Hypothesis, ...]:
    """Both, the best of the first in front; their weights sum to one."""
    halved = [replace(one, weight=one.weight / 2) for one in (*first[1:], *second)]
    head = tuple(replace(one, weight=one.weight / 2) for one in first[:1])
    return (*head, *sorted(halved, key=lambda one: -one.weight))
