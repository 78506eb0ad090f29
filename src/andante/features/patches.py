"""A piece of a panorama, wherever it lies, as a vector: what a single patch shows.

Fourier magnitudes need the whole horizon. A patch is described by where in it edges of which direction are: the
panorama is normalised and split into orientations, as for the whole image, then averaged in cells. Cells are read
between columns, so that a patch may lie at any azimuth, and the whole panorama is worked out once for all its patches.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import fft

from andante.data import FloatArray, ImageArray
from andante.errors import ArrayError, ConfigError
from andante.features.illumination import (
    Float32Array,
    Surroundings,
    orientation_channels,
    patch_normalised,
    window_px,
)
from andante.features.stack import as_stack


@dataclass(frozen=True)
class PatchEncoder:
    """Patches ``width_deg`` wide and as high as the panorama -> (dim,) vectors of length one.

    Cells are ``cell_deg`` wide, and as high as ``bands`` in all let them be. The panorama has to show all azimuths.
    """

    height_px: int
    width_px: int
    width_deg: float = 48.0
    cell_deg: float = 4.0
    most_bands: int = 8
    window_share: tuple[float, float] = (0.086, 0.4)
    deviation_floor: float = 20.0
    orientations: int = 2
    gradient_floor: float = 5.0
    orientation_weight: float = 1.4

    def __post_init__(self) -> None:
        if not 0 < self.cell_deg <= self.width_deg <= 360:
            raise ConfigError(
                f"a patch of {self.width_deg:g} degrees cannot be cut into cells of {self.cell_deg:g}: cells have to "
                "be above 0 and at most as wide as the patch, the patch at most 360 degrees"
            )

    @property
    def bands(self) -> int:
        """Number of cells one above the other: a low panorama has one for each of its rows."""
        return min(self.most_bands, self.height_px)

    @property
    def cells(self) -> int:
        """Number of cells side by side."""
        return max(1, round(self.width_deg / self.cell_deg))

    @property
    def channels(self) -> int:
        """Numbers a column: each band as it is and along every orientation."""
        return self.bands * (1 + self.orientations)

    @property
    def dim(self) -> int:
        """Length of the vector of a patch."""
        return self.cells * self.channels

    def fields(self, panoramas: ImageArray) -> Float32Array:
        """Grey uint8 (n, height, width) -> (n, width, channels), of which patches are cut."""
        stack = as_stack(panoramas, (self.height_px, self.width_px))
        around = Surroundings.of(stack, window_px(stack.shape[1:], self.window_share), wrap=True)
        parts = [patch_normalised(around, self.deviation_floor)[:, None]]
        if self.orientations:
            edges = orientation_channels(around, self.orientations, self.gradient_floor)
            parts.append(np.float32(self.orientation_weight) * edges)
        rows = np.arange(self.bands) * self.height_px // self.bands
        heights = np.diff(np.append(rows, self.height_px)).astype(np.float32)
        banded = np.add.reduceat(np.concatenate(parts, axis=1), rows, axis=2) / heights[:, None]
        smooth = fft.irfft(fft.rfft(banded, axis=-1) * self._smoothing, self.width_px, axis=-1)
        columns = smooth.reshape(len(stack), self.channels, self.width_px).transpose(0, 2, 1)
        return np.ascontiguousarray(columns, dtype=np.float32)

    def cut(self, fields: Float32Array, azimuth_rad: FloatArray) -> Float32Array:
        """Fields (n, width, channels) and azimuths (n, m) of the middles of patches -> (n, m, dim).

        Azimuths are counter-clockwise from where the middle of the panorama looks. Raises ``ArrayError`` for azimuths
        of another shape.
        """
        azimuth = np.asarray(azimuth_rad, dtype=np.float64)
        if azimuth.ndim != 2 or len(azimuth) != len(fields):
            raise ArrayError(
                f"azimuths of patches come as one row per panorama ({len(fields)}, m), got shape {azimuth.shape}"
            )
        column = (np.pi - azimuth[..., None] + self._aside) * (self.width_px / (2 * np.pi)) - 0.5
        left = np.floor(column)
        share = (column - left).astype(np.float32)[..., None]
        at = left.astype(np.intp) % self.width_px
        row = np.arange(len(fields))[:, None, None]
        patches = fields[row, at] * (1 - share) + fields[row, (at + 1) % self.width_px] * share
        patches = patches.reshape(*azimuth.shape, self.dim)
        length = np.linalg.norm(patches, axis=2, keepdims=True)
        return np.asarray(patches / np.where(length > 0, length, 1), dtype=np.float32)

    @cached_property
    def _aside(self) -> FloatArray:
        """(cells,) how far to the right of the middle of a patch its cells lie, in radians."""
        aside: FloatArray = np.radians((np.arange(self.cells) - (self.cells - 1) / 2) * self.cell_deg)
        return aside

    @cached_property
    def _smoothing(self) -> Float32Array:
        """Of the spectrum of a row: by a Gaussian half as wide as a cell."""
        k = np.arange(self.width_px // 2 + 1)
        smoothing: Float32Array = np.exp(-0.5 * (k * np.radians(self.cell_deg) / 2) ** 2).astype(np.float32)
        return smoothing
