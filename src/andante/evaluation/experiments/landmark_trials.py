"""Landmarks learnt from one session and tried on another."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

from andante.data import Estimate, FloatArray, Frame
from andante.evaluation.experiments.landmark_world import TRAIN, seen
from andante.evaluation.experiments.trials import Bench
from andante.landmarks.boxes import Detection
from andante.landmarks.views import ViewCutter
from andante.mapping.landmark_config import LandmarkConfig
from andante.mapping.landmark_lesson import Album, collect
from andante.mapping.landmark_sights import Sight
from andante.mapping.landmarks import LandmarkMap
from andante.sfa import one_thread


@dataclass(frozen=True, eq=False)
class Trialled:
    """Landmarks on one test session: what each says of every frame that shows it, by frame and landmark."""

    landmarks: LandmarkMap
    truth: FloatArray
    sights: tuple[tuple[Sight, ...], ...]
    estimates: tuple[Estimate, ...]

    @property
    def shown(self) -> list[int]:
        """Frames that show a landmark."""
        return [frame for frame, sights in enumerate(self.sights) if sights]


def learnt(bench: Bench, names: Sequence[str], seed: int) -> LandmarkMap:
    """Landmarks from the drive that is mapped."""
    with one_thread():
        return LandmarkMap.learn(album_of(bench, TRAIN, seen(bench, TRAIN).detections(names, seed)))


def album_of(bench: Bench, session: str, detections: Sequence[Sequence[Detection]]) -> Album:
    """Views of all landmarks in a session."""
    recording = bench.recording(session)
    camera = bench.plan.camera
    cutter = ViewCutter(recording.camera, (camera.height_px, camera.width_px))

    def spot(frame: Frame) -> Sequence[Detection]:
        return detections[frame.info.index]

    return collect([(recording, cutter, spot)], LandmarkConfig().window)


def tried_on(landmarks: LandmarkMap, album: Album) -> Trialled:
    """What mapped landmarks say of the frames of an album."""
    rows: list[list[Sight]] = [[] for _ in range(len(album))]
    by_name = {one.name: one for one in album.views}
    with one_thread():
        for model in landmarks.models:
            views = by_name.get(model.name)
            if views is None:
                continue
            located = model.locate(views.pictures)
            for k, frame in enumerate(views.frame.tolist()):
                agreement = float(located.agreement[k])
                rows[frame].append(Sight(model, views.boxes[k], located.xy[k], located.covariance[k], agreement))
    estimates = tuple(landmarks.estimate_of(row) for row in rows)
    return Trialled(landmarks, album.poses, tuple(map(tuple, rows)), estimates)
