"""Grey pixels of the panorama: the input of the hierarchical network (thesis 5.1, raw pixel values)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from andante.data import ImageArray
from andante.errors import ConfigError
from andante.features.fourier import unit_length
from andante.features.illumination import Float32Array, as_grey, patch_normalised, window_px


@dataclass(frozen=True)
class PixelEncoder:
    """A panorama (height, width) -> its pixels (height * width,), row by row.

    Pixels keep the heading: the robot's turn shifts them. With ``normalise`` they are patch-normalised and
    brought to unit length, else they are grey levels 0..255.
    """

    height_px: int
    width_px: int
    normalise: bool = True
    window_share: tuple[float, float] = (0.037, 0.13)
    deviation_floor: float = 20.0
    wrap: bool = True

    @property
    def dim(self) -> int:
        """Number of pixels."""
        return self.height_px * self.width_px

    def encode(self, panorama: ImageArray) -> Float32Array:
        """(height, width) or (height, width, 3) uint8 -> (dim,) float32."""
        grey = as_grey(panorama)
        if grey.shape != (self.height_px, self.width_px):
            raise ConfigError(
                f"this encoder takes panoramas of {self.width_px}x{self.height_px} px, "
                f"got {grey.shape[1]}x{grey.shape[0]}"
            )
        if not self.normalise:
            return grey.ravel()
        window = window_px((self.height_px, self.width_px), self.window_share)
        return unit_length(np.asarray(patch_normalised(grey, window, self.deviation_floor, wrap=self.wrap)).ravel())
