"""A map that was made from odometry lies in a frame of its own; to measure its errors it is laid over the truth once.

One rotation and one translation, no scale, fitted on the drives that the map was made from (Umeyama 1991), and only
where their truth is not to be had on the estimates themselves, as is usual for trajectories without a common frame.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from andante.data import FloatArray, Pose2D, Trajectory
from andante.errors import RecordingError
from andante.evaluation.running import LocalizedFrame, Run
from andante.mapping import MappedSession, SlowMap
from andante.recordings import open_recording

_FEWEST = 3


@dataclass(frozen=True, slots=True)
class Alignment:
    """The map's frame in that of the truth: ``rotation_rad``, then ``translation_m`` (x, y); ``source`` says from what.

    ``residual_m`` is the mean distance that remains between what it was fitted to.
    """

    rotation_rad: float
    translation_m: tuple[float, float]
    residual_m: float
    source: str

    def __str__(self) -> str:
        x, y = self.translation_m
        turn = math.degrees(self.rotation_rad)
        return (
            f"the map's own frame is laid over the truth by a turn of {turn:.2f} degrees and a shift of ({x:.3f}, "
            f"{y:.3f}) m without scale, fitted on {self.source}, {self.residual_m:.3f} m apart in the mean there"
        )

    def out_of_map(self, xy: FloatArray) -> FloatArray:
        """Positions (n, 2) in the map's frame as the truth has them."""
        moved: FloatArray = xy @ _rotation(self.rotation_rad).T + np.array(self.translation_m)
        return moved

    def into_map(self, pose: Pose2D) -> Pose2D:
        """A true pose as the map would have it."""
        cos, sin = math.cos(self.rotation_rad), math.sin(self.rotation_rad)
        x, y = pose.x_m - self.translation_m[0], pose.y_m - self.translation_m[1]
        heading = None if pose.heading_rad is None else pose.heading_rad - self.rotation_rad
        return Pose2D(cos * x + sin * y, cos * y - sin * x, heading)

    def truth_in_map(self, run: Run) -> Run:
        """The same run with its reference poses in the map's frame; distances to them stay what they are."""
        return replace(run, frames=tuple(self._moved(frame) for frame in run.frames))

    def _moved(self, frame: LocalizedFrame) -> LocalizedFrame:
        reference = frame.info.reference
        if reference is None:
            return frame
        return replace(frame, info=replace(frame.info, reference=self.into_map(reference)))


def alignment_of(slowmap: SlowMap, run: Run) -> Alignment | None:
    """How to lay the map's frame over the truth: from its own drives where they can be found, else from a run.

    ``None`` where neither has three true positions.
    """
    own = _mapped_pairs(slowmap)
    if own is not None:
        return fit_rigid(*own)
    poses = [(frame.estimate, frame.info.reference) for frame in run.frames]
    pairs = [((e.x_m, e.y_m), (r.x_m, r.y_m)) for e, r in poses if e.x_m is not None and r is not None]
    if len(pairs) < _FEWEST:
        return None
    mapped, truth = np.array(pairs, dtype=np.float64).transpose(1, 0, 2)
    return fit_rigid(mapped, truth, "these estimates themselves")


def fit_rigid(mapped: FloatArray, truth: FloatArray, source: str) -> Alignment:
    """Rotation and translation from ``mapped`` to ``truth``, both (n, 2), with least squares."""
    centre, goal = mapped.mean(axis=0), truth.mean(axis=0)
    a, b = mapped - centre, truth - goal
    turn = math.atan2(float((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum()), float((a * b).sum()))
    matrix = _rotation(turn)
    shift = goal - matrix @ centre
    residual = float(np.linalg.norm(mapped @ matrix.T + shift - truth, axis=1).mean())
    return Alignment(turn, (float(shift[0]), float(shift[1])), residual, source)


def _rotation(angle_rad: float) -> FloatArray:
    cos, sin = math.cos(angle_rad), math.sin(angle_rad)
    return np.array([[cos, -sin], [sin, cos]])


def _mapped_pairs(slowmap: SlowMap) -> tuple[FloatArray, FloatArray, str] | None:
    """Where the map has its frames and where they truly were, both (n, 2), and which drives that is known of."""
    mapped, truth, names = list[FloatArray](), list[FloatArray](), list[str]()
    for session in slowmap.memory or ():
        poses = _true_positions(session)
        if poses is None:
            continue
        known = np.isfinite(poses).all(axis=1)
        mapped.append(session.xy[known])
        truth.append(poses[known])
        names.append(session.source.name)
    if sum(len(part) for part in mapped) < _FEWEST:
        return None
    return np.concatenate(mapped), np.concatenate(truth), f"the mapped drives {', '.join(names)}"


def _true_positions(session: MappedSession) -> FloatArray | None:
    """Reference positions (n, 2) of a session, where its recording is found unchanged."""
    if session.source.folder is None:
        return None
    try:
        recording = open_recording(session.source.folder)
        if recording.content_hash() != session.source.content_hash:
            return None
        return Trajectory.of([recording.infos[number] for number in session.number.tolist()], "reference").xy_m
    except (RecordingError, IndexError):
        return None
