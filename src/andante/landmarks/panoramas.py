"""Pictures of any camera as the panorama of one size that a landmark detector looks at."""

from __future__ import annotations

import cv2
import numpy as np

from andante.camera import PanoramaGeometry, Unwrapper
from andante.data import CameraSpec, ImageArray
from andante.errors import ConfigError


class PanoramaMaker:
    """Grey (h, w) or BGR (h, w, 3) uint8 of one camera and size -> BGR panorama of exactly ``geometry``'s size.

    Rows that a fisheye does not see repeat the nearest one that it does. A panorama camera declares no elevations: its
    whole height is stretched to the geometry's, so that elevations mean the same in all its pictures.
    Raises ``ConfigError`` for cameras that do not see all around, and as ``Unwrapper`` does.
    """

    def __init__(self, camera: CameraSpec, image_shape: tuple[int, ...], geometry: PanoramaGeometry) -> None:
        if not camera.heading_invariant:
            wide = f" of {camera.horizontal_field_of_view_deg:g} degrees" if camera.model == "panorama" else ""
            raise ConfigError(
                f"landmarks are looked for all around the horizon; a {camera.model} camera{wide} does not see it; use "
                "a fisheye or a panorama"
            )
        self.geometry = geometry
        self._unwrapper = Unwrapper(camera, image_shape, geometry if camera.model == "fisheye" else None)

    def __call__(self, image: ImageArray) -> ImageArray:
        """Raises ``ImageError`` for another size or type."""
        panorama = self._unwrapper(image)
        size = self.geometry.width_px, self.geometry.height_px
        if panorama.shape[:2] != size[::-1]:
            shrinks = panorama.shape[0] >= size[1] and panorama.shape[1] >= size[0]
            panorama = np.asarray(
                cv2.resize(panorama, size, interpolation=cv2.INTER_AREA if shrinks else cv2.INTER_LINEAR), np.uint8
            )
        return panorama if panorama.ndim == 3 else np.asarray(cv2.cvtColor(panorama, cv2.COLOR_GRAY2BGR), np.uint8)
