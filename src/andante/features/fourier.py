"""Row-wise Fourier magnitudes: the same whichever way the robot looks (thesis 5.1, after Menegatti 2003)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import fft

from andante.data import ImageArray
from andante.errors import ConfigError
from andante.features.illumination import (
    Float32Array,
    Surroundings,
    orientation_channels,
    patch_normalised,
    window_px,
)
from andante.features.stack import as_stack, unit_length


def fourier_magnitudes(rows: Float32Array, n_frequencies: int) -> Float32Array:
    """Magnitudes of the lowest frequencies, constant included: (..., width) -> (..., n_frequencies)."""
    return np.abs(fft.rfft(rows, axis=-1)[..., :n_frequencies])


@dataclass(frozen=True)
class FourierEncoder:
    """Panoramas (height, width) -> magnitudes of the lowest ``n_frequencies`` of every row.

    With ``normalise`` the rows are patch-normalised first; with ``orientations`` > 0 that many channels of
    gradient strength are transformed as well and weighted by ``orientation_weight``. Without both, and
    without ``unit``, this is the thesis' feature: 15 magnitudes of 60 grey rows, 900 numbers.
    """

    height_px: int
    width_px: int
    n_frequencies: int = 40
    normalise: bool = True
    window_share: tuple[float, float] = (0.043, 0.2)
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

    @property
    def dim(self) -> int:
        """Length of the feature vector: rows x frequencies x (1 + orientations)."""
        return self.height_px * self.n_frequencies * (1 + self.orientations)

    def encode(self, panoramas: ImageArray) -> Float32Array:
        """Grey uint8 (height, width) -> (dim,) float32, or a stack (n, height, width) -> (n, dim)."""
        stack = as_stack(panoramas, (self.height_px, self.width_px))
        window = window_px((self.height_px, self.width_px), self.window_share)
        around = Surroundings.of(stack, window, wrap=self.wrap)
        base = patch_normalised(around, self.deviation_floor) if self.normalise else stack
        features = self._scaled(fourier_magnitudes(base, self.n_frequencies))
        if self.orientations:
            channels = orientation_channels(around, self.orientations, self.gradient_floor)
            edges = self._scaled(fourier_magnitudes(channels, self.n_frequencies))
            features = self._scaled(np.concatenate([features, np.float32(self.orientation_weight) * edges], axis=1))
        return features.reshape(*panoramas.shape[:-2], self.dim)

    def _scaled(self, magnitudes: Float32Array) -> Float32Array:
        flat = magnitudes.reshape(len(magnitudes), -1)
        return unit_length(flat) if self.unit else flat
