"""Pictures of an up-facing camera a part of whose horizon is hidden."""

from __future__ import annotations

from collections.abc import Callable

import cv2
import numpy as np

from andante.camera import rays
from andante.data import CameraSpec, FloatArray, ImageArray
from andante.errors import ConfigError

Cover = Callable[[np.random.Generator, tuple[int, int]], FloatArray]
"""What hides the view, as grey levels (height, width) of a whole picture."""


def board(rng: np.random.Generator, shape: tuple[int, int]) -> FloatArray:
    """A grey surface, close by: nothing but the noise of the sensor."""
    return rng.uniform(50, 180) + rng.normal(0, 6, shape)


def foliage(rng: np.random.Generator, shape: tuple[int, int]) -> FloatArray:
    """A hedge, close by: spots of some size with strong edges between them."""
    spots = cv2.GaussianBlur(rng.normal(0, 1, shape), (0, 0), shape[1] / 160)
    return np.asarray(rng.uniform(70, 140) + 50 * spots / spots.std(), dtype=np.float64)


COVERS: dict[str, Cover] = {"board": board, "hedge": foliage}


def hidden_sector(
    image: ImageArray,
    camera: CameraSpec,
    share: float,
    start_rad: float,
    *,
    rng: np.random.Generator,
    cover: Cover | ImageArray,
) -> ImageArray:
    """A grey picture (height, width), a ``share`` of whose azimuths, counter-clockwise from a first, a cover hides.

    The cover may be another picture of the same size: then other things, of another place, stand before the horizon.
    Raises ``ConfigError`` for a share outside of 0 to 1, or a cover of another size.
    """
    if not 0 <= share <= 1:
        raise ConfigError(f"the hidden share of the horizon is from 0 to 1, got {share:g}")
    azimuth, _, valid = rays(camera, image.shape)
    hidden = valid & (np.mod(azimuth - start_rad, 2 * np.pi) < 2 * np.pi * share)
    over = cover if isinstance(cover, np.ndarray) else cover(rng, (image.shape[0], image.shape[1]))
    if over.shape != image.shape:
        raise ConfigError(f"a cover of shape {over.shape} does not fit a picture of shape {image.shape}")
    return np.where(hidden, np.clip(np.round(over), 0, 255), image).astype(np.uint8)
