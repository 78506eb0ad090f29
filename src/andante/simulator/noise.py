"""Tileable noise: white noise whose spectrum falls off, made by FFT, so that opposite edges meet."""

from __future__ import annotations

import numpy as np

from andante.data import FloatArray


def tileable_noise(rng: np.random.Generator, size: int, slope: float, low_cut: float = 0.0) -> FloatArray:
    """(size, size) noise of mean 0 and deviation 1 whose amplitude falls with frequency to the power ``slope``.

    Frequencies below ``low_cut`` cycles a tile are left out: what repeats at every tile would be seen from afar.
    """
    frequency = np.hypot(np.fft.fftfreq(size)[:, None], np.fft.rfftfreq(size)[None, :]) * size
    gain = np.where(frequency > max(low_cut, 0.5), np.maximum(frequency, 1.0) ** -slope, 0.0)
    noise = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((size, size))) * gain, (size, size))
    return np.asarray((noise - noise.mean()) / noise.std(), np.float64)


def lookup(tile: FloatArray, u: FloatArray, v: FloatArray) -> FloatArray:
    """Bilinear samples of a tile that repeats with period 1 in ``u`` and ``v``."""
    size = tile.shape[0]
    x, y = u * size, v * size
    column, row = np.floor(x).astype(np.int64), np.floor(y).astype(np.int64)
    right, down = x - column, y - row
    column, row = column % size, row % size
    next_column, next_row = (column + 1) % size, (row + 1) % size
    top = tile[row, column] * (1 - right) + tile[row, next_column] * right
    bottom = tile[next_row, column] * (1 - right) + tile[next_row, next_column] * right
    return np.asarray(top * (1 - down) + bottom * down, np.float64)
