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
from andante.mapping.located import Readout
from andante.mapping.readout import fit_readout
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
        components, config = pca.transform(training.features), slowmap.config.readout
        # A map resolves how far apart its neighbours may lie before it is saved.
        consensus_m = config.consensus_m or np.inf
        readout = fit_readout(
            components,
            training.xy,
            training.session,
            metric=np.ones(pca.output_dim),
            config=config,
            consensus_m=consensus_m,
        )
        return cls(slowmap.front_end, slowmap.unit, pca, readout)

    @property
    def name(self) -> str:
        """The name in tables."""
        return "pca + same readout"

    @property
    def bytes(self) -> int:
        """What has to be kept for localizing."""
        readout = sum(array.nbytes for array in self.readout.to_arrays().values())
        return self.pca.mean.nbytes + self.pca.components.nbytes + readout

    def position(self, features: NDArray[np.float32]) -> FloatArray:
        """(d,) -> (2,)."""
        xy: FloatArray = self.readout.locate(self.pca.transform(features[None])).xy[0]
        return xy
