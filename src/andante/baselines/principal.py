"""Principal components in the place of slow features: what compression alone achieves."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from andante.baselines.baseline import Baseline
from andante.baselines.training import Training
from andante.data import FloatArray
from andante.mapping import SlowMap
from andante.mapping.readout import GaussianProcessReadout, LocalReadout, PolynomialReadout, Readout
from andante.mapping.thinning import thinned_by_place
from andante.sfa import PCA, pca_of_samples


@dataclass(frozen=True)
class PrincipalComponents(Baseline):
    """As many principal components as the map has slow features, then the map's kind of readout, unweighted."""

    pca: PCA = field(repr=False)
    readout: Readout = field(repr=False)

    @classmethod
    def fit(cls, slowmap: SlowMap, training: Training) -> Self:
        """From the frames that the map was made from."""
        pca = pca_of_samples(training.features, slowmap.model.output_dim)
        readout = _same_readout(slowmap, pca.transform(training.features), training)
        return cls(slowmap.front_end, slowmap.unit, pca, readout)

    @property
    def name(self) -> str:
        """The name in tables."""
        return "pca + same readout"

    def position(self, features: NDArray[np.float32]) -> FloatArray:
        """(d,) -> (2,)."""
        xy: FloatArray = self.readout.locate(self.pca.transform(features[None])).xy[0]
        return xy


def _same_readout(slowmap: SlowMap, components: FloatArray, training: Training) -> Readout:
    config, metric = slowmap.config.readout, np.ones(components.shape[1])
    if isinstance(slowmap.readout, PolynomialReadout):
        return PolynomialReadout.fit(components, training.xy, config)
    if isinstance(slowmap.readout, GaussianProcessReadout):
        return GaussianProcessReadout.fit(components, training.xy, metric)
    if not isinstance(slowmap.readout, LocalReadout):
        raise TypeError(f"no way to fit a {type(slowmap.readout).__name__}")
    kept = thinned_by_place(training.xy, training.session, config.max_references)
    return LocalReadout.fit(components[kept], training.xy[kept], metric, config, slowmap.readout.consensus_m)
