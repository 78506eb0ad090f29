"""Estimates in a frame of their own laid over the truth, although some of them are metres away."""

from __future__ import annotations

import numpy as np

from andante.data import FloatArray
from andante.evaluation.alignment import Alignment, fit_rigid

_TRIALS = 500
_FEWEST = 3
_SPREAD_M = 0.5


def fit_robustly(mapped: FloatArray, truth: FloatArray, source: str) -> Alignment | None:
    """Rotation and translation from ``mapped`` (n, 2) to ``truth`` (n, 2), either with NaN where unknown.

    Least median of squares over random pairs (Rousseeuw 1984), then least squares on the closer half, which is what
    ``source`` names. ``None`` where fewer than three pairs are known, or all at one spot.
    """
    known = np.isfinite(mapped).all(axis=1) & np.isfinite(truth).all(axis=1)
    mapped, truth = mapped[known], truth[known]
    if len(mapped) < _FEWEST:
        return None
    rng, best, chosen = np.random.default_rng(0), np.inf, None
    for _ in range(_TRIALS):
        pair = rng.choice(len(mapped), 2, replace=False)
        # Two points close to each other tell no direction.
        if min(float(np.linalg.norm(np.diff(one[pair], axis=0))) for one in (mapped, truth)) < _SPREAD_M:
            continue
        apart = np.linalg.norm(fit_rigid(mapped[pair], truth[pair], source).out_of_map(mapped) - truth, axis=1)
        if (median := float(np.median(apart))) < best:
            best, chosen = median, apart
    if chosen is None:
        return None
    closer = chosen <= best
    return fit_rigid(mapped[closer], truth[closer], source)
