"""From patches of a panorama to what they agree on: descriptor, slow features, comparison and vote."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.features import PatchEncoder
from andante.mapping.gaze_resection import Resection, resect
from andante.mapping.gaze_votes import Gallery, Rules, Verdict, verdict
from andante.sfa import AffineModel


@dataclass(frozen=True, slots=True, eq=False)
class GazeModel:
    """Patches (n, dim) -> slow features (n, k), each with unit noise along the edges: ``mean`` (dim,) and ``weights``.

    Both are float32; the weights (dim, k) hold the metric in which patches are compared.
    """

    mean: NDArray[np.float32]
    weights: NDArray[np.float32]

    @classmethod
    def of(cls, model: AffineModel, metric: FloatArray) -> GazeModel:
        """Slow features, each times its ``metric`` (k,)."""
        return cls(model.mean.astype(np.float32), np.ascontiguousarray(model.weights * metric, dtype=np.float32))

    def transform(self, patches: NDArray[np.float32]) -> NDArray[np.float32]:
        """(n, dim) -> (n, k) float32."""
        return np.asarray((patches - self.mean) @ self.weights, dtype=np.float32)


@dataclass(frozen=True, slots=True, eq=False)
class GazeReadout:
    """All that is needed to look at patches.

    ``encoder`` describes them, ``model`` makes slow features of that, which are compared with those in the ``gallery``;
    ``rules`` say how they vote.
    """

    encoder: PatchEncoder
    model: GazeModel
    gallery: Gallery
    rules: Rules

    def look(self, fields: NDArray[np.float32], azimuth_rad: FloatArray) -> Verdict:
        """What the patches at azimuths (m,) of one panorama agree on, of which ``fields`` (width, channels) are known.

        Raises ``ArrayError`` for no patches.
        """
        patches = self.encoder.cut(fields[None], azimuth_rad[None])[0]
        return verdict(self.gallery, self.model.transform(patches), azimuth_rad, self.rules)

    def resect(self, fields: NDArray[np.float32], azimuth_rad: FloatArray) -> Resection:
        """The same by where the things stand that patches show: for images from away of all drives."""
        slow = self.model.transform(self.encoder.cut(fields[None], azimuth_rad[None])[0])
        xy = self.gallery.xy
        area = np.stack([xy.min(axis=0), xy.max(axis=0)])
        return resect(self.gallery.squared_distances(slow), self.gallery.points_m, azimuth_rad, area)


def spaced_azimuths(patches: int, first_rad: float = 0.0) -> FloatArray:
    """(patches,) azimuths all around at even distances."""
    azimuths: FloatArray = first_rad + 2 * np.pi * np.arange(patches) / patches
    return azimuths
