"""Finds taught landmarks in a picture, each at most once, without the library that it was learnt with."""

from __future__ import annotations

import hashlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any, Self

import numpy as np

from andante.camera import PanoramaGeometry
from andante.data import CameraSpec, FloatArray, ImageArray
from andante.errors import InputError, MissingExtraError
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.detector_file import INPUT, KEY, OUTPUT, checked_seal, read_header
from andante.landmarks.heatmaps import FloatArray32, Grid, decoded
from andante.landmarks.labels import read_file, write_file
from andante.landmarks.layout import PER_LANDMARK, STRIDE
from andante.landmarks.panoramas import PanoramaMaker

MAX_BYTES = 2**26
"""A detector of a hundred landmarks has two million bytes."""


class LandmarkDetector:
    """Made from the bytes of a detector's file, as learning gives them (``data``); ``source`` names it in messages.

    Raises ``InputError`` for anything but a whole file of a known schema, ``MissingExtraError`` without onnxruntime.
    """

    def __init__(self, data: bytes, source: str = "this detector", *, threads: int = 1) -> None:
        checked_seal(data, source)
        self.data, self._session = data, _session(data, source, threads)
        self.header = read_header(self._session.get_modelmeta().custom_metadata_map.get(KEY), source)
        self._grid = Grid(self.header.geometry, STRIDE)
        _check_shapes(self._session, self._grid, len(self.header.landmarks), source)
        self._maker: tuple[tuple[CameraSpec, tuple[int, ...]], PanoramaMaker] | None = None

    def __repr__(self) -> str:
        return f"LandmarkDetector({', '.join(self.names)})"

    @classmethod
    def load(
        cls, path: str | Path, *, names: Sequence[str] | None = None, sha256: str | None = None, threads: int = 1
    ) -> Self:
        """Read a detector; ``names`` and ``sha256`` are those that it must have, where somebody relies on them.

        Raises ``InputError`` naming the file and what is wrong with it, ``MissingExtraError`` without onnxruntime.
        """
        data = read_file(Path(path), MAX_BYTES)
        found = hashlib.sha256(data).hexdigest()
        if sha256 is not None and sha256.lower() != found:
            raise InputError(
                f"landmark detector {path} has the SHA-256 {found[:16]}..., expected {sha256[:16].lower()}...; give "
                "the file that the map was built with, or build the map again"
            )
        detector = cls(data, str(path), threads=threads)
        check_names(detector, names or (), f"landmark detector {path}")
        return detector

    def save(self, path: str | Path) -> None:
        """Write the file, all or nothing; raises ``InputError`` where the place cannot be written."""
        write_file(Path(path), self.data)

    @property
    def names(self) -> tuple[str, ...]:
        """The landmarks that it finds."""
        return tuple(landmark.name for landmark in self.header.landmarks)

    @property
    def geometry(self) -> PanoramaGeometry:
        """The panoramas that it looks at."""
        return self.header.geometry

    @property
    def sha256(self) -> str:
        """Checksum of its file."""
        return hashlib.sha256(self.data).hexdigest()

    def detect(self, image: ImageArray, camera: CameraSpec) -> list[Detection]:
        """Landmarks in a picture, grey (h, w) or BGR (h, w, 3) uint8, in the order of ``names``.

        Every one comes once or, where its score is below its threshold, not at all. Boxes are in the robot's frame.
        Raises ``ImageError`` and ``ConfigError`` for pictures and cameras that cannot be unwrapped.
        """
        key = camera, image.shape[:2]
        maker = self._maker
        if maker is None or maker[0] != key:  # one camera at a time is usual
            self._maker = maker = key, PanoramaMaker(camera, image.shape, self.geometry)
        return self.detect_in_panorama(maker[1](image))

    def detect_in_panorama(self, panorama: ImageArray) -> list[Detection]:
        """As ``detect``, for a BGR panorama (height, width, 3) uint8 of ``geometry``."""
        scores, boxes = self.best_places(panorama)
        return [
            Detection(box, landmark.name, float(score))
            for landmark, score, box in zip(self.header.landmarks, scores, boxes, strict=True)
            if score >= landmark.threshold
        ]

    def best_places(self, panorama: ImageArray) -> tuple[FloatArray, list[Box]]:
        """Scores (k,) and boxes of the likeliest places of all landmarks, however unlikely."""
        heat, cells = decoded(*self.maps(panorama))
        slope = np.array([landmark.slope for landmark in self.header.landmarks])
        offset = np.array([landmark.offset for landmark in self.header.landmarks])
        scores = 1.0 / (1.0 + np.exp(-np.clip(slope * heat + offset, -50.0, 50.0)))
        return scores, [self._grid.box_of(row) for row in cells]

    def maps(self, panorama: ImageArray) -> tuple[FloatArray32, FloatArray32]:
        """What the network says: heat (k, rows, columns) as logits, shapes (k, 4, rows, columns)."""
        (told,) = self._session.run([OUTPUT], {INPUT: panorama[None]})
        told = told[0].reshape(len(self.header.landmarks), PER_LANDMARK, self._grid.rows, self._grid.columns)
        return told[:, 0], told[:, 1:]


def check_names(detector: LandmarkDetector, names: Sequence[str], source: str) -> None:
    """Raise ``InputError`` unless a detector, called ``source`` in the message, finds all of these landmarks."""
    if missing := sorted(set(names) - set(detector.names)):
        raise InputError(
            f"{source} finds {', '.join(detector.names)}, but not {', '.join(missing)}; give the detector that was "
            "taught these landmarks, or teach them"
        )


def _session(data: bytes, source: str, threads: int) -> Any:  # noqa: ANN401 (onnxruntime has no types)
    try:
        import onnxruntime
    except ImportError:
        raise MissingExtraError("onnxruntime", "landmarks") from None
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = threads
    options.inter_op_num_threads = 1
    options.log_severity_level = 4
    try:
        return onnxruntime.InferenceSession(data, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # the runtime raises a dozen types that share only this base
        raise InputError(f"{source} is no ONNX file that this machine can run: {str(error).splitlines()[0]}") from None


def _check_shapes(session: Any, grid: Grid, landmarks: int, source: str) -> None:  # noqa: ANN401
    """A file whose network and metadata contradict each other is refused before it is used."""
    wanted = {
        INPUT: [1, grid.geometry.height_px, grid.geometry.width_px, 3],
        OUTPUT: [1, PER_LANDMARK * landmarks, grid.rows, grid.columns],
    }
    found = {one.name: list(one.shape) for one in (*session.get_inputs(), *session.get_outputs())}
    if found != wanted:
        raise InputError(
            f"landmark detector {source} names {landmarks} landmarks, its network has {found} where {wanted} is "
            "needed; the file does not belong together, learn it again"
        )
