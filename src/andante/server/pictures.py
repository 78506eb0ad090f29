"""Frames of a recording as JPEG, by index and direction; never by name or path."""

from __future__ import annotations

from collections import OrderedDict
from threading import Lock

import cv2

from andante.data import ImageArray
from andante.errors import InputError
from andante.landmarks.surroundings import Surroundings
from andante.landmarks.windows import window

_KEPT = 32  # panoramas: enough for all that a page shows at once, 90 MB of the largest ones
_QUALITY = 88


class Pictures:
    """Unwraps frames when they are asked for and keeps the last ones; safe to ask from many threads."""

    def __init__(self, surroundings: Surroundings, frames: int) -> None:
        self._surroundings, self._frames = surroundings, frames
        self._panoramas: OrderedDict[int, ImageArray] = OrderedDict()
        self._lock = Lock()

    def jpeg(self, index: int, azimuth_rad: float, width_rad: float, height_px: int | None) -> bytes:
        """JPEG of the part of a panorama around an azimuth, at most ``height_px`` high.

        Raises ``InputError`` for a frame that does not exist, ``ImageError`` for one that cannot be read.
        """
        view = window(self._panorama(index), azimuth_rad, width_rad)
        if height_px is not None and height_px < view.shape[0]:
            width = max(1, round(view.shape[1] * height_px / view.shape[0]))
            view = cv2.resize(view, (width, height_px), interpolation=cv2.INTER_AREA)  # type: ignore[assignment]
        _, data = cv2.imencode(".jpg", view, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
        return data.tobytes()

    def _panorama(self, index: int) -> ImageArray:
        if not 0 <= index < self._frames:
            raise InputError(f"frame {index} does not exist; this recording has frames 0 to {self._frames - 1}")
        with self._lock:
            kept = self._panoramas.get(index)
            if kept is not None:
                self._panoramas.move_to_end(index)
                return kept
        made = self._surroundings(index)
        with self._lock:
            self._panoramas[index] = made
            while len(self._panoramas) > _KEPT:
                self._panoramas.popitem(last=False)
        return made
