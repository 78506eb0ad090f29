"""Thesis 7.4: localization on views of landmarks in a small and in a large garden, and with one to ten landmarks."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.data import Estimate, FloatArray
from andante.evaluation.experiments.contenders import ANDANTE, THESIS
from andante.evaluation.experiments.landmark_scaling import curve_plot, curve_table, scaling
from andante.evaluation.experiments.landmark_trials import Boxes, Trialled, album_of, boxes_by, learnt, tried_on
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
from andante.sfa import one_thread

SCALED = 10
"""Landmarks of figure 7.12."""
_WEAK = 3.0
_KEYS = ("share_percent", "median_m", "mean_m", "p95_m", "heading_median_deg", "thesis_median_m")
_COLUMNS = ("localizer", "frames [%]", "median [m]", "mean [m]", "95 % [m]", "heading [deg]", "thesis: median [m]")
_NOTES = (
    BOXES_NOTE,
    "the thesis' single landmarks are others in other gardens: they stand beside ours for the order of magnitude",
    "whole images are judged on the frames in which at least one landmark is seen, as in the thesis",
    "both: whole image and landmarks joined by calibrated covariance",
)


@dataclass(frozen=True, slots=True)
class Case:
    """A test session in a garden with ``count`` landmarks, and the thesis' medians: of each, of all, of Fourier-SFA."""

    title: str
    session: str
    singles: tuple[float, ...]
    combined: float
    fourier: float

    @property
    def count(self) -> int:
        """Number of landmarks."""
        return len(self.singles)


_SMALL = Case("18 x 18 m, a random drive mapped, a grid localized (table 7.1)", TEST, (0.18, 0.27, 0.27), 0.16, 0.26)
_LARGE = (
    Case("57 x 44 m, other light (table 7.3, set 1)", FIRST, (1.74, 2.44, 1.46, 3.54), 2.22, 7.50),
    Case("57 x 44 m, quite other light, other things (table 7.3, set 2)", SECOND, (2.06, 2.97, 1.83, 3.80), 2.57, 8.22),
)


def run_landmarks(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """Tables 7.1 and 7.3 and figure 7.12."""
    large = bench.beside(large_plan(seed, scale))
    often = landmarks_seen_often(seen(bench, TRAIN), SCALED)
    parts = landmarks_of_parts(seen(large, TRAIN), _LARGE[0].count)
    tables, figures = list[Table](), dict[str, Any]()
    boxes, large_boxes = boxes_by(bench, often, seed, scale), boxes_by(large, parts, seed, scale)
    table, figures[_SMALL.title] = _compared(bench, often[: _SMALL.count], _SMALL, boxes)
    tables.append(table)
    for case in _LARGE:
        table, figures[case.title] = _compared(large, parts, case, large_boxes)
        tables.append(table)
    curve = scaling(bench, often, boxes, seed, permutations=scale.permutations)
    figures["scaling"] = curve
    return Outcome((*tables, curve_table(curve)), (curve_plot(curve),), figures, (ANDANTE, THESIS), _NOTES)


def _compared(bench: Bench, names: Sequence[str], case: Case, boxes: Boxes) -> tuple[Table, dict[str, Any]]:
    """Each landmark, all of them together, and whole images, on one test session."""
    session = case.session
    landmarks = learnt(bench, names, boxes)
    tried = tried_on(landmarks, album_of(bench, session, names, boxes))
    shown = np.array(tried.shown)
    bench.progress(f"landmarks {session}", 1, 3)
    rows: list[tuple[Cell, ...]] = []
    for name, theirs in zip(names, case.singles, strict=False):
        alone = [(frame, one) for frame, row in enumerate(tried.sights) for one in row if one.model.name == name]
        frames = np.array([frame for frame, _ in alone], int)
        rows.append(
            _row(f"landmark {name}", tried.truth, frames, np.array([one.xy for _, one in alone]), thesis=theirs)
        )
    by_error = np.array([fused(tried.sights[f], "inverse-error", 0.0).pose for f in shown])
    rows.append(_row("combined by inverse error", tried.truth, shown, by_error, thesis=case.combined))
    rows.append(_estimates_row("combined", tried, tried.estimates, case.combined))
    whole = _whole_image(bench, learned(bench, [TRAIN]), session)
    bench.progress(f"landmarks {session}", 2, 3)
    both = [joined(one, other) for one, other in zip(whole, tried.estimates, strict=True)]
    (fourier,) = bench.run([Trial(THESIS, (Drive(TRAIN),), Drive(session))])
    rows.append(_row("whole image, thesis' choices", tried.truth, shown, fourier.xy[shown], thesis=case.fourier))
    rows.append(_estimates_row("whole image, andante", tried, whole, None))
    rows.append(_estimates_row("both", tried, both, None))
    bench.progress(f"landmarks {session}", 3, 3)
    radius = np.array([tried.estimates[f].radius_m for f in shown], np.float64)
    error = np.linalg.norm(_guesses(tried.estimates)[shown] - tried.truth[shown, :2], axis=1)
    return Table(case.title, _COLUMNS, tuple(rows)), {
        "localizers": {str(row[0]): dict(zip(_KEYS, row[1:], strict=True)) for row in rows},
        "coverage_90": float((error <= radius).mean()),
        "correlation": landmarks.calibration.correlation,
        "frames": len(tried.truth),
        "weak_places": len(landmarks.weak_places(_WEAK * landmarks.calibration.usual_radius_m)),
    }


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
    shown = np.array(tried.shown)
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
