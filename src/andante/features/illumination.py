"""What makes a panorama look alike in another light: local means, deviations and orientations.

Everything works on a stack of pictures at once: pictures are small, and a hundred calls for one picture cost more than
their arithmetic.
"""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

Float32Array = NDArray[np.float32]


def window_px(shape: tuple[int, int], window_share: tuple[float, float]) -> tuple[int, int]:
    """The nearest odd window (width, height), at least 3 px, for its share of a (height, width) panorama."""
    height, width = shape
    share_x, share_y = window_share
    return 2 * max(1, round((share_x * width - 1) / 2)) + 1, 2 * max(1, round((share_y * height - 1) / 2)) + 1


@dataclass(frozen=True)
class Surroundings:
    """Pictures with what lies around them, so that windows at their rim see something sensible.

    ``tall`` holds n pictures of (height, width), each with its margin, one below the other. The azimuth of a
    panorama wraps around; elevation, and both axes of a perspective picture, are mirrored.
    """

    tall: Float32Array
    shape: tuple[int, int, int]
    margin: tuple[int, int]
    window: tuple[int, int]

    @classmethod
    def of(cls, pictures: Float32Array, window: tuple[int, int], *, wrap: bool) -> Surroundings:
        """Of grey pictures (n, height, width), for windows (width, height) and their neighbours."""
        n, height, width = pictures.shape
        mx, my = min(window[0] // 2 + 1, width), min(window[1] // 2 + 1, height)
        tall = np.empty((n, height + 2 * my, width + 2 * mx), dtype=np.float32)
        middle = tall[:, my : my + height]
        middle[:, :, mx : mx + width] = pictures
        middle[:, :, :mx] = pictures[:, :, -mx:] if wrap else pictures[:, :, :mx][:, :, ::-1]
        middle[:, :, mx + width :] = pictures[:, :, :mx] if wrap else pictures[:, :, -mx:][:, :, ::-1]
        tall[:, :my] = middle[:, :my][:, ::-1]
        tall[:, my + height :] = middle[:, -my:][:, ::-1]
        return cls(tall.reshape(-1, width + 2 * mx), (n, height, width), (mx, my), window)

    def cropped(self, tall: Float32Array) -> Float32Array:
        """Without margins: (n, height, width)."""
        n, height, width = self.shape
        mx, my = self.margin
        return tall.reshape(n, height + 2 * my, width + 2 * mx)[:, my : my + height, mx : mx + width]

    def mean(self, tall: Float32Array) -> Float32Array:
        """Mean over the window around every pixel."""
        return _float32(cv2.blur(tall, self.window))


def patch_normalised(around: Surroundings, deviation_floor: float) -> Float32Array:
    """Subtract the local mean and divide by the local deviation: (n, height, width).

    ``deviation_floor``, in grey levels, keeps noise and faint clouds from being blown up to the size of
    real edges: variance + floor² stands below the root. Thesis 5.1.1 normalises patches in its first layer.
    """
    tall = around.tall
    mean = around.mean(tall)
    # In place from here on: fresh arrays of this size cost more than the arithmetic.
    deviation = around.mean(tall * tall)
    deviation -= mean * mean
    np.maximum(deviation, 0, out=deviation)
    deviation += np.float32(deviation_floor**2)
    np.sqrt(deviation, out=deviation)
    np.subtract(tall, mean, out=mean)
    mean /= deviation
    return around.cropped(mean)


def orientation_channels(around: Surroundings, count: int, gradient_floor: float) -> Float32Array:
    """(n, count, height, width): strength of the gradient along ``count`` directions in [0°, 180°).

    Gradients are divided by their local root mean square plus ``gradient_floor`` (grey levels a pixel), and
    made positive: an edge between tree and sky counts the same before a dark and before a burnt-out sky.
    """
    along_x, along_y = (_float32(cv2.Sobel(around.tall, cv2.CV_32F, dx, 1 - dx, ksize=1, scale=0.5)) for dx in (1, 0))
    energy = along_x * along_x
    energy += along_y * along_y
    scale = around.mean(energy)
    np.sqrt(np.maximum(scale, 0, out=scale), out=scale)
    scale += np.float32(gradient_floor)
    along_x /= scale
    along_y /= scale
    n, height, width = around.shape
    channels = np.empty((n, count, height, width), dtype=np.float32)
    for channel, angle in enumerate(np.pi * np.arange(count) / count):
        np.abs(around.cropped(_along(along_x, along_y, angle)), out=channels[:, channel])
    return channels


def _along(x: Float32Array, y: Float32Array, angle: float) -> Float32Array:
    """The component of a gradient along a direction; along the axes there is nothing to work out."""
    if angle == 0:
        return x
    if angle == np.pi / 2:
        return y
    return np.float32(np.cos(angle)) * x + np.float32(np.sin(angle)) * y


def _float32(image: object) -> Float32Array:
    return np.asarray(image, dtype=np.float32)
