"""Thesis 7.4: localization on views of landmarks in a small and in a large garden, and with one to ten landmarks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.baselines import MethodOptions, make_methods
from andante.data import Estimate, FloatArray
from andante.errors import MissingExtraError
from andante.evaluation.compare import Entry
from andante.evaluation.experiments.comparison import entered
from andante.evaluation.experiments.contenders import ANDANTE, THESIS
from andante.evaluation.experiments.landmark_detection import detection_table
from andante.evaluation.experiments.landmark_scaling import curve_plot, curve_table, scaling
from andante.evaluation.experiments.landmark_trials import (
    Boxes,
    Trialled,
    album_of,
    boxes_by,
    learnt,
    simulated_boxes,
    tried_on,
)
from andante.evaluation.experiments.landmark_world import (
    BOXES_NOTE,
    FIRST,
    SECOND,
    TEST,
    TRAIN,
    landmarks_of_parts,
    landmarks_seen_often,
    large_plan,
    seen,
)
from andante.evaluation.experiments.outcome import Cell, Outcome, Table
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.tracking import learned
from andante.evaluation.experiments.trials import Bench, Drive, Trial
from andante.evaluation.figures import best_guess
from andante.mapping import SlowMap
from andante.mapping.frontend import Encoded
from andante.mapping.landmark_joint import joined
from andante.mapping.landmark_sights import fused
from andante.mapping.landmarks import LandmarkMap
from andante.sfa import one_thread

SCALED = 10
"""Landmarks of figure 7.12."""
_WEAK = 3.0
_KEYS = ("share_percent", "median_m", "mean_m", "p95_m", "heading_median_deg", "thesis_median_m")
_COLUMNS = ("localizer", "frames [%]", "median [m]", "mean [m]", "95 % [m]", "heading [deg]", "thesis: median [m]")
_LONG = 1000
"""Frames from which on learners may take the time of the thesis' scale."""
_VERDICTS = {True: "reached", False: "not reached"}
_DETECTORS = {
    "simulator": BOXES_NOTE,
    "learnt": "boxes of a detector that learnt from labels of the mapped drive; these labels are " + BOXES_NOTE,
}
_NOTES = (
    "the thesis' single landmarks are others in other gardens: they stand beside ours for the order of magnitude",
    "whole images are judged on the frames in which at least one landmark is seen, as in the thesis",
    "both: the pose of the whole image, refined by where landmarks are seen",
    "combined: without views that are like no mapped one, where another is; single landmarks and the combination by "
    "inverse error, as in the thesis, take all of them",
)


@dataclass(frozen=True, slots=True)
class Case:
    """A test session in a garden with ``count`` landmarks, and what the thesis got there.

    Its medians of each landmark, of all, of Fourier-SFA and PoseNet; percentages of frames in which it ``detected``
    each landmark and, last, any; the ``goal_m`` is for the median of all landmarks together.
    """

    title: str
    session: str
    singles: tuple[float, ...]
    combined: float
    fourier: float
    posenet: float
    detected: tuple[float, ...]
    goal_m: float

    @property
    def count(self) -> int:
        """Number of landmarks."""
        return len(self.singles)


_SMALL = Case(
    title="18 x 18 m, a random drive mapped, a grid localized (table 7.1)",
    session=TEST,
    singles=(0.18, 0.27, 0.27),
    combined=0.16,
    fourier=0.26,
    posenet=0.21,
    detected=(99.0, 99.0, 97.0, 100.0),
    goal_m=0.10,
)
_LARGE = (
    Case(
        title="57 x 44 m, other light (table 7.3, set 1)",
        session=FIRST,
        singles=(1.74, 2.44, 1.46, 3.54),
        combined=2.22,
        fourier=7.50,
        posenet=2.99,
        detected=(32.0, 16.0, 13.0, 25.0, 78.0),
        goal_m=1.0,
    ),
    Case(
        title="57 x 44 m, quite other light, other things (table 7.3, set 2)",
        session=SECOND,
        singles=(2.06, 2.97, 1.83, 3.80),
        combined=2.57,
        fourier=8.22,
        posenet=6.57,
        detected=(32.0, 17.0, 13.0, 28.0, 80.0),
        goal_m=1.0,
    ),
)
_COMBINED = "combined"


def run_landmarks(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """Tables 7.1 and 7.3 and figure 7.12."""
    large = bench.beside(large_plan(seed, scale))
    often = landmarks_seen_often(seen(bench, TRAIN), SCALED)
    parts = landmarks_of_parts(seen(large, TRAIN), _LARGE[0].count)
    boxes = boxes_by(bench, often, seed, scale)
    small = _Place(bench, often[: _SMALL.count], boxes, seed, scale)
    big = _Place(large, parts, boxes_by(large, parts, seed, scale), seed, scale)
    tables, figures, notes = list[Table](), dict[str, Any](), [*_NOTES, _DETECTORS[scale.detector]]
    for place, case in ((small, _SMALL), *((big, case) for case in _LARGE)):
        found, figures[case.title] = _compared(place, case)
        tables += found
        notes.append(_goal(case, figures[case.title]["localizers"][_COMBINED]["median_m"]))
    notes += [note for place in (small, big) if (note := place.posenet_note) is not None]
    curve = scaling(bench, often, boxes, seed, permutations=scale.permutations)
    figures["scaling"] = curve
    return Outcome((*tables, curve_table(curve)), (curve_plot(curve),), figures, (ANDANTE, THESIS), tuple(notes))


@dataclass(frozen=True)
class _Place:
    """A garden whose drive ``TRAIN`` is mapped, and all that learns from it, each once."""

    bench: Bench
    names: Sequence[str]
    boxes: Boxes
    seed: int
    scale: Scale

    @cached_property
    def landmarks(self) -> LandmarkMap:
        return learnt(self.bench, self.names, self.boxes)

    @cached_property
    def slowmap(self) -> SlowMap:
        return learned(self.bench, [TRAIN])

    @cached_property
    def posenet(self) -> Entry | None:
        """PoseNet on all test sessions, ``None`` where it cannot be had."""
        quick = self.scale.frames < _LONG
        try:
            (method,) = make_methods(["posenet"], MethodOptions(seed=self.seed, quick=quick))
        except MissingExtraError:
            return None
        tests = [session.name for session in self.bench.plan.sessions if session.name != TRAIN]
        return entered(self.bench, method, TRAIN, tests, quick=quick)

    @property
    def posenet_note(self) -> str | None:
        """How PoseNet was trained, or why it is left out."""
        if self.posenet is None:
            return "PoseNet is left out: it needs torch; pip install 'andante[torch]'"
        size = f"{self.bench.plan.garden.size_x_m:g} x {self.bench.plan.garden.size_y_m:g} m"
        return f"PoseNet, {size}: {self.posenet.failure or '; '.join(self.posenet.notes)}"


def _goal(case: Case, median_m: float | None) -> str:
    reached = median_m is not None and median_m <= case.goal_m
    told = "unknown" if median_m is None else f"{median_m:.3f} m"
    return f"goal, {case.title}: median of all landmarks <= {case.goal_m:.2f} m: {_VERDICTS[reached]} with {told}"


def _compared(place: _Place, case: Case) -> tuple[list[Table], dict[str, Any]]:
    """Each landmark, all of them together, and whole images, on one test session; and what was detected there."""
    bench, names, session, landmarks = place.bench, place.names, case.session, place.landmarks
    detections = place.boxes(session)
    tried = tried_on(landmarks, album_of(bench, [session], names, place.boxes))
    shown = np.array(tried.shown, np.intp)
    bench.progress(f"landmarks {session}", 1, 4)
    rows: list[tuple[Cell, ...]] = []
    for name, theirs in zip(names, case.singles, strict=False):
        alone = [(frame, one) for frame, row in enumerate(tried.sights) for one in row if one.model.name == name]
        frames = np.array([frame for frame, _ in alone], int)
        rows.append(
            _row(f"landmark {name}", tried.truth, frames, np.array([one.xy for _, one in alone]), thesis=theirs)
        )
    by_error = np.array([fused(tried.sights[f], "inverse-error", 0.0).pose for f in shown]).reshape(-1, 3)
    rows.append(_row("combined by inverse error", tried.truth, shown, by_error, thesis=case.combined))
    rows.append(_estimates_row(_COMBINED, tried, tried.estimates, case.combined))
    if place.scale.detector == "learnt":
        ideal = simulated_boxes(bench, names, place.seed)
        other = tried_on(learnt(bench, names, ideal), album_of(bench, [session], names, ideal))
        rows.append(_estimates_row("combined, boxes of the simulator", other, other.estimates, None))
    whole = _whole_image(bench, place.slowmap, session)
    bench.progress(f"landmarks {session}", 2, 4)
    both = [joined(*parts) for parts in zip(whole, tried.estimates, tried.sights, strict=True)]
    (fourier,) = bench.run([Trial(THESIS, (Drive(TRAIN),), Drive(session))])
    rows.append(_row("whole image, thesis' choices", tried.truth, shown, fourier.xy[shown], thesis=case.fourier))
    bench.progress(f"landmarks {session}", 3, 4)
    if place.posenet is not None and place.posenet.failure is None:
        told = place.posenet.tests[session]
        poses = np.column_stack([told.xy, told.heading_rad])[shown]
        rows.append(_row("whole image, PoseNet", tried.truth, shown, poses, thesis=case.posenet))
    rows.append(_estimates_row("whole image, andante", tried, whole, None))
    rows.append(_estimates_row("both", tried, both, None))
    bench.progress(f"landmarks {session}", 4, 4)
    title = f"{case.title}: what was detected"
    detected, rates = detection_table(title, seen(bench, session), names, detections, case.detected)
    return [detected, Table(case.title, _COLUMNS, tuple(rows))], {
        "detected": rates,
        "localizers": {str(row[0]): dict(zip(_KEYS, row[1:], strict=True)) for row in rows},
        "coverage_90": _coverage(tried),
        "correlation": landmarks.calibration.correlation,
        "frames": len(tried.truth),
        "weak_places": len(landmarks.weak_places(_WEAK * landmarks.calibration.usual_radius_m)),
    }


def _coverage(tried: Trialled) -> float | None:
    """The share of poses that are within the radius that is told with them; ``None`` where none is told."""
    told = [
        (one.radius_m, float(np.hypot(one.x_m - x, one.y_m - y)))
        for one, (x, y, _) in zip(tried.estimates, tried.truth.tolist(), strict=True)
        if one.radius_m is not None and one.x_m is not None and one.y_m is not None
    ]
    return float(np.mean([error <= radius for radius, error in told])) if told else None


def _whole_image(bench: Bench, slowmap: SlowMap, session: str) -> list[Estimate]:
    drive = bench.drive(Drive(session), ANDANTE.config)
    phases = drive.session.phase.rows()
    with one_thread():
        return [
            slowmap.estimate(Encoded(features[None], phase[None]))
            for features, phase in zip(drive.features, phases, strict=True)
        ]


def _guesses(estimates: Sequence[Estimate]) -> FloatArray:
    return np.array([best_guess(one, "m") for one in estimates]).reshape(-1, 2)


def _estimates_row(name: str, tried: Trialled, estimates: Sequence[Estimate], thesis: float | None) -> tuple[Cell, ...]:
    shown = np.array(tried.shown, np.intp)
    heading = np.array([one.heading_rad for one in estimates], np.float64)
    poses = np.column_stack([_guesses(estimates), heading])[shown]
    return _row(name, tried.truth, shown, poses, thesis=thesis)


def _row(
    name: str, truth: FloatArray, frames: NDArray[np.integer[Any]], poses: FloatArray, *, thesis: float | None
) -> tuple[Cell, ...]:
    """Figures of ``poses`` (k, 2) or, with headings, (k, 3) in some ``frames`` (k,) of a session."""
    if not len(frames):
        return name, 0.0, None, None, None, None, thesis
    error = np.linalg.norm(poses[:, :2] - truth[frames, :2], axis=1)
    turn = np.degrees(np.abs(wrapped(poses[:, 2] - truth[frames, 2]))) if poses.shape[1] > 2 else np.array([np.nan])
    heading = float(np.nanmedian(turn)) if np.isfinite(turn).any() else None
    share, late = 100.0 * len(frames) / len(truth), float(np.quantile(error, 0.95))
    return name, share, float(np.median(error)), float(error.mean()), late, heading, thesis
