"""Stacks of panoramas in, rows of features out."""

from __future__ import annotations

import numpy as np

from andante.data import ImageArray
from andante.errors import ConfigError
from andante.features.illumination import Float32Array


def as_stack(panoramas: ImageArray, shape: tuple[int, int]) -> Float32Array:
    """Grey (height, width) or (n, height, width) uint8 -> float32 (n, height, width); ``ConfigError`` otherwise."""
    if (
        panoramas.ndim not in (2, 3)
        or panoramas.shape[-2:] != shape
        or panoramas.dtype != np.uint8
        or not len(panoramas)
    ):
        raise ConfigError(
            f"this encoder takes grey uint8 panoramas ({shape[0]}, {shape[1]}), one or a stack of them, got "
            f"{panoramas.dtype} of shape {panoramas.shape}; make them with the camera that it was made for"
        )
    return np.asarray(panoramas.reshape(-1, *shape), dtype=np.float32)


def unit_length(rows: Float32Array) -> Float32Array:
    """Every row (n, d) at Euclidean length one; a row of zeros stays as it is."""
    length = np.linalg.norm(rows, axis=1, keepdims=True)
    return np.asarray(rows / np.where(length > 0, length, 1), dtype=np.float32)
