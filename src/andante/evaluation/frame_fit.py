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
    rng = np.random.default_rng(0)
    pairs = np.array([rng.choice(len(mapped), 2, replace=False) for _ in range(_TRIALS)])
    a, b = mapped @ (1, 1j), truth @ (1, 1j)
    turned, meant = np.diff(a[pairs])[:, 0], np.diff(b[pairs])[:, 0]
    # Two points close to each other tell no direction.
    telling = np.minimum(np.abs(turned), np.abs(meant)) > _SPREAD_M
    if not telling.any():
        return None
    turns = np.exp(1j * np.angle(meant[telling] / turned[telling]))
    shifts = b[pairs[telling]].mean(axis=1) - turns * a[pairs[telling]].mean(axis=1)
    medians = [np.median(np.abs(turn * a + shift - b)) for turn, shift in zip(turns, shifts, strict=True)]
    best = int(np.argmin(medians))
    closer = np.abs(turns[best] * a + shifts[best] - b) <= medians[best]
    return fit_rigid(mapped[closer], truth[closer], source)
