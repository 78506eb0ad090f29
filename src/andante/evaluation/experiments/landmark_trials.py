"""Landmarks learnt from one session and tried on another."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import asdict, astuple, dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from andante import landmarks
from andante.data import Estimate, FloatArray, Frame
from andante.evaluation.experiments.cache import source_hash
from andante.evaluation.experiments.landmark_world import TRAIN, seen
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.trials import Bench
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.views import ViewCutter
from andante.mapping.landmark_config import LandmarkConfig
from andante.mapping.landmark_lesson import Album, collect
from andante.mapping.landmark_sights import Sight, sights_in
from andante.mapping.landmarks import LandmarkMap
from andante.sfa import one_thread

if TYPE_CHECKING:
    from andante.landmarks.training import TrainingConfig

_STEPS, _MAX_SECONDS = 1000, 1200.0


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


Boxes = Callable[[str], list[list[Detection]]]
"""A session -> what a detector says of every frame."""


def boxes_by(bench: Bench, names: Sequence[str], seed: int, scale: Scale) -> Boxes:
    """The detector that the scale asks for, of landmarks with these names."""
    return _learnt_boxes(bench, names, seed) if scale.detector == "learnt" else simulated_boxes(bench, names, seed)


def simulated_boxes(bench: Bench, names: Sequence[str], seed: int) -> Boxes:
    """What is visible, as wrong as a detector's boxes are; another draw for the mapped drive than for tests."""
    return lambda session: seen(bench, session).detections(names, seed + (session != TRAIN))


def _learnt_boxes(bench: Bench, names: Sequence[str], seed: int) -> Boxes:
    """Of a detector that takes its labels from the mapped drive; what it finds in all sessions is kept.

    Needs the extras ``torch``, ``onnx`` and ``landmarks``.
    """
    from andante.landmarks.training import TrainingConfig

    # Nobody waits for it beside a robot: on a busy machine it may take longer, so as to end by itself.
    config = TrainingConfig(seed=seed, steps=_STEPS, max_seconds=_MAX_SECONDS)
    key = {
        "learnt_boxes": list(names),
        "sessions": {one.name: bench.plan.fingerprint(one.name) for one in bench.plan.sessions},
        "config": asdict(config),
        "code": source_hash(Path(landmarks.__file__).parent, Path(__file__)),
    }
    stored = bench.store.load(key)
    if stored is None:
        stored = {"sessions": _found_by_learnt(bench, names, seed, config)}
        bench.store.save(key, stored)
    found = {
        session: [[Detection(Box(*box), name, score) for name, score, box in frame] for frame in frames]
        for session, frames in stored["sessions"].items()
    }
    return found.__getitem__


def _found_by_learnt(bench: Bench, names: Sequence[str], seed: int, config: TrainingConfig) -> dict[str, Any]:
    """By session and frame the name, score and box of all that is found, as plain values."""
    from andante.landmarks.labels import Labels
    from andante.landmarks.training import train_detector

    recording, frames = bench.recording(TRAIN), simulated_boxes(bench, names, seed)(TRAIN)
    labels = []
    for name in names:
        boxes = {k: one.box for k, frame in enumerate(frames) for one in frame if one.name == name}
        labels.append(Labels(name, recording.name, boxes, frozenset(range(len(frames))) - boxes.keys()))
    detector = train_detector([(recording, labels)], config, progress=bench.progress)
    found = dict[str, Any]()
    for session in bench.plan.sessions:
        drive, rows = bench.recording(session.name), list[Any]()
        for frame in drive.frames():  # grey, as maps look at them
            rows.append([(one.name, one.score, astuple(one.box)) for one in detector.detect(frame.image, drive.camera)])
            bench.progress(f"detect {session.name}", len(rows), len(drive.infos))
        found[session.name] = rows
    return found


def learnt(bench: Bench, names: Sequence[str], boxes: Boxes) -> LandmarkMap:
    """Landmarks with these names from the drive that is mapped."""
    with one_thread():
        return LandmarkMap.learn(album_of(bench, [TRAIN], names, boxes))


def album_of(bench: Bench, sessions: Sequence[str], names: Sequence[str], boxes: Boxes) -> Album:
    """Views of the landmarks with these names in some sessions."""
    camera = bench.plan.camera
    drives = []
    for session in sessions:
        recording, detections = bench.recording(session), boxes(session)

        def spot(frame: Frame, detections: list[list[Detection]] = detections) -> Sequence[Detection]:
            return [one for one in detections[frame.info.index] if one.name in names]

        drives.append((recording, ViewCutter(recording.camera, (camera.height_px, camera.width_px)), spot))
    return collect(drives, LandmarkConfig().window)


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
            for frame, sight in zip(views.frame.tolist(), sights_in(model, views.boxes, located), strict=True):
                rows[frame].append(sight)
    estimates = tuple(landmarks.estimate_of(row) for row in rows)
    return Trialled(landmarks, album.poses, tuple(map(tuple, rows)), estimates)
