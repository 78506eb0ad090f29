"""The border of a lawn: a rounded closed line, like the buried wire of a mowing robot."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import ArrayLike
from scipy.ndimage import gaussian_filter1d

from andante.data import FloatArray
from andante.errors import ConfigError

_SPACING_M = 0.05


@dataclass(frozen=True, slots=True)
class Border:
    """A closed line (m, 2), counter-clockwise, about 5 cm from point to point."""

    points_m: FloatArray

    @classmethod
    def rounded(cls, corners_m: ArrayLike, rounding_m: float) -> Border:
        """A polygon (k, 2) with its corners smoothed over about ``rounding_m``."""
        corners = np.asarray(corners_m, np.float64)
        dense = resampled(corners, _SPACING_M)
        return cls(resampled(gaussian_filter1d(dense, rounding_m / _SPACING_M, axis=0, mode="wrap"), _SPACING_M))

    def inset(self, offset_m: float) -> Border:
        """The line shifted inwards by ``offset_m`` (outwards where negative); raises ``ConfigError`` where too far."""
        ahead = np.roll(self.points_m, -1, 0) - np.roll(self.points_m, 1, 0)
        inward = np.stack([-ahead[:, 1], ahead[:, 0]], 1) / np.linalg.norm(ahead, axis=1, keepdims=True)
        shifted = Border(self.points_m + inward * offset_m)
        # A line that is shifted beyond its curvature crosses itself: such points come too near to the original.
        clean = shifted.points_m[np.abs(self.inside_m(shifted.points_m) - offset_m) < 0.02 + 0.02 * abs(offset_m)]
        if len(clean) < 20:
            raise ConfigError(f"an offset of {offset_m:g} m leaves nothing of this border; use a smaller one")
        return Border(resampled(clean, _SPACING_M))

    def inside_m(self, xy_m: ArrayLike) -> FloatArray:
        """(k, 2) points -> (k,) distance to the line, positive inside."""
        line = self.points_m.astype(np.float32).reshape(-1, 1, 2)
        points = np.asarray(xy_m, np.float64).reshape(-1, 2)
        return np.array([cv2.pointPolygonTest(line, (float(x), float(y)), True) for x, y in points], np.float64)

    @property
    def length_m(self) -> float:
        """Once around."""
        return float(np.linalg.norm(np.roll(self.points_m, -1, 0) - self.points_m, axis=1).sum())


def resampled(closed_m: FloatArray, spacing_m: float) -> FloatArray:
    """A closed line (k, 2) as points equally far apart, about ``spacing_m``."""
    loop = np.concatenate([closed_m, closed_m[:1]])
    arc = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(loop, axis=0), axis=1))])
    at = np.linspace(0.0, arc[-1], max(round(float(arc[-1]) / spacing_m), 3), endpoint=False)
    return np.stack([np.interp(at, arc, loop[:, 0]), np.interp(at, arc, loop[:, 1])], 1)
