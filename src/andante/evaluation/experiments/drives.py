"""Recorded drives as features: pictures are not decoded again for every map that is made of them."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, Frame
from andante.errors import RecordingError
from andante.mapping import FrontEnd, MapConfig, MappedSession, Progress, encode_session
from andante.mapping.frontend import camera_and_size
from andante.protocols import Recording
from andante.recordings import map_frames


@dataclass(frozen=True, eq=False)
class EncodedDrive:
    """One drive through one front end: ``session`` as maps learn from it, and ``features`` (n, d) as they come.

    ``recording`` is where it came from; its pictures are not read again. Maps remember features in one byte a number;
    localizers are asked with, and neighbours keep, float32.
    """

    session: MappedSession = field(repr=False)
    features: NDArray[np.float32] = field(repr=False)
    recording: Recording

    @property
    def xy(self) -> FloatArray:
        """True positions (n, 2) in metres."""
        return self.session.xy

    def part(self, indices: tuple[int, ...]) -> EncodedDrive:
        """Some of the frames, in ascending order."""
        chosen = np.array(indices, dtype=np.int64)
        return EncodedDrive(self.session.subset(chosen), self.features[chosen], self.recording)


def front_end_of(recording: Recording, config: MapConfig) -> FrontEnd:
    """What a configuration makes of the camera of a recording."""
    return FrontEnd(*camera_and_size(recording), config.panorama, config.features)


def encode(
    recording: Recording, front_end: FrontEnd, config: MapConfig, progress: Progress | None = None
) -> EncodedDrive:
    """All frames of a drive; raises ``RecordingError`` where one has no position or cannot be read."""
    total, vectors = len(recording.infos), list[NDArray[np.float32]]()

    def features(frame: Frame) -> NDArray[np.float32]:
        return front_end.features(frame.image)

    for _, vector in map_frames(recording, features):
        vectors.append(vector)
        if progress is not None:
            progress(f"read {recording.name}", len(vectors), total)
    session = encode_session(recording, front_end, "reference", config)
    if not len(session) == len(vectors) == total:
        raise RecordingError(f"recording {recording.name!r} lacks pictures or positions; remove it to render it anew")
    return EncodedDrive(session, np.stack(vectors), recording)
