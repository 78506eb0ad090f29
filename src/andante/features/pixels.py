"""Grey pixels of the panorama as one vector: what cameras that do not look all around are mapped by."""

from __future__ import annotations

from dataclasses import dataclass

from andante.data import ImageArray
from andante.features.illumination import Float32Array, Surroundings, patch_normalised, window_px
from andante.features.stack import as_stack, unit_length


@dataclass(frozen=True)
class PixelEncoder:
    """Panoramas (height, width) -> their pixels (height * width,), row by row.

    Pixels keep the heading: the robot's turn shifts them. With ``normalise`` they are patch-normalised and
    brought to unit length, else they are grey levels 0..255.
    """

    height_px: int
    width_px: int
    normalise: bool = True
    window_share: tuple[float, float] = (0.043, 0.2)
    deviation_floor: float = 20.0
    wrap: bool = True

    @property
    def dim(self) -> int:
        """Number of pixels."""
        return self.height_px * self.width_px

    def encode(self, panoramas: ImageArray) -> Float32Array:
        """Grey uint8 (height, width) -> (dim,) float32, or a stack (n, height, width) -> (n, dim)."""
        stack = as_stack(panoramas, (self.height_px, self.width_px))
        if self.normalise:
            window = window_px((self.height_px, self.width_px), self.window_share)
            stack = patch_normalised(Surroundings.of(stack, window, wrap=self.wrap), self.deviation_floor)
            stack = unit_length(stack.reshape(len(stack), -1))
        return stack.reshape(*panoramas.shape[:-2], self.dim)
