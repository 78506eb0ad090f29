"""From recordings to what a map can learn from: which frames, where they were taken, and their features."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from itertools import combinations, islice

import numpy as np

from andante.data import FloatArray, Frame, FrameInfo, ImageArray, Trajectory
from andante.errors import RecordingError
from andante.mapping.codes import Codes
from andante.mapping.config import MapConfig, Positions
from andante.mapping.frontend import FrontEnd
from andante.mapping.memory import MappedSession, Source
from andante.mapping.odometry import Closing
from andante.mapping.timing import TimedRecording
from andante.protocols import Recording, StoredRecording
from andante.recordings import default_workers, map_frames, moving_frames, picture_fingerprint

Progress = Callable[[str, int, int], None]
"""Called with a stage, the steps done and the steps in all."""
TakePanoramas = Callable[[ImageArray], None]
"""Called with grey panoramas (n, height, width) uint8."""

MAX_SHARED_PICTURES = 0.05
"""Share of pictures that two recordings may have in common and still count as two."""
_KINDS: tuple[Positions, ...] = ("reference", "place", "odometry")
"""Of positions, the best first."""
STACK = 8
"""Pictures that are encoded at once."""


@dataclass
class BuildLog:
    """What happened while a map was built: seconds by stage, and frames left out before their picture was read.

    ``closings`` say how drives were brought into one frame where only odometry is known, ``hints`` what a user should
    know of the map.
    """

    seconds: dict[str, float] = field(default_factory=dict)
    stationary: int = 0
    without_position: int = 0
    closings: list[Closing] = field(default_factory=list)
    hints: list[str] = field(default_factory=list)

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Add the time spent inside to a stage."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start


def encode_session(
    recording: Recording,
    front_end: FrontEnd,
    positions: Positions,
    config: MapConfig,
    *,
    progress: Progress | None = None,
    log: BuildLog | None = None,
) -> MappedSession:
    """Features and positions of the frames of a drive that can be mapped.

    ``front_end`` is that of the map; the image circle of the recording's own camera is found where it is not declared.
    The features of a frame depend on nothing but its picture. Raises ``RecordingError`` for a recording without usable
    frames or with too many unreadable ones, ``ConfigError`` for a camera that is not like the map's.
    """
    parts = [Codes.of(np.empty((0, front_end.dim), dtype=np.float32))]

    def encode(panoramas: ImageArray) -> None:
        parts.append(Codes.of(front_end.encoder.encode(panoramas)))

    session = read_session(recording, front_end, positions, config, encode, progress=progress, log=log)
    return replace(session, codes=Codes.joined(parts))


def read_session(
    recording: Recording,
    front_end: FrontEnd,
    positions: Positions,
    config: MapConfig,
    take: TakePanoramas,
    *,
    progress: Progress | None = None,
    log: BuildLog | None = None,
) -> MappedSession:
    """The same without features: ``take`` is handed the panoramas of its frames in order, at most ``STACK`` at once."""
    log = log or BuildLog()
    phases = [Codes.of(np.empty((0, front_end.phase_dim), dtype=np.float32))]

    def take_phases_too(panoramas: ImageArray) -> None:
        take(panoramas)
        phases.append(Codes.of(front_end.phases(panoramas)))

    content = recording.content_hash()
    indices, xy = usable_frames(recording, positions, config, log)
    with log.timed("features"):
        pictures, skipped = _read(
            recording, indices, front_end.for_recording(recording), take_phases_too, progress=progress, log=log
        )
    kept = [index not in skipped for index in indices]
    heading = _heading([recording.infos[index] for index in indices], positions)
    source = Source(
        name=recording.name,
        content_hash=content,
        frames=sum(kept),
        poses=positions,
        conditions=dict(recording.conditions),
        skipped=tuple(skipped.values()),
        folder=str(recording.folder.resolve()) if isinstance(recording, StoredRecording) else None,
    )
    fingerprints = np.array([short_fingerprint(picture) for picture in pictures], dtype=np.uint32)
    number = np.array(indices, dtype=np.int64)
    nothing = Codes.of(np.empty((sum(kept), 0), dtype=np.float32))
    phase = Codes.joined(phases)
    return MappedSession(source, nothing, phase, xy[kept], heading[kept], number[kept], fingerprints)


def short_fingerprint(picture: str) -> int:
    """Half of a ``picture_fingerprint``, 32 bits: enough to tell apart the pictures of a few recordings."""
    return int(picture[:8], 16)


def require_distinct(sessions: Sequence[MappedSession]) -> None:
    """The same drive twice would make the cross-validation see the answer: raises ``RecordingError``.

    Told by the content, and for copies that differ in their table or have frames cut away by their pictures, of which
    at most 5 % may be in common.
    """
    for one, other in combinations(sessions, 2):
        names = f"{one.source.name!r} and {other.source.name!r}"
        if one.source.content_hash == other.source.content_hash:
            raise RecordingError(f"recordings {names} have the same content; leave one out")
        shared = len(np.intersect1d(one.pictures, other.pictures))
        if shared > MAX_SHARED_PICTURES * min(len(one), len(other)):
            raise RecordingError(f"recordings {names} have {shared} pictures in common; leave one out")


def positions_of(recordings: Sequence[Recording], wanted: Positions) -> Positions:
    """Resolve ``auto``: reference poses where all recordings have some, else place numbers, else odometry.

    Raises ``RecordingError`` for no recordings, or where they have nothing in common.
    """
    if not recordings:
        raise RecordingError("a map needs at least one recording, got none")
    if wanted != "auto":
        return wanted
    has = [positions_in(one) for one in recordings]
    for kind in _KINDS:
        if all(kind in own for own in has):
            return kind
    for recording, own in zip(recordings, has, strict=True):
        if not own:
            raise RecordingError(
                f"recording {recording.name!r} has neither reference poses, places nor odometry; a map needs x_m and "
                "y_m, place, or odom_x_m and odom_y_m in frames.csv"
            )
    raise RecordingError(
        "the recordings have no kind of position in common; a map of several drives needs x_m and y_m, place, or "
        "odom_x_m and odom_y_m in every frames.csv"
    )


def positions_in(recording: Recording) -> set[Positions]:
    """The kinds of position that at least one frame has."""
    return {kind for kind in _KINDS if np.isfinite(_xy(recording.infos, kind)).all(axis=1).any()}


def unused_positions(recordings: Sequence[Recording], chosen: Positions) -> str:
    """In words, which recordings have better positions than those that all have in common; empty where none has."""
    better = _KINDS[: _KINDS.index(chosen)]
    waste = [one.name for one in recordings if positions_in(one) & {*better}]
    if not waste:
        return ""
    return f"mapped by {chosen}, which all drives have; better positions of {', '.join(waste)} are not used"


def usable_frames(
    recording: Recording, positions: Positions, config: MapConfig, log: BuildLog | None = None
) -> tuple[list[int], FloatArray]:
    """Indices (m,) and positions (m, 2) of the frames to learn from: position known, robot not standing still.

    Raises ``RecordingError`` where there is none.
    """
    infos = recording.infos
    xy = _xy(infos, positions)
    known = np.isfinite(xy).all(axis=1)
    if not known.any():
        columns = {"place": "place", "odometry": "odom_x_m and odom_y_m"}.get(positions, "x_m and y_m")
        raise RecordingError(
            f"recording {recording.name!r} has no {positions} positions ({columns} of frames.csv are blank); "
            "choose other --positions or fill them in"
        )
    # Of a stand, the first frame with a position is kept.
    usable = np.flatnonzero(known)
    chosen = usable[moving_frames([infos[index] for index in usable.tolist()], config.learning.stationary_m)]
    if log is not None:
        log.without_position += len(infos) - len(usable)
        log.stationary += len(usable) - len(chosen)
    return chosen.tolist(), xy[chosen]


def _xy(infos: Sequence[FrameInfo], positions: Positions) -> FloatArray:
    if positions == "place":
        return np.array([(np.nan if info.place is None else info.place, 0.0) for info in infos]).reshape(-1, 2)
    return Trajectory.of(infos, "odometry" if positions == "odometry" else "reference").xy_m


def _heading(infos: Sequence[FrameInfo], positions: Positions) -> FloatArray:
    if positions == "place":
        return np.full(len(infos), np.nan)
    return Trajectory.of(infos, "odometry" if positions == "odometry" else "reference").heading_rad


def _read(
    recording: Recording,
    indices: Sequence[int],
    front_end: FrontEnd,
    take: TakePanoramas,
    *,
    progress: Progress | None,
    log: BuildLog,
) -> tuple[list[str], dict[int, str]]:
    """Fingerprints of the frames, and index and reason of every one that had to be skipped."""
    skipped = dict[int, str]()

    def panorama(frame: Frame) -> tuple[ImageArray, str]:
        return front_end.grey_panorama(frame.image), picture_fingerprint(frame.image)

    def on_skip(info: FrameInfo, reason: str) -> None:
        # Where a recording lies is nobody's business in a map; only some reasons name the picture.
        if isinstance(recording, StoredRecording):
            reason = reason.replace(f"{recording.folder}{os.sep}", "")
        skipped[info.index] = reason if info.image in reason else f"{info.image}: {reason}"

    # The threads decode and unwrap; encoding whole stacks here keeps the interpreter out of their way.
    timed = TimedRecording(recording)
    found = (result for _, result in map_frames(timed, panorama, indices, on_skip=on_skip))
    pictures = list[str]()
    while stack := list(islice(found, STACK)):
        take(np.stack([image for image, _ in stack]))
        pictures += [fingerprint for _, fingerprint in stack]
        if progress is not None:
            progress(recording.name, min(len(indices), len(pictures) + len(skipped)), len(indices))
    # Decoding shares its threads and its time with the rest; its part is told apart from theirs.
    decode = timed.load_seconds / default_workers()
    log.seconds["decode"] = log.seconds.get("decode", 0.0) + decode
    log.seconds["features"] = log.seconds.get("features", 0.0) - decode
    return pictures, skipped
