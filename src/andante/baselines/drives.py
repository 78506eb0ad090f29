"""Drives as panoramas with poses, for methods that learn from the pictures themselves."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from andante.data import FloatArray, Frame, FrameInfo, ImageArray, PoseSource, Trajectory
from andante.errors import RecordingError
from andante.mapping import FrontEnd, MapConfig, Progress
from andante.mapping.sessions import usable_frames
from andante.protocols import Recording
from andante.recordings import map_frames


@dataclass(frozen=True, eq=False)
class Drives:
    """The frames of some drives, one after the other.

    ``panoramas`` (n, height, width) grey uint8, ``xy`` (n, 2) metres, ``heading`` (n,) radians and NaN where unknown;
    ``skipped`` pictures could not be read or showed nothing. ``seconds`` went into all this.
    """

    panoramas: ImageArray = field(repr=False)
    xy: FloatArray = field(repr=False)
    heading: FloatArray = field(repr=False)
    skipped: int
    seconds: float


def read_drives(
    recordings: Sequence[Recording],
    front_end: FrontEnd,
    positions: PoseSource,
    *,
    progress: Progress | None = None,
) -> Drives:
    """All frames with a position where the robot was not standing still, in order.

    Raises ``RecordingError`` for recordings without such frames, with too many unreadable ones, and for the odometry of
    several drives, each of which begins in a frame of its own.
    """
    if positions == "odometry" and len(recordings) > 1:
        raise RecordingError(
            f"the odometry of {len(recordings)} recordings is in as many frames; give one recording, or reference "
            "positions"
        )
    start = time.perf_counter()
    parts = [_read(recording, front_end.for_recording(recording), positions, progress) for recording in recordings]
    panoramas = np.concatenate([pictures for pictures, _, _ in parts])
    poses = np.concatenate([rows for _, rows, _ in parts])
    skipped = sum(count for _, _, count in parts)
    return Drives(panoramas, poses[:, :2], poses[:, 2], skipped, time.perf_counter() - start)


def _read(
    recording: Recording, front_end: FrontEnd, positions: PoseSource, progress: Progress | None
) -> tuple[ImageArray, FloatArray, int]:
    """Panoramas (n, height, width), poses (n, 3) and how many frames were skipped."""
    indices, _ = usable_frames(recording, positions, MapConfig())
    infos, panoramas, skipped = list[FrameInfo](), list[ImageArray](), list[str]()

    def panorama(frame: Frame) -> ImageArray:
        return front_end.grey_panorama(frame.image)

    def on_skip(info: FrameInfo, reason: str) -> None:
        skipped.append(reason)

    for info, picture in map_frames(recording, panorama, indices, on_skip=on_skip):
        infos.append(info)
        panoramas.append(picture)
        if progress is not None:
            progress(recording.name, len(infos) + len(skipped), len(indices))
    track = Trajectory.of(infos, positions)
    return np.stack(panoramas), np.column_stack([track.xy_m, track.heading_rad]), len(skipped)
