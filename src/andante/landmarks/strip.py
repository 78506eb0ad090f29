"""The panorama as people look at it: in colour, large, with the same scale both ways."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from andante.camera import PanoramaGeometry, Unwrapper, with_found_circle
from andante.data import CameraSpec, ImageArray
from andante.errors import ConfigError
from andante.landmarks.boxes import Box
from andante.protocols import Recording

_LOWEST_DEG, _HIGHEST_DEG = -30.0, 70.0
_WIDEST_PX = 2880
_CIRCLE_IMAGES = 7


@dataclass(frozen=True, slots=True)
class Strip:
    """Unwraps the pictures of one camera and knows where boxes lie in what comes out.

    Panoramas are (height_px, width_px[, 3]), ``px_per_rad`` along both axes; row 0 looks at ``max_rad``, the middle
    column forward.
    """

    unwrapper: Unwrapper
    width_px: int
    height_px: int
    min_rad: float
    max_rad: float

    @classmethod
    def of(cls, camera: CameraSpec, image_shape: tuple[int, ...]) -> Strip:
        """Of a camera and the shape of its pictures, as finely as the camera sees.

        A fisheye is unwrapped from -30 (or where it begins to see) to 70 degrees of elevation. A panorama is taken
        as it is: square pixels, the horizon in the middle row. Raises ``ConfigError`` for a camera that does not look
        all around.
        """
        if not camera.heading_invariant:
            raise ConfigError(
                "landmarks are taught in pictures that show all directions; this camera is of model "
                f"{camera.model!r} with {camera.horizontal_field_of_view_deg:g} degrees; use a fisheye or a 360 degree "
                "panorama"
            )
        if camera.model == "panorama":
            unwrapper = Unwrapper(camera, image_shape)
            height, width = unwrapper.shape
            half = np.pi * height / width
            return cls(unwrapper, width, height, -half, half)
        geometry = _fisheye_geometry(camera)
        unwrapper = Unwrapper(camera, image_shape, geometry)
        low, high = np.radians([geometry.min_deg, geometry.max_deg]).tolist()
        return cls(unwrapper, geometry.width_px, geometry.height_px, low, high)

    @property
    def px_per_rad(self) -> float:
        """The scale."""
        return self.width_px / (2.0 * np.pi)

    def panorama(self, image: ImageArray) -> ImageArray:
        """A picture, unwrapped."""
        return self.unwrapper(image)

    def window(self, panorama: ImageArray, azimuth_rad: float, width_rad: float) -> ImageArray:
        """The part of a panorama around an azimuth, at full height, also across the seam."""
        width = int(np.clip(round(width_rad * self.px_per_rad), 1, self.width_px))
        middle = (np.pi - azimuth_rad) * self.px_per_rad
        columns = np.arange(width) + round(middle - width / 2.0)
        return np.take(panorama, np.mod(columns, self.width_px), axis=1)

    def visible_share(self, box: Box) -> float:
        """Which share of a box, from 0 to 1, lies between the lowest and the highest row."""
        clipped = self.clipped(box)
        return 0.0 if clipped is None else clipped.height_rad / box.height_rad

    def clipped(self, box: Box) -> Box | None:
        """The part of a box between the lowest and the highest row, ``None`` where there is no such part."""
        half = box.height_rad / 2.0
        low, high = max(box.elevation_rad - half, self.min_rad), min(box.elevation_rad + half, self.max_rad)
        if low >= high:
            return None
        return Box(box.azimuth_rad, (low + high) / 2.0, box.width_rad, high - low)


def strip_of(recording: Recording) -> Strip:
    """The strip of a recording, whose image circle is looked for in a few pictures where it is not declared.

    Raises ``ConfigError`` as ``Strip.of`` does, ``RecordingError`` and ``ImageError`` for pictures that cannot be used.
    """
    infos = recording.infos
    chosen = sorted({int(at) for at in np.linspace(0, len(infos) - 1, _CIRCLE_IMAGES)})
    camera = recording.camera
    complete = camera.model != "fisheye" or (camera.centre_px is not None and camera.radius_px is not None)
    images = [recording.load(infos[at]) for at in (chosen[:1] if complete else chosen)]
    return Strip.of(camera if complete else with_found_circle(camera, images), images[0].shape)


def _fisheye_geometry(camera: CameraSpec) -> PanoramaGeometry:
    """The range of elevations that the camera sees, at the scale of the picture where it is finest, on its rim."""
    half = camera.field_of_view_deg / 2.0
    low, high = (90.0 - half, 90.0) if camera.facing == "up" else (-90.0, half - 90.0)
    low, high = max(low, _LOWEST_DEG), min(high, _HIGHEST_DEG)
    if low >= high:
        raise ConfigError(
            f"the camera sees nothing between {_LOWEST_DEG:g} and {_HIGHEST_DEG:g} degrees of elevation, with "
            f"{camera.field_of_view_deg:g} degrees facing {camera.facing}; landmarks are taught there"
        )
    rim = camera.radius_px or _WIDEST_PX
    width = int(min(2.0 * np.pi * rim, _WIDEST_PX))
    return PanoramaGeometry(width, max(1, round(width * (high - low) / 360.0)), low, high)
