"""What a map of gazes is compared with besides whole images: landmarks, and gazes that a perfect tracker followed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np

from andante.data import Estimate, FloatArray, ImageArray
from andante.errors import RecordingError
from andante.evaluation.experiments.gaze_following import TrueSight
from andante.evaluation.experiments.landmark_trials import album_of
from andante.evaluation.experiments.landmark_world import landmarks_seen_often, seen
from andante.evaluation.experiments.trials import Bench
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.views import ViewCutter
from andante.mapping.gaze_lesson import GazeDrive
from andante.mapping.landmarks import LandmarkMap
from andante.sequences.gaze import region_azimuths
from andante.sfa import one_thread
from andante.simulator import Plan, SimulatedRecording

LANDMARKS = 3
"""Of figure 7.16."""
_TURN = 2.0 * np.pi
_LEAST_VISIBLE = 0.5
_DECIMALS = 4


@dataclass(frozen=True, slots=True, eq=False)
class Covered:
    """A grey picture (height, width), a ``share`` of whose horizon is hidden, counter-clockwise from ``start_rad``."""

    picture: ImageArray
    start_rad: float = 0.0
    share: float = 0.0

    def visible(self, box: Box) -> Box | None:
        """The larger part of a box that is not hidden, ``None`` where that is less than half of its width."""
        if not self.share:
            return box
        width, hidden = box.width_rad, _TURN * self.share
        start = float(np.mod(self.start_rad - box.right_rad, _TURN))
        parts = (max(0.0, start + hidden - _TURN), min(start, width)), (start + hidden, width)
        low, high = max(parts, key=lambda part: part[1] - part[0])
        if high - low < _LEAST_VISIBLE * width:
            return None
        return Box.between(box.right_rad + high, box.right_rad + low, box.low_rad, box.high_rad)


@dataclass(frozen=True, eq=False)
class LandmarkRival:
    """Landmarks that nearly every mapped frame shows, found as well as the simulator's boxes tell."""

    landmarks: LandmarkMap
    names: tuple[str, ...]
    seed: int

    @classmethod
    def learn(cls, bench: Bench, sessions: Sequence[str], seed: int) -> LandmarkRival:
        """From the mapped sessions, in each of which boxes are wrong in their own way, and in others than in tests."""
        names = landmarks_seen_often(seen(bench, sessions[0]), LANDMARKS)
        seeds = {session: seed + 1 + number for number, session in enumerate(sessions)}
        album = album_of(bench, sessions, names, lambda one: seen(bench, one).detections(names, seeds[one]))
        with one_thread():
            return cls(LandmarkMap.learn(album), tuple(names), seed)

    def answers(self, bench: Bench, session: str, pictures: Sequence[Covered]) -> list[Estimate]:
        """What landmarks say of a session whose pictures, all of them, were partly hidden."""
        recording, found = bench.recording(session), seen(bench, session).detections(self.names, self.seed)
        cutter, told = ViewCutter(recording.camera, pictures[0].picture.shape[:2]), list[Estimate]()
        with one_thread():
            for covered, detections in zip(pictures, found, strict=True):
                boxes = [(one, box) for one in detections if (box := covered.visible(one.box)) is not None]
                visible = [Detection(box, one.name, one.score) for one, box in boxes]
                told.append(self.landmarks.estimate(self.landmarks.signature(covered.picture, visible, cutter)))
        return told


def truly_followed(bench: Bench, session: str, drive: GazeDrive) -> GazeDrive:
    """A drive whose gazes follow things as the simulator knows them to stand, instead of a plane sweep.

    Raises ``RecordingError`` for a drive that leaves out frames of the session.
    """
    if len(drive) != len(bench.recording(session).infos):
        raise RecordingError(f"session {session!r} has {len(bench.recording(session).infos)} frames, got {len(drive)}")
    key = {"gaze_distances": bench.plan.fingerprint(session), "regions": drive.distance_m.shape[1]}
    stored = bench.store.load(key)
    if stored is None:
        rows = list[FloatArray]()
        tasks: list[_Task] = [
            (bench.plan, session, index, drive.distance_m.shape[1], (float(x), float(y), float(heading)))
            for index, (x, y, heading) in enumerate(drive.poses)
        ]
        for row in bench.spread(_distances, tasks):
            rows.append(row)
            bench.progress(f"distances {session}", len(rows), len(drive))
        known = np.nan_to_num(np.round(np.stack(rows), _DECIMALS), nan=-1.0)
        stored = {"distance_m": known.tolist()}
        bench.store.save(key, stored)
    distance = np.array(stored["distance_m"], np.float64)
    distance[distance < 0] = np.nan
    return replace(drive, distance_m=distance)


_Task = tuple[Plan, str, int, int, tuple[float, float, float]]
"""A session of a plan, the number of a frame, of regions, and the pose of the frame."""


def _distances(task: _Task) -> FloatArray:
    """(K,) metres to what each region of one frame looks at, NaN for the sky."""
    plan, session, index, regions, pose = task
    poses = np.full((index + 1, 3), np.nan)
    poses[index] = pose
    return TrueSight(_recording(plan, session), poses).distances(index, region_azimuths(regions))


@lru_cache(maxsize=1)
def _recording(plan: Plan, session: str) -> SimulatedRecording:
    return SimulatedRecording(plan, session)
