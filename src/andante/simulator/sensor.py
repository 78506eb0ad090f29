"""From light to grey levels: exposure, tone curve, noise."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from andante.data import ImageArray
from andante.simulator.mesh import FloatArray32

_SHOULDER = np.float32(1.35)
_CURVE_STEPS = 4096
_CURVE_END = 8.0
_NOISE_SEED = 20240602
_NOISE_VALUES = 1 << 21
_CURVE = (255.0 * (1.0 - np.exp(-_SHOULDER * np.linspace(0.0, _CURVE_END, _CURVE_STEPS))) ** (1.0 / 2.2)).astype(
    np.float32
)


def developed(light: FloatArray32, exposure: float, noise: float, rng: np.random.Generator) -> ImageArray:
    """Linear RGB (k, 3) -> BGR (k, 3) uint8: 1 - exp(-1.35 x) as shoulder, gamma 2.2, normal noise in grey levels."""
    step = np.minimum(light * np.float32(exposure * (_CURVE_STEPS - 1) / _CURVE_END), np.float32(_CURVE_STEPS - 1))
    levels = np.take(_CURVE, step.astype(np.int32))
    if noise > 0.0:
        # A stretch of a fixed bank from a random place: as random as fresh values to the eye, and ten times as fast.
        bank = _noise_bank(max(_NOISE_VALUES, 2 * levels.size))
        start = int(rng.integers(len(bank) - levels.size))
        levels += bank[start : start + levels.size].reshape(levels.shape) * np.float32(noise)
    np.clip(np.rint(levels, out=levels), 0.0, 255.0, out=levels)
    return np.asarray(levels[:, ::-1], np.uint8)


@lru_cache(maxsize=2)
def _noise_bank(values: int) -> FloatArray32:
    return np.random.default_rng(_NOISE_SEED).standard_normal(values, np.float32)
