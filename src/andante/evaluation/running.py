"""A recording through one localizer, or through several that share their features."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
from numpy.typing import NDArray

from andante.data import Estimate, Frame, FrameInfo, Status
from andante.errors import BlankImageError
from andante.mapping import FrontEnd, Progress
from andante.mapping.frontend import Encoded
from andante.mapping.store import FeatureStore
from andante.protocols import Localizer, Recording
from andante.recordings import map_frames
from andante.sfa import one_thread


@dataclass(frozen=True, slots=True)
class LocalizedFrame:
    """What a localizer said of one frame, and the seconds that it took once the picture was decoded."""

    info: FrameInfo
    estimate: Estimate
    seconds: float


@dataclass(frozen=True, slots=True)
class Skipped:
    """A frame that could not be localized, because its picture cannot be read."""

    image: str
    reason: str


@dataclass(frozen=True, slots=True)
class Run:
    """A whole recording: ``frames`` in order, ``skipped`` ones, and the wall time of everything, decoding included."""

    frames: tuple[LocalizedFrame, ...] = field(repr=False)
    skipped: tuple[Skipped, ...] = ()
    wall_s: float = 0.0


class FeatureLocalizer(Protocol):
    """A localizer that can start from the features of a shared front end."""

    @property
    def name(self) -> str:
        """The name in tables."""
        ...

    def estimate(self, encoded: Encoded) -> Estimate:
        """One picture -> estimate."""
        ...


def run_localizer(localizer: Localizer, recording: Recording, *, progress: Progress | None = None) -> Run:
    """Localize every frame in the threads that decode them, with one BLAS thread each.

    Frames whose picture cannot be read are skipped; more than 5 % of them raise ``RecordingError``.
    """

    def localize(frame: Frame) -> tuple[Estimate, float]:
        start = time.perf_counter()
        estimate = localizer.localize(frame.image)
        return estimate, time.perf_counter() - start

    start = time.perf_counter()
    skips = Skips(recording, progress)
    frames: list[LocalizedFrame] = []
    with one_thread():
        for info, (estimate, seconds) in map_frames(recording, localize, on_skip=skips):
            frames.append(LocalizedFrame(info, estimate, seconds))
            skips.tell(len(frames))
    return Run(tuple(frames), tuple(skips.seen), time.perf_counter() - start)


def run_on_features(
    localizers: Sequence[FeatureLocalizer],
    front_end: FrontEnd,
    recording: Recording,
    *,
    progress: Progress | None = None,
) -> list[Run]:
    """The same for several localizers, each picture being decoded and encoded only once.

    The time of that first pass counts fully for every localizer, and so do the seconds of encoding in each frame.
    """
    ends = front_end.dim, front_end.dim + front_end.phase_dim
    with one_thread(), FeatureStore(ends[1] + front_end.landmark_dim) as store:
        encoding = _encode(front_end, recording, store, progress)
        return [_run_one(localizer, encoding, store, ends) for localizer in localizers]


@dataclass(frozen=True, slots=True)
class _Encoded:
    """A frame whose features were stored, or the reason why its picture has none."""

    info: FrameInfo
    seconds: float
    blank: str | None


@dataclass(frozen=True, slots=True)
class _Encoding:
    frames: list[_Encoded]
    skipped: tuple[Skipped, ...]
    wall_s: float


class Skips:
    """Collects frames that are skipped and tells how far the work has come."""

    def __init__(self, recording: Recording, progress: Progress | None) -> None:
        self.seen: list[Skipped] = []
        self._name, self._total, self._progress = recording.name, len(recording.infos), progress

    def __call__(self, info: FrameInfo, reason: str) -> None:
        """One more that was skipped."""
        self.seen.append(Skipped(info.image, reason))

    def tell(self, done: int) -> None:
        """How many were not."""
        if self._progress is not None:
            self._progress(self._name, done + len(self.seen), self._total)


def _encode(front_end: FrontEnd, recording: Recording, store: FeatureStore, progress: Progress | None) -> _Encoding:
    def encode(frame: Frame) -> tuple[NDArray[np.float32] | None, str | None, float]:
        start = time.perf_counter()
        try:
            encoded = front_end.encode(frame.image)
            landmarks = [] if encoded.landmarks is None else [encoded.landmarks]
            vector, blank = np.concatenate([encoded.features, encoded.phase, *landmarks], axis=1), None
        except BlankImageError as error:
            vector, blank = None, str(error)
        return vector, blank, time.perf_counter() - start

    start = time.perf_counter()
    skips, frames = Skips(recording, progress), list[_Encoded]()
    for info, (vector, blank, seconds) in map_frames(recording, encode, on_skip=skips):
        if vector is not None:
            store.extend(vector)
        frames.append(_Encoded(info, seconds, blank))
        skips.tell(len(frames))
    return _Encoding(frames, tuple(skips.seen), time.perf_counter() - start)


def _run_one(localizer: FeatureLocalizer, encoding: _Encoding, store: FeatureStore, ends: tuple[int, int]) -> Run:
    """``ends`` are the columns where features and phases end; what is left are landmarks."""
    vectors = (_split(row[None], *ends) for _, rows in store.chunks() for row in rows)
    frames = []
    for frame in encoding.frames:
        vector = next(vectors) if frame.blank is None else None
        start = time.perf_counter()
        estimate = Estimate(Status.LOST, frame.blank or "") if vector is None else localizer.estimate(vector)
        frames.append(LocalizedFrame(frame.info, estimate, frame.seconds + time.perf_counter() - start))
    alone_s = sum(after.seconds - before.seconds for after, before in zip(frames, encoding.frames, strict=True))
    return Run(tuple(frames), encoding.skipped, encoding.wall_s + alone_s)


def _split(row: NDArray[np.float32], features: int, phases: int) -> Encoded:
    """A stored row (1, d) as what it was made of."""
    landmarks = row[:, phases:] if phases < row.shape[1] else None
    return Encoded(row[:, :features], row[:, features:phases], landmarks)
