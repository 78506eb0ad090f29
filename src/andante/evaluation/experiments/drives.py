"""Recorded drives as features: pictures are decoded once, however many maps are made of them."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, Frame
from andante.errors import RecordingError
from andante.mapping import FrontEnd, MapConfig, Progress, SlowMap, build_map
from andante.mapping.builder import usable_frames
from andante.mapping.frontend import camera_and_size
from andante.protocols import Recording
from andante.recordings import MemoryRecording, map_frames


@dataclass(frozen=True)
class EncodedDrive:
    """One drive through one front end: ``features`` (n, d) float32 and true positions ``xy`` (n, 2)."""

    recording: Recording = field(repr=False)
    features: NDArray[np.float32] = field(repr=False)
    xy: FloatArray = field(repr=False)

    def part(self, indices: tuple[int, ...]) -> EncodedDrive:
        """Some of the frames, in ascending order."""
        chosen = list(indices)
        infos = [self.recording.infos[index] for index in chosen]
        some = MemoryRecording(
            [self.recording.load(info) for info in infos],
            [info.timestamp_s for info in infos],
            self.recording.camera,
            reference=[info.reference for info in infos],
            name=self.recording.name,
        )
        return replace(self, recording=some, features=self.features[chosen], xy=self.xy[chosen])


def front_end_of(recording: Recording, config: MapConfig) -> FrontEnd:
    """What a configuration makes of the camera of a recording."""
    return FrontEnd(*camera_and_size(recording), config.panorama, config.features)


def encode(
    recording: Recording, front_end: FrontEnd, config: MapConfig, progress: Progress | None = None
) -> EncodedDrive:
    """All frames of a drive; raises ``RecordingError`` where one has no position or cannot be read."""
    indices, xy = usable_frames(recording, "reference", config)
    total, vectors = len(recording.infos), list[NDArray[np.float32]]()

    def features(frame: Frame) -> NDArray[np.float32]:
        return front_end.features(frame.image)

    for _, vector in map_frames(recording, features):
        vectors.append(vector)
        if progress is not None:
            progress(f"read {recording.name}", len(vectors), total)
    if not len(indices) == len(vectors) == total:
        raise RecordingError(f"recording {recording.name!r} lacks pictures or positions; remove it to render it anew")
    return EncodedDrive(recording, np.stack(vectors), xy)


def learn(drives: list[EncodedDrive], config: MapConfig) -> SlowMap:
    """A map of drives, or of parts of them."""
    return build_map([drive.recording for drive in drives], config)
