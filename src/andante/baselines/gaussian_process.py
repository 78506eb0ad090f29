"""A Gaussian process from all features to positions: regression without slow features in between."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from andante.baselines.baseline import Baseline
from andante.data import FloatArray
from andante.mapping import FrontEnd
from andante.mapping.regressions import GaussianProcessReadout
from andante.mapping.slow_map import Unit
from andante.sfa import one_thread


@dataclass(frozen=True)
class GaussianProcess(Baseline):
    """The mean of the map's Gaussian process, which keeps at most 600 frames, on features as they come."""

    process: GaussianProcessReadout = field(repr=False)

    @classmethod
    def fit(cls, front_end: FrontEnd, unit: Unit, features: NDArray[np.float32], xy: FloatArray) -> Self:
        """From features (n, d) and positions (n, 2); raises ``LearningError`` where all frames are alike."""
        with one_thread():
            process = GaussianProcessReadout.fit(features.astype(np.float64), xy, np.ones(features.shape[1]))
        return cls(front_end, unit, process)

    @property
    def name(self) -> str:
        """The name in tables."""
        return "gaussian process"

    @property
    def bytes(self) -> int:
        """What has to be kept for localizing; the mean needs no variances, and features count one byte a number."""
        return self.process.points.size + self.process.dual.nbytes

    def position(self, features: NDArray[np.float32]) -> FloatArray:
        """(d,) -> (2,)."""
        xy: FloatArray = self.process.position(features[None].astype(np.float64))[0]
        return xy
