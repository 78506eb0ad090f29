"""Plain nearest neighbours in the full feature space: the honest opponent."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from andante.baselines.baseline import Baseline
from andante.data import FloatArray
from andante.mapping import FrontEnd
from andante.mapping.slow_map import Unit


@dataclass(frozen=True)
class NearestNeighbours(Baseline):
    """The mean position of the nearest mapped frames, weighted by inverse distance.

    ``features`` (n, d) float32 of all mapped frames are kept centred on ``mean`` (d,), ``xy`` (n, 2) are their
    positions. Nothing is learnt and nothing is thinned out.
    """

    neighbours: int
    mean: NDArray[np.float32] = field(repr=False)
    features: NDArray[np.float32] = field(repr=False)
    squared_norms: NDArray[np.float32] = field(repr=False)
    xy: FloatArray = field(repr=False)

    @classmethod
    def fit(
        cls, front_end: FrontEnd, unit: Unit, features: NDArray[np.float32], xy: FloatArray, neighbours: int
    ) -> Self:
        """From features (n, d) and positions (n, 2); with fewer frames than ``neighbours``, all of them."""
        mean = features.mean(axis=0, dtype=np.float64).astype(np.float32)
        centred = features - mean
        norms = np.einsum("nd,nd->n", centred, centred)
        return cls(front_end, unit, min(neighbours, len(xy)), mean, centred, norms, xy)

    @property
    def name(self) -> str:
        """The name in tables."""
        return f"nearest-{self.neighbours}"

    @property
    def bytes(self) -> int:
        """What has to be kept for localizing; features count one byte a number, as in maps."""
        return self.features.size + self.xy.nbytes

    def position(self, features: NDArray[np.float32]) -> FloatArray:
        """(d,) -> (2,)."""
        query = features - self.mean
        # Up to the query's own norm, which is the same for all.
        squared = self.squared_norms - 2 * (self.features @ query)
        nearest = np.argpartition(squared, self.neighbours - 1)[: self.neighbours]
        # One product finds them, but loses the digits of a small distance; the weights need those.
        distance = np.linalg.norm((self.features[nearest] - query).astype(np.float64), axis=1)
        weights = 1 / np.maximum(distance, 1e-9)
        mean: FloatArray = weights @ self.xy[nearest] / weights.sum()
        return mean
