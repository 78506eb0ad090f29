"""Overlapping perspective cuts of a panorama, because detectors have learnt from pictures that people take.

Every cut is a pinhole camera that is held level, with its lens shifted upwards as architects do: what stands upright
stands upright in the cut, and nothing is wasted on ground that the camera does not see. A pixel (x, y) of the cut that
looks along azimuth a sees

    azimuth a - atan((x - c) / f),   elevation atan((t - y) / f cos(azimuth - a)),

x to the right, y down, pixel edges at whole numbers, c the middle of the cut and t the row of the horizon.
"""

from __future__ import annotations

import cv2
import numpy as np

from andante.camera import PanoramaGeometry
from andante.data import FloatArray, ImageArray
from andante.errors import ConfigError, ImageError
from andante.landmarks.boxes import Box

FILL = 114
"""Grey where a cut shows what the panorama does not: the level that YOLOX pads pictures with."""
_LOWEST_DEG = -35.0

Pixels = tuple[float, float, float, float]
"""Left, top, right, bottom in a cut."""


class Cuts:
    """Turns panoramas (H, W, 3) of one geometry into ``count`` square cuts of ``size_px``, ``wide_deg`` wide each.

    Cut k looks along azimuth 2 pi k / count. All begin at the lower edge of the panorama, at most 35 degrees below the
    horizon. Holds no state between calls. Raises ``ConfigError`` for cuts that leave gaps, and for a panorama that ends
    below where the cuts begin.
    """

    def __init__(
        self, geometry: PanoramaGeometry, *, count: int = 8, wide_deg: float = 90.0, size_px: int = 416
    ) -> None:
        if count < 1 or not 360.0 / count <= wide_deg <= 150.0:
            raise ConfigError(
                f"{count} cuts of {wide_deg:g} degrees leave gaps or are no pictures; take cuts of at most 150 "
                "degrees, as many as it takes to go around"
            )
        self.geometry, self.count, self.size_px = geometry, count, size_px
        self.focal_px = size_px / 2.0 / float(np.tan(np.radians(wide_deg) / 2.0))
        self.lowest_rad = float(np.radians(max(geometry.min_deg, _LOWEST_DEG)))
        self.horizon_px = size_px + self.focal_px * float(np.tan(self.lowest_rad))
        beside, elevation = self._rays()
        highest, span = np.radians([geometry.max_deg, geometry.max_deg - geometry.min_deg])
        self._rows = ((highest - elevation) / span * geometry.height_px - 0.5).astype(np.float32)
        self._columns = (np.pi - beside) / (2.0 * np.pi) * geometry.width_px - 0.5
        self._outside = (self._rows < -0.5) | (self._rows > geometry.height_px - 0.5)
        if self._outside.all():
            raise ConfigError(
                f"a panorama from {geometry.min_deg:g} to {geometry.max_deg:g} degrees of elevation shows nothing of "
                f"what stands around; take one that reaches above {_LOWEST_DEG:g} degrees"
            )

    def __call__(self, panorama: ImageArray) -> list[ImageArray]:
        """BGR panorama (H, W, 3) -> cuts (size, size, 3); raises ``ImageError`` for one of another size."""
        shape = self.geometry.height_px, self.geometry.width_px, 3
        if panorama.shape != shape:
            raise ImageError(f"cuts of this geometry need a BGR panorama of shape {shape}, got {panorama.shape}")
        return [self._cut(panorama, number) for number in range(self.count)]

    def azimuth_rad(self, number: int) -> float:
        """Where cut ``number`` looks."""
        return 2.0 * np.pi * number / self.count

    def box(self, number: int, pixels: Pixels) -> Box:
        """What a rectangle of a cut covers of the horizon circle; elevations are those of the middle of its edges."""
        left, top, right, bottom = pixels
        half = self.size_px / 2.0
        beside = np.arctan2([half - left, half - right], self.focal_px)
        closer = np.cos(beside.mean())
        high, low = np.arctan((self.horizon_px - np.array([top, bottom])) / self.focal_px * closer)
        azimuth = self.azimuth_rad(number)
        return Box.between(azimuth + beside[0], azimuth + beside[1], float(low), float(high))

    def pixels(self, number: int, box: Box) -> Pixels | None:
        """The inverse of ``box``: where a box lies in a cut, ``None`` where it is not wholly in front of it."""
        turn = float(np.remainder(box.azimuth_rad - self.azimuth_rad(number) + np.pi, 2.0 * np.pi) - np.pi)
        if abs(turn) + box.width_rad / 2.0 >= np.pi / 2.0:
            return None
        beside = turn + np.array([0.5, -0.5]) * box.width_rad
        left, right = self.size_px / 2.0 - self.focal_px * np.tan(beside)
        tangents = np.tan([box.high_rad, box.low_rad]) / np.cos(turn)
        top, bottom = self.horizon_px - self.focal_px * tangents
        return float(left), float(top), float(right), float(bottom)

    def _rays(self) -> tuple[FloatArray, FloatArray]:
        """Azimuth beside that of the cut (size,), elevation (size, size) of all pixels."""
        pixel = np.arange(self.size_px) + 0.5
        beside = np.arctan2(self.size_px / 2.0 - pixel, self.focal_px)[None, :]
        elevation = np.arctan((self.horizon_px - pixel)[:, None] / self.focal_px * np.cos(beside))
        return beside, elevation

    def _cut(self, panorama: ImageArray, number: int) -> ImageArray:
        columns = self._columns - number / self.count * self.geometry.width_px
        table = np.broadcast_to(columns, self._rows.shape).astype(np.float32)
        cut = cv2.remap(panorama, table, self._rows, cv2.INTER_LINEAR, borderMode=cv2.BORDER_WRAP)
        cut[self._outside] = FILL
        return np.asarray(cut, np.uint8)
