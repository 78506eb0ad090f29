"""Drives as every method on the map's front end learns from them: the frames, positions and features of a map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, PoseSource
from andante.errors import RecordingError
from andante.mapping import FrontEnd, MapConfig, Progress, encode_session
from andante.mapping.codes import Codes
from andante.mapping.frontend import camera_and_size
from andante.mapping.odometry import in_one_frame
from andante.protocols import Recording


@dataclass(frozen=True, eq=False)
class MappedDrives:
    """n frames: ``features`` (n, d) float32 and positions ``xy`` (n, 2)."""

    front_end: FrontEnd
    features: NDArray[np.float32] = field(repr=False)
    xy: FloatArray = field(repr=False)


def mapped_drives(
    recordings: Sequence[Recording], positions: PoseSource, *, progress: Progress | None = None
) -> MappedDrives:
    """The frames that the default map would learn from, with its features as it remembers them.

    Where only odometry is known, drives are laid over each other as for a map. Raises ``RecordingError`` for recordings
    without positions or with too many unreadable pictures.
    """
    config, front_end = MapConfig(), default_front_end(recordings)
    sessions = [encode_session(one, front_end, positions, config, progress=progress) for one in recordings]
    if positions == "odometry":
        sessions, _ = in_one_frame([], list(zip(sessions, recordings, strict=True)), config.drift)
    features = Codes.joined([one.codes for one in sessions]).rows()
    return MappedDrives(front_end, features, np.concatenate([one.xy for one in sessions]))


def default_front_end(recordings: Sequence[Recording]) -> FrontEnd:
    """The default map's, for the camera of the first recording; raises ``RecordingError`` where there is none."""
    if not recordings:
        raise RecordingError("there is nothing to learn from: give at least one recording")
    config = MapConfig()
    return FrontEnd(*camera_and_size(recordings[0]), config.panorama, config.features)
