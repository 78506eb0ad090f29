"""The frames of drives that a reconstruction is made from, their key points and where they were taken."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from andante.baselines.structure.keypoints import Keypoints
from andante.baselines.structure.localizer import Extractor
from andante.data import FloatArray, Frame, IndexArray, PoseSource, Trajectory
from andante.errors import RecordingError
from andante.mapping import Progress
from andante.protocols import Recording
from andante.recordings import map_frames

FEWEST = 10


@dataclass(frozen=True, slots=True, eq=False)
class Keyframes:
    """Key points of n frames, ``xy`` (n, 2) metres, ``heading`` (n,) radians or NaN, number of the drive (n,)."""

    keypoints: Sequence[Keypoints]
    xy: FloatArray
    heading: FloatArray
    session: IndexArray

    def __len__(self) -> int:
        return len(self.keypoints)


def read_keyframes(
    recordings: Sequence[Recording],
    extractor: Extractor,
    *,
    positions: PoseSource,
    every_m: float,
    progress: Progress | None,
) -> Keyframes:
    """Decode what was chosen of each drive and find its key points.

    Raises ``RecordingError`` for cameras that differ, too few frames with positions, and odometry of several drives.
    """
    _check(recordings, positions)
    ways = [Trajectory.of(recording.infos, positions) for recording in recordings]
    chosen = [spaced(way.xy_m, every_m) for way in ways]
    total, keypoints, poses = sum(len(one) for one in chosen), list[Keypoints](), list[tuple[float, ...]]()
    if total < FEWEST:
        names = ", ".join(repr(recording.name) for recording in recordings)
        raise RecordingError(
            f"{total} frames of {names} have a {positions} position and lie {every_m:g} m apart, at least {FEWEST} are "
            "needed to reconstruct anything; use a longer drive or a smaller every_m"
        )

    def extract(frame: Frame) -> Keypoints:
        return extractor.keypoints(frame.image)

    for number, (recording, way, indices) in enumerate(zip(recordings, ways, chosen, strict=True)):
        for info, found in map_frames(recording, extract, indices):
            keypoints.append(found)
            poses.append((*way.xy_m[info.index], way.heading_rad[info.index], number))
            if progress is not None:
                progress("key points", len(keypoints), total)
    xy, heading, session = np.split(np.array(poses), [2, 3], axis=1)
    return Keyframes(keypoints, xy, heading[:, 0], session[:, 0].astype(np.int64))


def spaced(xy: FloatArray, every_m: float) -> list[int]:
    """Indices of positions (n, 2) that lie at least ``every_m`` from all chosen before; NaN is never chosen."""
    chosen: list[int] = []
    for index in np.flatnonzero(np.isfinite(xy).all(axis=1)).tolist():
        distance = np.linalg.norm(xy[chosen] - xy[index], axis=1).min(initial=math.inf)
        if distance >= every_m:
            chosen.append(index)
    return chosen


def _check(recordings: Sequence[Recording], positions: PoseSource) -> None:
    if not recordings:
        raise RecordingError("no recording was given; a reconstruction needs at least one drive")
    first = recordings[0]
    for other in recordings[1:]:
        if other.camera != first.camera:
            raise RecordingError(
                f"recordings {first.name!r} and {other.name!r} come from different cameras; use drives of one camera"
            )
    if positions == "odometry" and len(recordings) > 1:
        raise RecordingError(
            f"the odometry of each of {len(recordings)} drives has a frame of its own; use one drive, or reference "
            "positions"
        )
