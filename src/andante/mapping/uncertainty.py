"""What held-out errors promise of new ones (split conformal prediction, theory 9), and as which Gaussian it is told."""

from __future__ import annotations

import numpy as np

from andante.data import FloatArray

RADIUS_OF_90_PERCENT = float(np.sqrt(2 * np.log(10)))
"""Of a round Gaussian in the plane, in standard deviations along an axis."""
DEVIATIONS_OF_90_PERCENT = 1.645
"""Of a Gaussian on a line, to both sides."""
LEAST_OFF_RAD = float(np.radians(0.2))
"""No heading is promised more finely."""


def covariance_of(shape: FloatArray, radius_m: float, off_rad: float) -> FloatArray:
    """(3, 3) over x, y and heading: of the ``shape`` (2, 2), and as large as both calibrated bounds say.

    The 90 % radius of such a Gaussian, were it round, is ``radius_m``; NaN for an unknown heading.
    """
    covariance = np.full((3, 3), np.nan)
    covariance[:2, :2] = shape * (2 * (radius_m / RADIUS_OF_90_PERCENT) ** 2 / np.trace(shape))
    if np.isfinite(off_rad):
        covariance[2] = covariance[:, 2] = 0.0
        covariance[2, 2] = (max(off_rad, LEAST_OFF_RAD) / DEVIATIONS_OF_90_PERCENT) ** 2
    return covariance


def conformal_factor(error: FloatArray, sigma: FloatArray, coverage: float) -> float:
    """The factor f with error <= f sigma for at least ``coverage`` of exchangeable new frames.

    The ceil((n + 1) coverage)-th smallest score of n; the largest where n is too small for that.
    """
    scores = np.sort(error / sigma)
    rank = int(np.ceil((len(scores) + 1) * coverage))
    return float(scores[min(rank, len(scores)) - 1])
