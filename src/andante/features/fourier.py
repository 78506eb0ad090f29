"""Row-wise Fourier magnitudes: the same whichever way the robot looks (thesis 5.1, after Menegatti 2003)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from andante.data import ImageArray
from andante.errors import ConfigError
from andante.features.illumination import (
    Float32Array,
    as_grey,
    orientation_channels,
    patch_normalised,
    window_px,
)


def fourier_magnitudes(rows: Float32Array, n_frequencies: int) -> Float32Array:
    """Magnitudes of the lowest frequencies, constant included: (..., width) -> (..., n_frequencies)."""
    return np.abs(fft.rfft(rows, axis=-1)[..., :n_frequencies])


def unit_length(vector: NDArray[np.float32]) -> NDArray[np.float32]:
    """The vector at Euclidean length one; a zero vector stays as it is."""
    length = float(np.linalg.norm(vector))
    return vector / np.float32(length) if length > 0 else vector


@dataclass(frozen=True)
class FourierEncoder:
    """A panorama (height, width) -> magnitudes of the lowest ``n_frequencies`` of every row.

    With ``normalise`` the rows are patch-normalised first; with ``orientations`` > 0 that many channels of
    gradient strength are transformed as well and weighted by ``orientation_weight``. Without both, and
    without ``unit``, this is the thesis' feature: 15 magnitudes of 60 grey rows, 900 numbers.
    """

    height_px: int
    width_px: int
    n_frequencies: int = 40
    normalise: bool = True
    window_share: tuple[float, float] = (0.037, 0.13)
    deviation_floor: float = 20.0
    orientations: int = 2
    gradient_floor: float = 5.0
    orientation_weight: float = 1.4
    unit: bool = True
    wrap: bool = True

    def __post_init__(self) -> None:
        available = self.width_px // 2 + 1
        if not 1 <= self.n_frequencies <= available:
            raise ConfigError(
                f"n_frequencies must be in 1..{available} for panoramas {self.width_px} px wide, "
                f"got {self.n_frequencies}; lower it or widen the panorama"
            )
        if self.orientations and min(self.height_px, self.width_px) < 2:
            raise ConfigError(
                f"orientation channels need panoramas of at least 2x2 px, got {self.width_px}x{self.height_px}; "
                "set orientations = 0"
            )

    @property
    def dim(self) -> int:
        """Length of the feature vector: rows x frequencies x (1 + orientations)."""
        return self.height_px * self.n_frequencies * (1 + self.orientations)

    def encode(self, panorama: ImageArray) -> Float32Array:
        """(height, width) or (height, width, 3) uint8 -> (dim,) float32."""
        grey = as_grey(panorama)
        if grey.shape != (self.height_px, self.width_px):
            raise ConfigError(
                f"this encoder takes panoramas of {self.width_px}x{self.height_px} px, "
                f"got {grey.shape[1]}x{grey.shape[0]}"
            )
        window = window_px((self.height_px, self.width_px), self.window_share)
        base = patch_normalised(grey, window, self.deviation_floor, wrap=self.wrap) if self.normalise else grey
        parts = [self._scaled(fourier_magnitudes(base, self.n_frequencies))]
        if self.orientations:
            channels = orientation_channels(grey, self.orientations, window, self.gradient_floor, wrap=self.wrap)
            magnitudes = self._scaled(fourier_magnitudes(channels, self.n_frequencies))
            parts.append(np.float32(self.orientation_weight) * magnitudes)
        vector = np.concatenate(parts)
        return self._scaled(vector) if self.orientations else vector

    def _scaled(self, magnitudes: Float32Array) -> Float32Array:
        flat = magnitudes.ravel()
        return unit_length(flat) if self.unit else flat
