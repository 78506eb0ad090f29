"""Drives as every method on the map's front end learns from them: the frames, positions and features of a map."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, ImageArray, PoseSource
from andante.errors import RecordingError
from andante.mapping import FrontEnd, MapConfig, MappedSession, Progress, encode_session
from andante.mapping.codes import Codes
from andante.mapping.frontend import camera_and_size
from andante.mapping.odometry import in_one_frame
from andante.mapping.sessions import read_session
from andante.protocols import Recording


@dataclass(frozen=True, eq=False)
class Drives:
    """n frames: ``features`` (n, d) float32, positions ``xy`` (n, 2), ``heading_rad`` (n,) with NaN where unknown."""

    front_end: FrontEnd
    features: NDArray[np.float32] = field(repr=False)
    xy: FloatArray = field(repr=False)
    heading_rad: FloatArray = field(repr=False)


def encoded_drives(
    recordings: Sequence[Recording], positions: PoseSource, *, progress: Progress | None = None
) -> Drives:
    """The frames that the default map would learn from, with its features as it remembers them.

    Where only odometry is known, drives are laid over each other as for a map. Raises ``RecordingError`` for recordings
    without positions or with too many unreadable pictures.
    """
    config, front_end = MapConfig(), _front_end(recordings)
    sessions = [encode_session(one, front_end, positions, config, progress=progress) for one in recordings]
    if positions == "odometry":
        sessions, _ = in_one_frame([], list(zip(sessions, recordings, strict=True)), config.drift)
    return _joined(front_end, sessions, Codes.joined([one.codes for one in sessions]).rows())


def pictured_drives(
    recordings: Sequence[Recording],
    positions: PoseSource,
    picture: Callable[[ImageArray], NDArray[np.float32]],
    *,
    progress: Progress | None = None,
) -> Drives:
    """The same frames with whatever ``picture`` makes of their grey panoramas (m, height, width): (m, d).

    Without the map's features drives cannot be laid over each other, so by odometry there may be only one.
    """
    if positions == "odometry" and len(recordings) > 1:
        raise RecordingError(
            f"{len(recordings)} drives with odometry alone have no common frame for this method; map one of them, or "
            "use reference positions"
        )
    config, front_end, parts = MapConfig(), _front_end(recordings), list[NDArray[np.float32]]()

    def take(panoramas: ImageArray) -> None:
        parts.append(picture(panoramas))

    sessions = [read_session(one, front_end, positions, config, take, progress=progress) for one in recordings]
    return _joined(front_end, sessions, np.concatenate(parts))


def _front_end(recordings: Sequence[Recording]) -> FrontEnd:
    if not recordings:
        raise RecordingError("there is nothing to learn from: give at least one recording")
    config = MapConfig()
    return FrontEnd(*camera_and_size(recordings[0]), config.panorama, config.features)


def _joined(front_end: FrontEnd, sessions: Sequence[MappedSession], features: NDArray[np.float32]) -> Drives:
    xy = np.concatenate([one.xy for one in sessions])
    return Drives(front_end, features, xy, np.concatenate([one.heading_rad for one in sessions]))
