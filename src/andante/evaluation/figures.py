"""Errors and what is said of them: over all frames with truth, so that saying "lost" improves nothing."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.data import Estimate, FloatArray, FrameInfo, Status, Trajectory
from andante.errors import ArrayError
from andante.evaluation.running import Run
from andante.mapping.slow_map import Unit

WRONG_M = 1.0
"""Beyond it a pose is wrong, and a confident one a mistake that a robot pays for."""


@dataclass(frozen=True, kw_only=True, slots=True)
class PlaceFigures:
    """Errors in numbered places; ``share_within_k`` of the frames are at most k places off."""

    median: float | None = None
    mean: float | None = None
    p95: float | None = None
    max: float | None = None
    share_within_1: float | None = None
    share_within_3: float | None = None
    share_within_10: float | None = None


@dataclass(frozen=True, kw_only=True)
class ErrorFigures:
    """``n_errors`` errors in metres, or in ``places``; ``None`` where there is nothing to say."""

    n_errors: int
    median_m: float | None = None
    mean_m: float | None = None
    p95_m: float | None = None
    max_m: float | None = None
    share_over_1m: float | None = None
    share_over_3m: float | None = None
    places: PlaceFigures | None = None


@dataclass(frozen=True, kw_only=True)
class HeadingFigures:
    """Errors of headings in degrees, from 0 to 180; ``None`` where there is nothing to say."""

    heading_median_deg: float | None = None
    heading_mean_deg: float | None = None
    heading_p95_deg: float | None = None
    heading_max_deg: float | None = None


@dataclass(frozen=True, kw_only=True)
class Figures(ErrorFigures, HeadingFigures):
    """One localizer on one recording.

    The errors are those of the best hypothesis of all ``n`` frames with truth, whatever their status; only the
    ``unlocalized`` ones, whose picture shows nothing, have none, and headings likewise. ``answered`` are the errors of
    those with a pose alone, ``lost_share`` is the share of the others, ``statuses`` counts both. ``coverage_90`` is the
    share of answered frames whose error is within ``radius_m``, ``confident_wrong_share`` that of all frames with truth
    whose status is ok and whose error is more than a metre. ``ms_per_image`` is wall time with decoding, in all threads
    together; ``ms_localize`` the median of what follows decoding, in one thread.
    """

    n: int
    lost_share: float | None
    unlocalized: int
    coverage_90: float | None
    confident_wrong_share: float | None = None
    ms_per_image: float | None
    ms_localize: float | None
    statuses: Mapping[str, int]
    answered: ErrorFigures

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: ``None`` for what is unknown, never NaN."""
        return asdict(self)


def figures_of(errors: FloatArray, unit: Unit = "m") -> ErrorFigures:
    """Summarise errors (n,) in metres or places; raises ``ArrayError`` for NaN or another shape.

    The 95th percentile interpolates linearly between frames.
    """
    errors = np.asarray(errors, dtype=np.float64)
    if errors.ndim != 1 or not np.isfinite(errors).all():
        raise ArrayError(
            f"errors must be finite numbers of shape (n,), got shape {errors.shape}; drop unknown ones first"
        )
    if unit == "place":
        return ErrorFigures(n_errors=len(errors), places=_place_figures(errors))
    if not len(errors):
        return ErrorFigures(n_errors=0)
    return ErrorFigures(
        n_errors=len(errors),
        median_m=float(np.median(errors)),
        mean_m=float(errors.mean()),
        p95_m=float(np.quantile(errors, 0.95)),
        max_m=float(errors.max()),
        share_over_1m=float((errors > 1).mean()),
        share_over_3m=float((errors > 3).mean()),
    )


def figures_of_run(run: Run, unit: Unit) -> Figures:
    """Figures over all frames of a run that have truth."""
    infos = [frame.info for frame in run.frames]
    has_truth = np.isfinite(truth_of(infos, unit)[:, 0])
    errors = errors_of(run, unit)
    known = np.isfinite(errors)
    answered = has_truth & np.array([frame.estimate.status.has_pose for frame in run.frames], dtype=bool)
    n = int(has_truth.sum())
    counts = Counter(frame.estimate.status for frame, true in zip(run.frames, has_truth, strict=True) if true)
    seconds = [frame.seconds for frame in run.frames]
    return Figures(
        **vars(figures_of(errors[known], unit)),
        n=n,
        lost_share=1 - float(answered.sum()) / n if n else None,
        unlocalized=int((has_truth & ~known).sum()),
        coverage_90=_coverage(run, errors, answered & known),
        confident_wrong_share=_confident_and_wrong(run, errors) / n if n and unit == "m" else None,
        **vars(heading_figures(heading_errors_of(run))),
        ms_per_image=1000 * run.wall_s / len(seconds) if seconds else None,
        ms_localize=1000 * float(np.median(seconds)) if seconds else None,
        statuses={str(status): counts[status] for status in Status},
        answered=figures_of(errors[answered & known], unit),
    )


def errors_of(run: Run, unit: Unit) -> FloatArray:
    """(n,) how far the best hypothesis of every frame is from the truth; NaN where either is unknown."""
    truth = truth_of([frame.info for frame in run.frames], unit)
    guesses = np.array([best_guess(frame.estimate, unit) for frame in run.frames]).reshape(-1, 2)
    errors: FloatArray = np.linalg.norm(guesses - truth, axis=1)
    return errors


def heading_errors_of(run: Run) -> FloatArray:
    """(n,) degrees, 0 to 180, between the best hypothesis' heading and the reference; NaN where either is unknown."""
    truth = Trajectory.of([frame.info for frame in run.frames], "reference").heading_rad
    guesses = np.array([best_heading(frame.estimate) for frame in run.frames], dtype=np.float64)
    return apart_deg(guesses, truth)


def apart_deg(one_rad: FloatArray, other_rad: FloatArray) -> FloatArray:
    """(n,) degrees, 0 to 180, between headings."""
    return np.asarray(np.degrees(np.abs(wrapped(one_rad - other_rad))), dtype=np.float64)


def truth_of(infos: Iterable[FrameInfo], unit: Unit) -> FloatArray:
    """(n, 2) reference positions in metres, or the place number and zero; NaN where unknown."""
    if unit == "m":
        return Trajectory.of(infos, "reference").xy_m
    return np.array([(np.nan if info.place is None else info.place, 0.0) for info in infos]).reshape(-1, 2)


def best_guess(estimate: Estimate, unit: Unit) -> tuple[float, float]:
    """The pose, else the best hypothesis, whatever the status: metres, or a whole place and zero; NaN without any."""
    if unit == "m" and estimate.x_m is not None and estimate.y_m is not None:
        return estimate.x_m, estimate.y_m
    if not estimate.hypotheses:
        return np.nan, np.nan
    best = estimate.hypotheses[0]
    return (best.x_m, best.y_m) if unit == "m" else (float(round(best.x_m)), 0.0)


def best_heading(estimate: Estimate) -> float:
    """The heading in radians, or that of the best hypothesis where a status allows none; NaN without any."""
    heading = estimate.heading_rad
    if not estimate.status.has_pose and estimate.hypotheses:
        heading = estimate.hypotheses[0].heading_rad
    return math.nan if heading is None else heading


def heading_figures(errors_deg: FloatArray) -> HeadingFigures:
    """Summarise errors (n,) in degrees; NaN ones are left out."""
    known = errors_deg[np.isfinite(errors_deg)]
    if not len(known):
        return HeadingFigures()
    return HeadingFigures(
        heading_median_deg=float(np.median(known)),
        heading_mean_deg=float(known.mean()),
        heading_p95_deg=float(np.quantile(known, 0.95)),
        heading_max_deg=float(known.max()),
    )


def _place_figures(errors: FloatArray) -> PlaceFigures:
    if not len(errors):
        return PlaceFigures()
    return PlaceFigures(
        median=float(np.median(errors)),
        mean=float(errors.mean()),
        p95=float(np.quantile(errors, 0.95)),
        max=float(errors.max()),
        share_within_1=float((errors <= 1).mean()),
        share_within_3=float((errors <= 3).mean()),
        share_within_10=float((errors <= 10).mean()),
    )


def _confident_and_wrong(run: Run, errors: FloatArray) -> int:
    """How many frames are sure of a pose that is more than a metre off."""
    confident = np.array([frame.estimate.status is Status.OK for frame in run.frames], dtype=bool)
    return int((confident & (errors > WRONG_M)).sum())


def _coverage(run: Run, errors: FloatArray, counted: NDArray[np.bool_]) -> float | None:
    radii = np.array([frame.estimate.radius_m for frame in run.frames], dtype=np.float64)
    counted = counted & np.isfinite(radii)
    return float((errors[counted] <= radii[counted]).mean()) if counted.any() else None
