"""The two trackers, and how one is chosen."""

from __future__ import annotations

from typing import Literal

import numpy as np

from andante.localization.config import KalmanConfig, ParticleConfig
from andante.localization.fusion import FusingTracker
from andante.localization.kalman_filter import KalmanFilter
from andante.localization.particle_filter import ParticleFilter
from andante.mapping.slow_map import SlowMap

TrackerKind = Literal["particles", "kalman"]
_PARTICLES, _KALMAN = ParticleConfig(), KalmanConfig()


class ParticleTracker(FusingTracker):
    """Keeps every place in mind where the robot may be; the one to use where the processor allows a millisecond."""

    name = "particles"

    def __init__(self, slowmap: SlowMap, config: ParticleConfig = _PARTICLES, *, seed: int = 0) -> None:
        self._particles, self._seed = config, seed
        super().__init__(slowmap, config)

    def _new_filter(self) -> ParticleFilter:
        return ParticleFilter(self._particles, np.random.default_rng(self._seed))


class KalmanTracker(FusingTracker):
    """Keeps one place in mind (thesis 8.6): lighter, and slower to find back."""

    name = "kalman"

    def __init__(self, slowmap: SlowMap, config: KalmanConfig = _KALMAN) -> None:
        self._kalman = config
        super().__init__(slowmap, config)

    def _new_filter(self) -> KalmanFilter:
        return KalmanFilter(self._kalman)


def make_tracker(
    slowmap: SlowMap, kind: TrackerKind = "particles", *, seed: int = 0
) -> ParticleTracker | KalmanTracker:
    """A tracker with its defaults; ``seed`` decides the particles."""
    return KalmanTracker(slowmap) if kind == "kalman" else ParticleTracker(slowmap, seed=seed)
