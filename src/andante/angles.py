"""Angles on the circle."""

from __future__ import annotations

from typing import overload

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray


@overload
def wrapped(angle_rad: float) -> float: ...
@overload
def wrapped(angle_rad: NDArray[np.floating]) -> FloatArray: ...
def wrapped(angle_rad: float | NDArray[np.floating]) -> float | FloatArray:
    """The same angles, or the same angle, in [-pi, pi)."""
    turned = np.mod(np.asarray(angle_rad, np.float64) + np.pi, 2.0 * np.pi) - np.pi
    return float(turned) if turned.ndim == 0 else turned
