"""What the layers of a learnt network make of a panorama, as features for whatever learns on top of them."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from andante.data import ImageArray
from andante.errors import ConfigError
from andante.features.illumination import Float32Array
from andante.features.stack import unit_length
from andante.sfa import HierarchicalModel


@dataclass(frozen=True)
class NetworkEncoder:
    """Panoramas (height, width) -> outputs (k,) of a hierarchical network, or of its first layers (``model.first``).

    The network is learnt, so two encoders are alike only if their networks are; heading matters as the network was
    taught (``HierarchicalSFA``, turns). With ``unit`` they are brought to unit length: in another light or season all
    outputs may be larger or smaller together.
    """

    model: HierarchicalModel
    unit: bool = False

    @property
    def dim(self) -> int:
        """Number of outputs k."""
        return self.model.output_dim

    def encode(self, panoramas: ImageArray) -> Float32Array:
        """Grey uint8 (height, width) -> (dim,) float32, or a stack (n, height, width) -> (n, dim)."""
        if panoramas.ndim not in (2, 3) or panoramas.shape[-2:] != self.model.shape or panoramas.dtype != np.uint8:
            raise ConfigError(
                f"this encoder takes grey uint8 panoramas {self.model.shape}, one or a stack of them, got "
                f"{panoramas.dtype} of shape {panoramas.shape}; make them with the camera that its network learnt from"
            )
        # One by one: in a stack the last digits would depend on how many others there are.
        stack = panoramas.reshape(-1, *self.model.shape)
        outputs = np.empty((len(stack), self.dim), dtype=np.float32)
        for row, panorama in zip(outputs, stack, strict=True):
            row[:] = self.model.transform(panorama)
        rows = unit_length(outputs) if self.unit else outputs
        return rows.reshape(*panoramas.shape[:-2], self.dim)
