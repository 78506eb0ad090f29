"""Fixed-lag smoothing, for use offline: each pose also from what came after it.

What a tracker says of each frame is a Gaussian; odometry says how one leads to the next. From the newest frame back to
the oldest in the window each is corrected by the one after it (Rauch, Tung, Striebel 1965). Where a later pose and
what an earlier one leads to contradict each other, the robot was found again or carried away, and nothing is passed
back; only over frames that had no pose, odometry leads back from the first that has one.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from andante.data import Estimate, Fix, FloatArray, FrameInfo, Status
from andante.errors import ConfigError
from andante.localization.config import MotionConfig
from andante.localization.evidence import Evidence
from andante.localization.filters import Gauss
from andante.localization.kalman_filter import by_pose_before, moved
from andante.localization.motion import Odometer, Step
from andante.localization.sighting import RADIUS_PER_SIGMA
from andante.localization.trackers import KalmanTracker, ParticleTracker

Moment = tuple[Evidence | None, FrameInfo, Fix | None]
"""What a tracker is told of one frame."""
_GATE = 16.27
"""99.9 % of three degrees of freedom."""
_FOUND_RADIUS_M = 1.5


@dataclass(frozen=True, eq=False)
class _Entry:
    """A frame's estimate, and the step that led to it from the frame before."""

    estimate: Estimate
    step: Step


class FixedLagSmoother:
    """Gives each estimate ``lag`` frames late.

    Costs ``lag`` small matrix products a frame and remembers no more than ``lag`` frames. Raises ``ConfigError`` for a
    lag below one.
    """

    def __init__(self, tracker: ParticleTracker | KalmanTracker, *, lag: int = 10) -> None:
        if lag < 1:
            raise ConfigError(f"a lag of {lag} frames smooths nothing; allowed is 1 and more")
        self._tracker, self._lag = tracker, lag
        self._motion = tracker.config.motion
        self._odometer = Odometer()
        self._window: deque[_Entry] = deque()

    def push(self, evidence: Evidence | None, info: FrameInfo, fix: Fix | None = None) -> Estimate | None:
        """One more frame -> the smoothed estimate of the frame ``lag`` before it, ``None`` while there is none.

        A frame that is old or repeated gives the tracker's current estimate a place of its own, unsmoothed in itself.
        """
        self._odometer, step = self._odometer.take(info, self._motion)
        self._window.append(_Entry(self._tracker.fuse(evidence, info, fix), step or Step()))
        return self._oldest() if len(self._window) > self._lag else None

    def flush(self) -> Iterator[Estimate]:
        """The estimates of the last frames, each from those that came after it."""
        while self._window:
            yield self._oldest()

    def _oldest(self) -> Estimate:
        smoothed = _smoothed(list(self._window), self._motion)
        self._window.popleft()
        return smoothed


def smooth(tracker: ParticleTracker | KalmanTracker, moments: Iterable[Moment], *, lag: int = 10) -> Iterator[Estimate]:
    """One estimate for each frame, in order, each from up to ``lag`` frames that came after it as well."""
    smoother = FixedLagSmoother(tracker, lag=lag)
    for moment in moments:
        estimate = smoother.push(*moment)
        if estimate is not None:
            yield estimate
    yield from smoother.flush()


def _smoothed(window: list[_Entry], motion: MotionConfig) -> Estimate:
    """The first of a window, from all of it."""
    later = _gauss(window[-1].estimate)
    for entry, after in zip(window[-2::-1], window[:0:-1], strict=True):
        own = _gauss(entry.estimate)
        if later is not None:
            later = _back(later, after.step, motion) if own is None else _corrected(own, later, after.step, motion)
        else:
            later = own
    return _told(window[0].estimate, later)


def _gauss(estimate: Estimate) -> Gauss | None:
    """An estimate as a Gaussian; ``None`` without a pose or a heading."""
    covariance = estimate.covariance
    if estimate.x_m is None or estimate.y_m is None or estimate.heading_rad is None or covariance is None:
        return None
    if not np.isfinite(covariance).all() or np.linalg.eigvalsh(covariance)[0] <= 0:
        return None
    return Gauss(np.array([estimate.x_m, estimate.y_m, estimate.heading_rad]), covariance)


def _corrected(own: Gauss, later: Gauss, step: Step, motion: MotionConfig) -> Gauss:
    """An estimate by the smoothed one of the frame after it; itself where the two contradict each other."""
    predicted = moved(own, step, motion)
    offset = _difference(later.mean, predicted.mean)
    apart = float(offset @ np.linalg.solve(predicted.covariance + later.covariance, offset))
    if apart > _GATE:
        return own
    leads = by_pose_before(step, own.mean[2]) if step.known else np.eye(3)
    spread = predicted.covariance + 1e-9 * np.eye(3)
    gain = np.linalg.solve(spread, leads @ own.covariance).T
    mean = own.mean + gain @ offset
    mean[2] = math.remainder(mean[2], 2 * math.pi)
    # A posterior that is wider than its prediction, as after a change of mind, must not widen what came before.
    narrower = gain @ (predicted.covariance - later.covariance) @ gain.T
    covariance = own.covariance - narrower
    if np.linalg.eigvalsh(covariance)[0] <= 0 or np.trace(narrower) < 0:
        covariance = own.covariance
    return Gauss(mean, (covariance + covariance.T) / 2)


def _back(later: Gauss, step: Step, motion: MotionConfig) -> Gauss | None:
    """Where a robot was before a step that odometry knows, ``None`` where it does not."""
    if not step.known:
        return None
    x, y, heading = later.mean.tolist()
    before = heading - step.turn_rad
    dx, dy = step.seen_from(before)
    mean = np.array([x - dx, y - dy, before])
    mean[2] = math.remainder(mean[2], 2 * math.pi)
    return Gauss(mean, moved(Gauss(mean, later.covariance), step, motion).covariance)


def _difference(one: FloatArray, other: FloatArray) -> FloatArray:
    offset: FloatArray = one - other
    offset[2] = math.remainder(offset[2], 2 * math.pi)
    return offset


def _told(estimate: Estimate, smoothed: Gauss | None) -> Estimate:
    """An estimate with a smoothed pose; one that had none is degraded at best."""
    if smoothed is None:
        return estimate
    x, y, heading = smoothed.mean.tolist()
    pose = {"x_m": x, "y_m": y, "heading_rad": heading, "covariance": smoothed.covariance}
    radius = RADIUS_PER_SIGMA * math.sqrt(float(np.linalg.eigvalsh(smoothed.covariance[:2, :2])[-1]))
    if estimate.radius_m is not None:
        # The filter's radius knows of rivals, its covariance does not; it shrinks as the covariance does.
        before = np.trace(estimate.covariance[:2, :2]) if estimate.covariance is not None else 1.0
        share = min(1.0, math.sqrt(float(np.trace(smoothed.covariance[:2, :2]) / before)))
        return replace(estimate, **pose, radius_m=estimate.radius_m * share)
    if radius > _FOUND_RADIUS_M:
        return estimate
    reason = f"told by the frames that came after; by itself: {estimate.reason}"
    return replace(estimate, status=Status.DEGRADED, reason=reason, **pose, radius_m=radius)
