"""A map on a recording that it has not seen, beside what plain methods make of the same features."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from andante.baselines import fit_baselines
from andante.data import FloatArray
from andante.errors import LeakageError, RecordingError
from andante.evaluation.alignment import alignment_of
from andante.evaluation.figures import Figures, errors_of, figures_of_run, truth_of
from andante.evaluation.running import FeatureLocalizer, Run, run_on_features
from andante.evaluation.verdict import verdict
from andante.mapping import Progress, SlowMap
from andante.mapping.sessions import MAX_SHARED_PICTURES
from andante.mapping.slow_map import Unit
from andante.protocols import Recording

ODOMETRY_NOTE = "the map was made from odometry, and there is no truth to lay its frame over"
_TRAINING_NOTE = "training error: the map was learnt from this recording, unseen ones will be worse"


@dataclass(frozen=True)
class Scored:
    """One localizer on the recording: its estimates, their errors (n,) with NaN where unknown, and the figures."""

    name: str
    run: Run = field(repr=False)
    errors: FloatArray = field(repr=False)
    figures: Figures


@dataclass(frozen=True)
class Evaluation:
    """A map and, where asked for, its baselines on one recording; ``notes`` say what to keep in mind."""

    recording: Recording
    unit: Unit
    map: Scored
    others: tuple[Scored, ...] = ()
    notes: tuple[str, ...] = ()

    @property
    def figures(self) -> Figures:
        """The figures of the map."""
        return self.map.figures

    @property
    def run(self) -> Run:
        """What the map said of every frame."""
        return self.map.run

    @property
    def baselines(self) -> dict[str, Figures]:
        """The figures of the baselines by name; empty where they were not asked for."""
        return {one.name: one.figures for one in self.others}

    @property
    def verdict(self) -> str | None:
        """Whether the map beats its baselines, in one sentence; ``None`` without baselines."""
        return verdict(self.figures, self.baselines)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: the map's figures, and those of the baselines by name."""
        return {
            **self.figures.as_dict(),
            "recording": self.recording.name,
            "unit": self.unit,
            "baselines": {name: figures.as_dict() for name, figures in self.baselines.items()},
            "verdict": self.verdict,
            "notes": list(self.notes),
            "skipped": [{"image": skipped.image, "reason": skipped.reason} for skipped in self.run.skipped],
        }


def evaluate(
    slowmap: SlowMap,
    recording: Recording,
    *,
    baselines: bool = False,
    training: Sequence[Recording] | None = None,
    training_error: bool = False,
    progress: Progress | None = None,
) -> Evaluation:
    """Localize every frame of a recording and compare with its reference poses or place numbers.

    All frames are localized, those with truth are counted. ``baselines`` also fits other methods to the frames that
    the map was made from: those of ``training``, or else found where the map found them. Raises ``LeakageError`` for
    a recording that the map was learnt from, or that has more than 5 % of its pictures in common with those, unless
    ``training_error`` asks for just that, and ``RecordingError`` for one without truth. A map that was made from
    odometry is laid over the truth by one rotation and translation, which a note states (see ``alignment_of``).
    """
    notes = _checked_notes(slowmap, recording, training_error)
    slowmap = slowmap.for_recording(recording)
    localizers: list[FeatureLocalizer] = [slowmap]
    if baselines:
        localizers += fit_baselines(slowmap, training or (), progress=progress)
    runs = run_on_features(localizers, slowmap.front_end, recording, progress=progress)
    if slowmap.config.positions == "odometry":
        alignment = alignment_of(slowmap, runs[0])
        notes = (*notes, ODOMETRY_NOTE if alignment is None else str(alignment))
        runs = runs if alignment is None else [alignment.truth_in_map(run) for run in runs]
    unit = slowmap.unit
    first, *others = (
        Scored(localizer.name, run, errors_of(run, unit), figures_of_run(run, unit))
        for localizer, run in zip(localizers, runs, strict=True)
    )
    return Evaluation(recording, unit, first, tuple(others), notes)


def _checked_notes(slowmap: SlowMap, recording: Recording, training_error: bool) -> tuple[str, ...]:
    """Refuse what would give no figures or misleading ones; gives what has to be said of the others."""
    if not np.isfinite(truth_of(recording.infos, slowmap.unit)).all(axis=1).any():
        lacking = "place numbers (place" if slowmap.unit == "place" else "reference poses (x_m, y_m"
        raise RecordingError(
            f"recording {recording.name!r} has no {lacking} in frames.csv) to compare with; "
            "use andante localize for estimates without figures"
        )
    return leakage_notes(slowmap, recording, training_error)


def leakage_notes(slowmap: SlowMap, recording: Recording, training_error: bool) -> tuple[str, ...]:
    """What to say of a recording that the map was learnt from; ``LeakageError`` unless its error is asked for."""
    learnt = slowmap.learnt_from(recording.content_hash())
    if not learnt and slowmap.share_learnt(recording) <= MAX_SHARED_PICTURES:
        return ()
    if not training_error:
        raise LeakageError(
            f"the map was learnt from {'' if learnt else 'pictures of '}recording {recording.name!r}, so its "
            "errors would look better than they are; evaluate on another drive, or ask for the training error "
            "(--training-error)"
        )
    return (_TRAINING_NOTE,)
