"""What a camera sees of one object, in angles around the robot: the truth for detectors and trackers."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.errors import ConfigError
from andante.simulator.camera import SimulatedCamera, pixel_rays
from andante.simulator.recording import SimulatedRecording


@dataclass(frozen=True, slots=True)
class Extent:
    """The box around all that is seen of an object, in radians, and of how many ``pixels`` of the picture.

    Azimuth (-pi, pi] is counter-clockwise from the robot's forward; azimuth and elevation are of the middle. A part
    that something else hides, or that lies below the horizon of an up-facing lens, is not in it.
    """

    azimuth_rad: float
    elevation_rad: float
    width_rad: float
    height_rad: float
    pixels: int

    @property
    def box(self) -> tuple[float, float, float, float]:
        """Azimuth, elevation, width, height, as ``andante.landmarks.boxes.Box`` takes them."""
        return self.azimuth_rad, self.elevation_rad, self.width_rad, self.height_rad


class ExtentFinder:
    """Finds objects in pictures of object ids (height, width) of one camera."""

    def __init__(self, camera: SimulatedCamera) -> None:
        directions = pixel_rays(camera).directions.astype(np.float64)
        self._azimuth = np.arctan2(directions[..., 1], directions[..., 0])
        self._elevation = np.arcsin(np.clip(directions[..., 2], -1.0, 1.0))

    def __call__(self, object_id: NDArray[np.int32], number: int, min_pixels: int = 8) -> Extent | None:
        """The extent of object ``number``; ``None`` where fewer than ``min_pixels`` of it are seen."""
        seen = object_id == number
        pixels = int(np.count_nonzero(seen))
        if pixels < max(min_pixels, 1):
            return None
        middle, width = _arc(self._azimuth[seen])
        low, high = float(self._elevation[seen].min()), float(self._elevation[seen].max())
        return Extent(middle, (low + high) / 2.0, width, high - low, pixels)


def object_extent(recording: SimulatedRecording, index: int, name: str, *, min_pixels: int = 8) -> Extent | None:
    """What frame ``index`` shows of the object ``name``, as ``bicycle1``; ``None`` where that is next to nothing.

    Renders the frame. Whoever asks for many objects of a frame takes an ``ExtentFinder``. Raises ``ConfigError`` for an
    unknown name.
    """
    number = object_number(recording, name)
    return ExtentFinder(recording.plan.camera)(recording.rendering(index).object_id, number, min_pixels)


def object_number(recording: SimulatedRecording, name: str) -> int:
    """The id of an object in ``Rendering.object_id``; raises ``ConfigError`` for an unknown name."""
    names = recording.renderer.scene.names
    if name not in names:
        kind = name.rstrip("0123456789")
        like = [other for other in names if other.startswith(kind)] or names
        raise ConfigError(f"there is no object {name!r} in {recording.name!r}; it has {', '.join(like)}")
    return names.index(name)


def _arc(azimuth: FloatArray) -> tuple[float, float]:
    """Middle and width of the shortest arc that holds all azimuths (k,): all but the widest gap."""
    ordered = np.unique(azimuth)
    gaps = np.diff(ordered, append=ordered[0] + 2.0 * np.pi)
    widest = int(np.argmax(gaps))
    start = ordered[(widest + 1) % len(ordered)]
    width = float(2.0 * np.pi - gaps[widest])
    middle = float(np.angle(np.exp(1j * (start + width / 2.0))))
    return middle, width
