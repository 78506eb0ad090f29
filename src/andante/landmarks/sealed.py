"""A detector as it lies in a map: known to be whole, started when it is first needed."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cached_property

from andante.data import CameraSpec, ImageArray
from andante.landmarks.boxes import Detection
from andante.landmarks.detector import LandmarkDetector, check_names
from andante.landmarks.detector_file import checked_seal


class SealedDetector:
    """The bytes of a detector's file; maps are opened, shown and updated without onnxruntime, which only looking needs.

    ``names`` are the landmarks that it has to find. Raises ``InputError`` for bytes that are not what was written;
    ``source`` names them in messages.
    """

    def __init__(self, data: bytes, source: str = "this detector", names: Sequence[str] = ()) -> None:
        checked_seal(data, source)
        self.data, self._source, self._names = data, source, tuple(names)

    def detect(self, image: ImageArray, camera: CameraSpec) -> Sequence[Detection]:
        """As ``LandmarkDetector.detect``.

        Raises ``MissingExtraError`` without onnxruntime, ``InputError`` for a detector of other landmarks.
        """
        return self._started.detect(image, camera)

    @cached_property
    def _started(self) -> LandmarkDetector:
        # Two threads may both start it; either is as good.
        detector = LandmarkDetector(self.data, self._source)
        check_names(detector, self._names, self._source)
        return detector
