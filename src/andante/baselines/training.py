"""The frames that a map was made from, once more: found, checked to be the same, and encoded."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, Frame, FrameInfo, IndexArray
from andante.errors import RecordingError
from andante.mapping import Progress, SlowMap, Source
from andante.mapping.sessions import usable_frames
from andante.protocols import Recording
from andante.recordings import map_frames, open_recording


@dataclass(frozen=True)
class Training:
    """Features (n, d) float32, positions ``xy`` (n, 2) and recording number ``session`` (n,) of the mapped frames."""

    features: NDArray[np.float32] = field(repr=False)
    xy: FloatArray = field(repr=False)
    session: IndexArray = field(repr=False)


def training_recordings(slowmap: SlowMap, given: Sequence[Recording] = ()) -> list[Recording]:
    """The recordings of a map in its order: among those given, or else where the map found them.

    Told by their content, so that renamed or moved ones are recognised and changed ones are not. Raises
    ``RecordingError`` for one that is given but not in the map, and for one that cannot be found.
    """
    by_content = {recording.content_hash(): recording for recording in given}
    for content, recording in by_content.items():
        if not slowmap.learnt_from(content):
            raise RecordingError(
                f"recording {recording.name!r} is not one that the map was learnt from, which are: "
                f"{', '.join(source.name for source in slowmap.sources)}; give these with --train"
            )
    return [by_content.get(source.content_hash) or _reopened(source) for source in slowmap.sources]


def training_frames(slowmap: SlowMap, recordings: Sequence[Recording], *, progress: Progress | None = None) -> Training:
    """Encode the frames that the map used: those with a position where the robot was not standing still."""
    features: list[NDArray[np.float32]] = []
    xy: list[FloatArray] = []
    for number, recording in enumerate(recordings):
        indices, positions = _mapped_frames(slowmap, number, recording)
        position_of = dict(zip(indices, positions, strict=True))
        encoded = _encoded(slowmap, recording, indices, progress)
        features.append(np.stack([vector for _, vector in encoded]))
        xy.append(np.stack([position_of[index] for index, _ in encoded]))
    session = np.repeat(np.arange(len(xy), dtype=np.int64), [len(positions) for positions in xy])
    return Training(np.concatenate(features), np.concatenate(xy), session)


def _mapped_frames(slowmap: SlowMap, number: int, recording: Recording) -> tuple[list[int], FloatArray]:
    """Indices (m,) and positions (m, 2): those that the map remembers, else those of the recording."""
    if slowmap.memory is not None:
        session = slowmap.memory[number]
        return session.number.tolist(), session.xy
    if slowmap.config.positions == "odometry" and len(slowmap.sources) > 1:
        raise RecordingError(
            "a map of several drives that was made from odometry has to remember where they were laid for baselines: "
            "load it with its memory, or make it without --localize-only"
        )
    return usable_frames(recording, slowmap.config.positions, slowmap.config)


def _reopened(source: Source) -> Recording:
    missing = f"training recording {source.name!r} is needed for baselines"
    if source.folder is None:
        raise RecordingError(f"{missing}, but was not read from a folder; pass it with --train")
    try:
        recording = open_recording(source.folder)
        content = recording.content_hash()
    except RecordingError as error:
        raise RecordingError(f"{missing}, but cannot be opened: {error}; pass its folder with --train") from None
    if content != source.content_hash:
        raise RecordingError(
            f"{missing}, but {source.folder} has changed since the map was made; pass the original with --train "
            "or make the map again"
        )
    return recording


def _encoded(
    slowmap: SlowMap, recording: Recording, indices: Sequence[int], progress: Progress | None
) -> list[tuple[int, NDArray[np.float32]]]:
    """Index and features of every frame that can be used."""
    front_end, skipped = slowmap.for_recording(recording).front_end, list[str]()

    def features(frame: Frame) -> NDArray[np.float32]:
        return front_end.features(frame.image)

    def on_skip(info: FrameInfo, reason: str) -> None:
        skipped.append(reason)

    encoded = []
    for info, vector in map_frames(recording, features, indices, on_skip=on_skip):
        encoded.append((info.index, vector))
        if progress is not None:
            progress(recording.name, len(encoded) + len(skipped), len(indices))
    return encoded
