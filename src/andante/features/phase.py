"""The phases that Fourier magnitudes leave out: which way the robot looks, and how the rows of a place stand together.

A robot that turns left by an angle t shifts its panorama to the right, and multiplies the k-th Fourier coefficient of
every row by exp(-i k t) (thesis 5.1, theory 7). Signatures of one place that were taken under two headings are the same
but for that factor, from which the turn between them follows.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from andante.data import FloatArray, ImageArray
from andante.features.illumination import Float32Array, Surroundings, patch_normalised, window_px
from andante.features.stack import as_stack, unit_length

ComplexArray = NDArray[np.complex64]


@dataclass(frozen=True)
class PhaseEncoder:
    """Panoramas (height, width) -> signatures (2 bands K,): coefficients 1..K of bands of the panorama.

    The panorama is patch-normalised, so that bright sky and dark ground count no more than their edges; real and
    imaginary parts follow each other, and each signature has length one.
    """

    height_px: int
    width_px: int
    most_bands: int = 6
    n_frequencies: int = 40
    window_share: tuple[float, float] = (0.043, 0.2)
    deviation_floor: float = 20.0

    @property
    def bands(self) -> int:
        """Number of bands: a low panorama has one for each of its rows."""
        return min(self.most_bands, self.height_px)

    @property
    def frequencies(self) -> int:
        """Number K of coefficients a band: a narrow panorama has fewer."""
        return min(self.n_frequencies, self.width_px // 2)

    @property
    def dim(self) -> int:
        """Length of a signature."""
        return 2 * self.bands * self.frequencies

    @cached_property
    def band_weights(self) -> Float32Array:
        """(bands, height) how much each row counts in each band, the uppermost first; every band sums to one."""
        rows = np.eye(self.height_px, dtype=np.float32)
        # Rows that lie in two bands count in each by their share.
        return np.asarray(cv2.resize(rows, (self.height_px, self.bands), interpolation=cv2.INTER_AREA), np.float32)

    def encode(self, panoramas: ImageArray) -> Float32Array:
        """Grey uint8 (height, width) -> (dim,) float32, or a stack (n, height, width) -> (n, dim)."""
        stack = as_stack(panoramas, (self.height_px, self.width_px))
        window = window_px((self.height_px, self.width_px), self.window_share)
        normal = patch_normalised(Surroundings.of(stack, window, wrap=True), self.deviation_floor)
        spectra = fft.rfft(self.band_weights @ normal, axis=-1)[..., 1 : self.frequencies + 1].astype(np.complex64)
        rows = unit_length(as_rows(spectra))
        return rows.reshape(*panoramas.shape[:-2], self.dim)

    def spectra(self, signatures: Float32Array) -> ComplexArray:
        """(n, dim) -> (n, bands, K) complex."""
        rows = np.ascontiguousarray(signatures, dtype=np.float32)
        return rows.view(np.complex64).reshape(len(rows), self.bands, self.frequencies)

    def turned(self, signatures: Float32Array, by_rad: FloatArray) -> Float32Array:
        """Signatures (n, dim) as they would be had the robot turned to the left by so much (n,) before."""
        k = np.arange(1, self.frequencies + 1)
        factor = np.exp(-1j * k * np.asarray(by_rad)[:, None]).astype(np.complex64)
        return as_rows(self.spectra(signatures) * factor[:, None])


def as_rows(spectra: ComplexArray) -> Float32Array:
    """(n, bands, K) complex -> (n, 2 bands K) float32."""
    rows = np.ascontiguousarray(spectra, dtype=np.complex64).view(np.float32)
    return rows.reshape(len(spectra), -1)
