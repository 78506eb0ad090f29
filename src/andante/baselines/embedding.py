"""Retrieval by a network that the user brings: the mapped frames whose embedding is nearest tell the position."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

import cv2
import numpy as np

from andante.baselines.drives import read_drives
from andante.baselines.method import Learned
from andante.baselines.nearest import NearestNeighbours
from andante.baselines.onnx_network import OnnxNetwork
from andante.data import Estimate, Hypothesis, ImageArray, PoseSource, Status
from andante.errors import BlankImageError, ConfigError, RecordingError
from andante.features.illumination import Float32Array
from andante.mapping import FrontEnd, Progress
from andante.mapping.config import FeatureConfig, PanoramaConfig
from andante.mapping.frontend import camera_and_size
from andante.protocols import Recording

_PANORAMA = PanoramaConfig(width_px=1200, height_px=200, min_deg=3.0, max_deg=50.0)


@dataclass(frozen=True)
class Embedding:
    """A ``Method``: nearest neighbours (cosine) among embeddings by a network in a local ONNX file.

    Any classifier or backbone serves that takes float pictures (n, 1 or 3, height, width). A panorama is cut into
    ``cuts`` equal windows, each resized to the network's input and brought to (grey / 255 - ``mean``) / ``std`` in the
    order of its channels; the defaults are those of ImageNet in RGB. Maps are averaged to a vector, the vectors of the
    cuts too, and the result has unit length. ``output`` names the tensor to take, which need not be an output of the
    file (that needs the package onnx); by default it is the last output. ``input_px`` (height, width) is needed where
    the file leaves the size open. The position is the mean of the ``neighbours`` nearest, weighted by inverse distance.
    """

    path: Path
    output: str | None = None
    cuts: int = 4
    neighbours: int = 5
    mean: tuple[float, float, float] = (0.485, 0.456, 0.406)
    std: tuple[float, float, float] = (0.229, 0.224, 0.225)
    input_px: tuple[int, int] | None = None

    def __post_init__(self) -> None:
        if self.cuts < 1 or self.neighbours < 1:
            raise ConfigError(f"cuts and neighbours must be at least 1, got {self.cuts} and {self.neighbours}")
        if not min(self.std) > 0:
            raise ConfigError(f"std must be three positive numbers, got {self.std}")

    @property
    def name(self) -> str:
        """The name in tables."""
        return "embedding"

    def learn(
        self, recordings: Sequence[Recording], *, positions: PoseSource = "reference", progress: Progress | None = None
    ) -> Learned:
        """Embed all frames with a position; raises as ``Method.learn`` says, ``ConfigError`` for an unusable file."""
        network = OnnxNetwork(self.path, self.output, self.input_px)
        if not recordings:
            raise RecordingError("embedding needs at least one recording to learn from, got none")
        front_end = FrontEnd(*camera_and_size(recordings[0]), _PANORAMA, FeatureConfig(kind="flat"))
        drives = read_drives(recordings, front_end, positions, progress=progress)
        start = time.perf_counter()
        vectors = np.stack([self.vector(network, panorama) for panorama in drives.panoramas])
        embedded = time.perf_counter()
        nearest = NearestNeighbours.fit(front_end, "m", vectors, drives.xy, self.neighbours)
        localizer = EmbeddingLocalizer(self, network, nearest)
        notes = (f"{vectors.shape[1]} numbers a frame from {self.path.name}, {network.output}",)
        return Learned(
            localizer,
            drives.seconds + embedded - start,
            time.perf_counter() - embedded,
            vectors.nbytes + nearest.xy.nbytes + self.path.stat().st_size,
            (*notes, f"{drives.skipped} frames skipped") if drives.skipped else notes,
        )

    def vector(self, network: OnnxNetwork, panorama: ImageArray) -> Float32Array:
        """Grey panorama (height, width) -> (d,) of unit length."""
        height, width = network.input_px
        pictures = np.stack(
            [
                np.asarray(cv2.resize(cut, (width, height), interpolation=cv2.INTER_AREA), np.float32)
                for cut in np.array_split(panorama, self.cuts, axis=1)
            ]
        )
        channels = range(3) if network.channels == 3 else range(1)
        scaled = np.stack([(pictures / 255 - self.mean[one]) / self.std[one] for one in channels], axis=1)
        vector = network(scaled.astype(np.float32)).mean(axis=0)
        unit: Float32Array = vector / max(float(np.linalg.norm(vector)), 1e-12)
        return unit


@dataclass(frozen=True)
class EmbeddingLocalizer:
    """A ``StagedLocalizer`` that always answers; ``nearest`` holds the embeddings of the mapped frames."""

    method: Embedding
    network: OnnxNetwork = field(repr=False)
    nearest: NearestNeighbours = field(repr=False)

    @property
    def name(self) -> str:
        """The name in tables."""
        return self.method.name

    def prepare(self, image: ImageArray) -> Float32Array | BlankImageError:
        """Grey (h, w) or BGR (h, w, 3) uint8 -> embedding (d,), or why there is nothing to see."""
        try:
            return self.method.vector(self.network, self.nearest.front_end.grey_panorama(image))
        except BlankImageError as error:
            return error

    def locate(self, prepared: Float32Array | BlankImageError) -> Estimate:
        """Ok with a position; lost only where the picture shows nothing."""
        if isinstance(prepared, BlankImageError):
            return Estimate(Status.LOST, str(prepared))
        x, y = self.nearest.position(prepared).tolist()
        return Estimate(Status.OK, f"{self.name} always answers", x, y, hypotheses=(Hypothesis(x, y, 1.0),))

    def localize(self, image: ImageArray) -> Estimate:
        """Both steps at once; raises ``ImageError`` for pictures of foreign proportions."""
        return self.locate(self.prepare(image))
