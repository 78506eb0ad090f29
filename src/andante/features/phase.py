"""The phases that Fourier magnitudes leave out: which way the robot looks, and how far away things are.

A robot that turns left by an angle t shifts its panorama to the right, and multiplies the k-th Fourier coefficient of
every row by exp(-i k t) (thesis 5.1, theory 7). Signatures of one place that were taken under two headings are the same
but for that factor, from which the turn between them follows. As long as the elevations of the rows are known, bands
are evenly spaced in the logarithm of their tangent: what comes nearer by a factor grows, and there it only moves up.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, TypeVar

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from andante.data import FloatArray, ImageArray
from andante.features.illumination import Float32Array, Surroundings, patch_normalised, window_px
from andante.features.stack import as_stack, unit_length

ComplexArray = NDArray[np.complex64]
_Samples = TypeVar("_Samples", float, NDArray[np.float32], FloatArray)
_LOWEST_DEG = 1.0
_SAMPLES = 8
"""Of a band, of which it is the average."""


@dataclass(frozen=True)
class PhaseEncoder:
    """Panoramas (height, width) -> signatures (2 bands K,): coefficients 1..K of bands of the panorama.

    ``elevation_deg`` are those of the lower and the upper rim of the panorama, ``None`` where they are not known: bands
    are then as high as each other. The panorama is patch-normalised, so that bright sky and dark ground count no more
    than their edges; real and imaginary parts follow each other, and each signature has length one.
    """

    height_px: int
    width_px: int
    elevation_deg: tuple[float, float] | None = None
    most_bands: int = 12
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
        bands, height = self.bands, self.height_px
        down = (np.arange(bands * _SAMPLES) + 0.5) / (bands * _SAMPLES)
        if self._log_tangents is None:
            row = down * height - 0.5
        else:
            low, high = self._log_tangents
            assert self.elevation_deg is not None
            bottom, top = self.elevation_deg
            elevation = np.degrees(np.arctan(np.exp(high - (high - low) * down)))
            row = (top - elevation) / (top - bottom) * height - 0.5
        row = np.clip(row, 0, height - 1)
        rows = np.arange(height)
        weights = np.maximum(1 - np.abs(row[:, None] - rows), 0).reshape(bands, _SAMPLES, height).mean(axis=1)
        return np.asarray(weights, dtype=np.float32)

    @property
    def band_step(self) -> float | None:
        """By which factor, in its logarithm, a thing comes nearer as it moves up by a band; ``None`` if not known."""
        if self._log_tangents is None:
            return None
        low, high = self._log_tangents
        return (high - low) / self.bands

    @property
    def _log_tangents(self) -> tuple[float, float] | None:
        """Of the lower and upper rim of all bands; there are none below the horizon."""
        if self.elevation_deg is None or self.elevation_deg[1] < 2 * _LOWEST_DEG or self.elevation_deg[1] >= 90:
            return None
        low, high = np.log(np.tan(np.radians([max(self.elevation_deg[0], _LOWEST_DEG), self.elevation_deg[1]])))
        return float(low), float(high)

    def encode(self, panoramas: ImageArray) -> Float32Array:
        """Grey uint8 (height, width) -> (dim,) float32, or a stack (n, height, width) -> (n, dim)."""
        stack = as_stack(panoramas, (self.height_px, self.width_px))
        window = window_px((self.height_px, self.width_px), self.window_share)
        normal = patch_normalised(Surroundings.of(stack, window, wrap=True), self.deviation_floor)
        return self.encoded(self.band_weights @ normal).reshape(*panoramas.shape[:-2], self.dim)

    def encoded(self, pictures: Float32Array) -> Float32Array:
        """Bands (n, bands, width) of normalised panoramas of any width -> signatures (n, dim)."""
        width = pictures.shape[-1]
        spectra = fft.rfft(pictures, axis=-1)[..., 1 : self.frequencies + 1]
        return unit_length(as_rows(spectra * np.conj(self._moved(width))))

    def spectra(self, signatures: Float32Array) -> ComplexArray:
        """(n, dim) -> (n, bands, K) complex."""
        rows = np.ascontiguousarray(signatures, dtype=np.float32)
        return rows.view(np.complex64).reshape(len(rows), self.bands, self.frequencies)

    def turned(self, signatures: Float32Array, by_rad: FloatArray) -> Float32Array:
        """Signatures (n, dim) as they would be had the robot turned to the left by so much (n,) before."""
        k = np.arange(1, self.frequencies + 1)
        factor = np.exp(-1j * k * np.asarray(by_rad)[:, None]).astype(np.complex64)
        return as_rows(self.spectra(signatures) * factor[:, None])

    def pictures(self, signatures: Float32Array, width: int) -> Float32Array:
        """(n, dim) -> (n, bands, width): the panoramas that signatures stand for, with all finer detail gone.

        Column j looks where column j of a panorama of that width does: at azimuth pi - 2 pi (j + 0.5) / width.
        """
        spectrum = np.zeros((len(signatures), self.bands, width // 2 + 1), dtype=np.complex64)
        spectrum[..., 1 : self.frequencies + 1] = (self.spectra(signatures) * self._moved(width))[..., : width // 2]
        return np.asarray(fft.irfft(spectrum, width, axis=-1), dtype=np.float32)

    def _moved(self, width: int) -> ComplexArray:
        """(K,) from a panorama of ``width_px`` to one of another width, whose pixels have their centres elsewhere."""
        k = np.arange(1, self.frequencies + 1)
        return np.asarray(np.exp(1j * np.pi * k * (1 / width - 1 / self.width_px)), dtype=np.complex64)


def as_rows(spectra: NDArray[np.complexfloating[Any, Any]]) -> Float32Array:
    """(n, bands, K) complex -> (n, 2 bands K) float32."""
    rows = np.ascontiguousarray(spectra, dtype=np.complex64).view(np.float32)
    return rows.reshape(len(spectra), -1)


def alike_under_turns(seen: ComplexArray, stored: ComplexArray, samples: int) -> FloatArray:
    """How alike spectra (..., bands, K) are under turns of 2 pi j / ``samples``: (..., samples), at most one.

    ``seen`` was taken by a robot that had turned so far to the left from the heading of ``stored``.
    """
    spectrum = np.zeros((*np.broadcast_shapes(seen.shape, stored.shape)[:-2], samples // 2 + 1), dtype=np.complex64)
    spectrum[..., 1 : seen.shape[-1] + 1] = (seen * np.conj(stored)).sum(axis=-2)
    return np.asarray(fft.irfft(spectrum, samples, axis=-1) * (samples / 2), dtype=np.float64)


def summit(low: _Samples, top: _Samples, high: _Samples, least_bend: float = 1e-12) -> _Samples:
    """How far from the best of three neighbouring samples, in their distance, a parabola through them has its top.

    ``least_bend`` keeps three samples on a line from putting it at infinity.
    """
    aside: _Samples = 0.5 * (low - high) / np.minimum(low - 2 * top + high, -least_bend)
    return aside
