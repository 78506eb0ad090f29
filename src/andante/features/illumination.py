"""What makes a panorama look alike in another light: local means, deviations and orientations."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.errors import ConfigError

Float32Array = NDArray[np.float32]


def window_px(shape: tuple[int, int], window_share: tuple[float, float]) -> tuple[int, int]:
    """An odd window (width, height) of at least 3 px from its share of a (height, width) panorama."""
    height, width = shape
    share_x, share_y = window_share
    return 2 * max(1, round(share_x * width / 2)) + 1, 2 * max(1, round(share_y * height / 2)) + 1


def box_mean(image: Float32Array, window: tuple[int, int], *, wrap: bool) -> Float32Array:
    """Local mean of (height, width) over an odd window (width, height).

    The azimuth wraps around in a panorama (``wrap``); elevation, and both axes of a perspective image,
    are mirrored at the border.
    """
    if not wrap:
        return np.asarray(cv2.blur(image, window, borderType=cv2.BORDER_REFLECT), dtype=np.float32)
    margin = window[0] // 2
    padded = np.concatenate([image[:, -margin:], image, image[:, :margin]], axis=1)
    return np.asarray(cv2.blur(padded, window, borderType=cv2.BORDER_REFLECT)[:, margin:-margin], dtype=np.float32)


def patch_normalised(
    image: Float32Array, window: tuple[int, int], deviation_floor: float, *, wrap: bool
) -> Float32Array:
    """Subtract the local mean and divide by the local deviation.

    ``deviation_floor``, in grey levels, keeps noise and faint clouds from being blown up to the size of
    real edges: variance + floor² stands below the root. Thesis 5.1.1 normalises patches in its first layer.
    """
    mean = box_mean(image, window, wrap=wrap)
    variance = box_mean(image * image, window, wrap=wrap) - mean * mean
    return (image - mean) / np.sqrt(np.maximum(variance, 0) + np.float32(deviation_floor**2))


def orientation_channels(
    image: Float32Array, count: int, window: tuple[int, int], gradient_floor: float, *, wrap: bool
) -> Float32Array:
    """(count, height, width): strength of the gradient along ``count`` directions in [0°, 180°).

    Gradients are divided by their local root mean square plus ``gradient_floor`` (grey levels a pixel), and
    made positive: an edge between tree and sky counts the same before a dark and before a burnt-out sky.
    """
    padded = np.concatenate([image[:, -1:], image, image[:, :1]], axis=1) if wrap else np.pad(image, ((0, 0), (1, 1)), "edge")
    along_x = (padded[:, 2:] - padded[:, :-2]) / 2
    along_y = np.gradient(image, axis=0)
    energy = box_mean(along_x * along_x + along_y * along_y, window, wrap=wrap)
    scale = 1 / (np.sqrt(np.maximum(energy, 0)) + np.float32(gradient_floor))
    angles = np.pi * np.arange(count) / count
    channels = [np.abs(np.cos(a) * along_x + np.sin(a) * along_y) * scale for a in angles]
    return np.asarray(channels, dtype=np.float32)


def as_grey(image: NDArray[np.uint8]) -> Float32Array:
    """Grey float32 (height, width) of a grey or BGR uint8 picture."""
    if image.ndim == 3 and image.shape[2] == 3:
        image = np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
    if image.ndim != 2:
        raise ConfigError(f"a panorama is (height, width) or (height, width, 3), got shape {image.shape}")
    return image.astype(np.float32)
