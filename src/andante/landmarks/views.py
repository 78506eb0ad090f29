"""Cuts the view of a landmark out of an image: a small picture that is centred on it, however the robot is turned.

The thesis (7.3.1) cuts a box of the size of the largest box of its landmark around the middle of the detected one,
120 x 120 px. A window that hangs on the horizon instead is the package's own choice: the robot stays on the ground, so
the horizon is where it was, and how far the landmark rises above it says how far it is away. What a detector gets wrong
about the height of a box then changes nothing.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import cv2
import numpy as np

from andante.camera import project, scaled
from andante.camera.rays import project_held
from andante.data import CameraSpec, FloatArray, ImageArray
from andante.errors import ConfigError, ImageError
from andante.landmarks.boxes import Box

THESIS_PX = 120
_RIM_MARGIN_PX = 1.0
_COARSE = 2.0
"""Pixels of the image to one of the view from which on the image is halved first."""


@dataclass(frozen=True, slots=True)
class ViewWindow:
    """What is cut out: ``width_rad`` of azimuth around the middle of a box, rows from ``high_rad`` down to ``low_rad``.

    Elevations count from the horizon, or with ``follows_elevation`` from the middle of the box. Views have
    ``width_px`` columns, counter-clockwise to the left, and ``height_px`` rows. Raises ``ConfigError`` for a window
    that holds nothing.
    """

    width_rad: float
    low_rad: float
    high_rad: float
    width_px: int
    height_px: int
    follows_elevation: bool = False

    def __post_init__(self) -> None:
        if not 0.0 < self.width_rad <= 2.0 * np.pi or not self.low_rad < self.high_rad:
            raise ConfigError(
                "a window needs a width_rad above 0 and up to 2 pi, and low_rad below high_rad, "
                f"got {self.width_rad:g}, {self.low_rad:g} and {self.high_rad:g}"
            )
        if min(self.width_px, self.height_px) < 4:
            raise ConfigError(f"a view needs at least 4 x 4 px, got {self.width_px} x {self.height_px}")

    @property
    def shape(self) -> tuple[int, int]:
        """Rows and columns of a view."""
        return self.height_px, self.width_px

    def rays(self, box: Box) -> tuple[FloatArray, FloatArray]:
        """Azimuth (1, width_px) and elevation (height_px, 1) of all pixels of the view of a box, in radians."""
        left = 0.5 - (np.arange(self.width_px) + 0.5) / self.width_px
        down = (np.arange(self.height_px) + 0.5) / self.height_px
        foot = box.elevation_rad if self.follows_elevation else 0.0
        elevation = foot + self.high_rad - (self.high_rad - self.low_rad) * down
        return (box.azimuth_rad + self.width_rad * left)[None, :], elevation[:, None]


def largest_window(boxes: Iterable[Box], side_px: int = THESIS_PX) -> ViewWindow:
    """The thesis' window: as large as the largest box of a landmark, around the middle of each (7.3.1).

    Raises ``ConfigError`` where there is no box.
    """
    sizes = np.array([(box.width_rad, box.height_rad) for box in boxes]).reshape(-1, 2)
    if not len(sizes):
        raise ConfigError("there is no box to take the largest size of; detect the landmark in some images first")
    width, height = sizes.max(axis=0).tolist()
    return ViewWindow(min(width, 2 * np.pi), -height / 2, height / 2, side_px, side_px, follows_elevation=True)


class ViewCutter:
    """Cuts views out of images of one fisheye camera by one look-up each; holds no state between calls.

    ``image_shape`` (height, width) is that of the images, ``scale`` image pixels per pixel of ``camera``. What the
    camera does not see takes the colour of the nearest pixel that it does, as in panoramas. Raises ``ConfigError`` for
    a camera that is no fisheye.
    """

    def __init__(self, camera: CameraSpec, image_shape: tuple[int, int], *, scale: float = 1.0) -> None:
        if camera.model != "fisheye":
            raise ConfigError(
                f"views of landmarks are cut out of fisheye images, this camera is a {camera.model}; "
                "record with a fisheye or leave landmarks out"
            )
        self.image_shape = (image_shape[0], image_shape[1])
        self._camera = scaled(camera, scale)
        project(self._camera, 0.0, 0.5)  # an incomplete camera is told now, not at the first image

    def __call__(self, image: ImageArray, box: Box, window: ViewWindow) -> ImageArray:
        """Grey (height, width) or BGR (height, width, 3) uint8 -> grey view (height_px, width_px) uint8.

        Raises ``ImageError`` for an image of another size.
        """
        if image.shape[:2] != self.image_shape or image.dtype != np.uint8:
            height, width = self.image_shape
            raise ImageError(
                f"cannot cut a view out of an image of shape {image.shape} and type {image.dtype}; this camera takes "
                f"({height}, {width}) or ({height}, {width}, 3) uint8"
            )
        x_px, y_px, _ = project_held(self._camera, *window.rays(box), _RIM_MARGIN_PX)
        x_px, y_px = np.broadcast_arrays(x_px, y_px)
        part, left, top = _surroundings(image, x_px, y_px)
        if part.ndim == 3:
            part = np.asarray(cv2.cvtColor(part, cv2.COLOR_BGR2GRAY), np.uint8)
        x_px, y_px = x_px - left, y_px - top
        pitch = float(np.median(np.hypot(np.diff(x_px, axis=1), np.diff(y_px, axis=1))))
        if pitch > _COARSE:
            part = np.asarray(cv2.GaussianBlur(part, (0, 0), 0.4 * pitch), np.uint8)
        view = cv2.remap(
            part, x_px.astype(np.float32), y_px.astype(np.float32), cv2.INTER_LINEAR, None, cv2.BORDER_REPLICATE
        )
        return np.asarray(view, np.uint8)


def _surroundings(image: ImageArray, x_px: FloatArray, y_px: FloatArray) -> tuple[ImageArray, int, int]:
    """The part of an image that holds all these positions, and where it begins."""
    height, width = image.shape[:2]
    left, top = max(int(x_px.min()) - 4, 0), max(int(y_px.min()) - 4, 0)
    right, bottom = min(int(x_px.max()) + 6, width), min(int(y_px.max()) + 6, height)
    left, top = min(left, width - 1), min(top, height - 1)
    return image[top : max(bottom, top + 1), left : max(right, left + 1)], left, top
