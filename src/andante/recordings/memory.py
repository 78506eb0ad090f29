"""A recording that was never on a disk: for tests, notebooks and pictures made on the fly."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

import cv2
import numpy as np

from andante.data import CameraSpec, Frame, FrameInfo, ImageArray, Pose2D
from andante.errors import RecordingError
from andante.protocols import SkipCallback
from andante.recordings.content import hash_content
from andante.recordings.decode import is_picture
from andante.recordings.frames import iterate_frames
from andante.recordings.table import check_times


class MemoryRecording:
    """A ``Recording`` of arrays, each grey (height, width) or BGR (height, width, 3) uint8.

    ``odometry``, ``reference`` and ``place`` hold one item a frame, ``None`` where it is unknown; the arrays are
    not copied, frames are. Raises ``RecordingError`` for other shapes, other lengths and times that do not increase.
    """

    def __init__(
        self,
        images: Sequence[ImageArray],
        timestamps_s: Sequence[float],
        camera: CameraSpec,
        *,
        odometry: Sequence[Pose2D | None] | None = None,
        reference: Sequence[Pose2D | None] | None = None,
        place: Sequence[int | None] | None = None,
        name: str = "memory",
        conditions: Mapping[str, Any] | None = None,
    ) -> None:
        self.name = name
        self.camera = camera
        self.conditions: Mapping[str, Any] = dict(conditions or {})
        self._images = tuple(images)
        unknown = [None] * len(self._images)
        per_frame: dict[str, Sequence[Any]] = {
            "timestamps_s": [float(time) for time in timestamps_s],
            "odometry": unknown if odometry is None else odometry,
            "reference": unknown if reference is None else reference,
            "place": unknown if place is None else place,
        }
        self._check(per_frame)
        rows = zip(*per_frame.values(), strict=True)
        self.infos: Sequence[FrameInfo] = tuple(
            FrameInfo(index, f"image {index}", *values) for index, values in enumerate(rows)
        )

    def _check(self, per_frame: Mapping[str, Sequence[Any]]) -> None:
        source = f"recording {self.name!r}"
        if not self._images:
            raise RecordingError(f"{source}: no images; a recording needs at least one frame")
        for key, values in per_frame.items():
            if len(values) != len(self._images):
                raise RecordingError(f"{source}: {len(values)} {key} for {len(self._images)} images; give one for each")
        for index, image in enumerate(self._images):
            if not is_picture(image):
                raise RecordingError(
                    f"{source}: image {index} has shape {image.shape} and type {image.dtype}; "
                    f"allowed are uint8 of (height, width) or (height, width, 3)"
                )
        times = per_frame["timestamps_s"]
        check_times(times, [f"frame {index}" for index in range(len(times))], source)

    def __repr__(self) -> str:
        return f"MemoryRecording({self.name!r}, {len(self.infos)} frames)"

    def load(self, info: FrameInfo, *, colour: bool = False) -> ImageArray:
        """A copy of one picture, converted to grey or BGR where it is the other."""
        image = self._images[info.index]
        if colour == (image.ndim == 3):
            return image.copy()
        conversion = cv2.COLOR_GRAY2BGR if colour else cv2.COLOR_BGR2GRAY
        return np.asarray(cv2.cvtColor(image, conversion), dtype=np.uint8)

    def frames(
        self,
        indices: Sequence[int] | None = None,
        *,
        colour: bool = False,
        on_skip: SkipCallback | None = None,
    ) -> Iterator[Frame]:
        """Give frames lazily, in order; every call starts again. Raises as ``map_frames`` does."""
        return iterate_frames(self, indices, colour=colour, on_skip=on_skip)

    def content_hash(self) -> str:
        """SHA-256 over times, poses, places, and the shapes and pixels of the pictures."""
        pictures = (str(image.shape).encode() + image.tobytes() for image in self._images)
        return hash_content(self.infos, pictures)
