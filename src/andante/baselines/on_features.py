"""Baselines on the map's features as methods: they read the drives, then fit."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from andante.baselines.baseline import Baseline
from andante.baselines.gaussian_process import GaussianProcess
from andante.baselines.mapped_drives import mapped_drives
from andante.baselines.method import Learned
from andante.baselines.nearest import NearestNeighbours
from andante.baselines.ridge import RidgeRegression
from andante.data import FloatArray, PoseSource
from andante.mapping import FrontEnd, Progress
from andante.mapping.slow_map import Unit
from andante.protocols import Recording

Fit = Callable[[FrontEnd, Unit, NDArray[np.float32], FloatArray], Baseline]
"""From features (n, d) and positions (n, 2)."""


@dataclass(frozen=True)
class OnFeatures:
    """A ``Method``: what ``fit`` makes of the frames and features that the default map learns from."""

    name: str
    fit: Fit = field(repr=False)

    def learn(
        self, recordings: Sequence[Recording], *, positions: PoseSource = "reference", progress: Progress | None = None
    ) -> Learned:
        """Raises ``RecordingError`` for recordings that a map could not be made of either."""
        start = time.perf_counter()
        drives = mapped_drives(recordings, positions, progress=progress)
        read = time.perf_counter()
        localizer = self.fit(drives.front_end, "m", drives.features, drives.xy)
        return Learned(localizer, read - start, time.perf_counter() - read, localizer.bytes)


def nearest(neighbours: int) -> OnFeatures:
    """The nearest neighbours on our features."""

    def fit(front_end: FrontEnd, unit: Unit, features: NDArray[np.float32], xy: FloatArray) -> Baseline:
        return NearestNeighbours.fit(front_end, unit, features, xy, neighbours)

    return OnFeatures(f"nearest-{neighbours}", fit)


def ridge() -> OnFeatures:
    """Ridge regression from our features."""
    return OnFeatures("ridge", RidgeRegression.fit)


def gaussian_process() -> OnFeatures:
    """A Gaussian process from our features."""
    return OnFeatures("gaussian-process", GaussianProcess.fit)
