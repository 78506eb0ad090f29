"""How alike the frames of two drives are, freed of what light and season do to all of them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from andante.errors import ArrayError

FeatureArray = NDArray[np.float32]

_FLOOR = 1e-6


def checked_features(features: ArrayLike, name: str) -> FeatureArray:
    """Features (n, d) in float32, finite, of at least three frames."""
    values = np.asarray(features, dtype=np.float32)
    if values.ndim != 2 or len(values) < 3 or values.shape[1] == 0:
        raise ArrayError(
            f"{name} has to be one feature vector for each of at least 3 frames (n, d), got {values.shape}"
        )
    if not np.isfinite(values).all():
        bad = int((~np.isfinite(values).all(axis=1)).sum())
        raise ArrayError(f"{name} holds NaN or infinity in {bad} of {len(values)} frames; leave these frames out")
    return values


def centred_cosine(query: FeatureArray, reference: FeatureArray) -> FeatureArray:
    """Cosines (n, m) between features (n, d) and (m, d), each less the mean of its own drive.

    The mean of a drive is what its light and season add to all frames.
    """
    if query.shape[1] != reference.shape[1]:
        raise ArrayError(
            f"features of two drives have to be equally long, got {query.shape[1]} and {reference.shape[1]}; "
            f"use one encoder for all"
        )
    return np.asarray(_directions(query) @ _directions(reference).T, np.float32)


def contrasted(likeness: FeatureArray) -> FeatureArray:
    """Likeness (n, m) in deviations above the medians of its row and its column.

    SeqSLAM's contrast enhancement (Milford and Wyeth 2012) over whole rows and columns: a frame that looks like
    everything says nothing.
    """
    row, column = np.median(likeness, axis=1, keepdims=True), np.median(likeness, axis=0, keepdims=True)
    excess = likeness - row - column + np.median(likeness)
    spread = np.sqrt(excess.std(axis=1, keepdims=True) * excess.std(axis=0, keepdims=True))
    return np.asarray(excess / np.maximum(spread, _FLOOR), np.float32)


def _directions(features: FeatureArray) -> FeatureArray:
    centred = features - features.mean(axis=0)
    length = np.linalg.norm(centred, axis=1, keepdims=True)
    return np.asarray(centred / np.maximum(length, _FLOOR), np.float32)
