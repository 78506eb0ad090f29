"""What a detector of landmarks finds, against what the simulator knows to be there (detection rates of thesis 7.4)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.evaluation.experiments.landmark_world import Seen
from andante.evaluation.experiments.outcome import Cell, Table
from andante.landmarks.boxes import SAME_PLACE_IOU, Box, Detection

_COLUMNS = (
    "landmark",
    "shown [%]",
    "found of these [%]",
    "overlap",
    "false [%]",
    "detected [%]",
    "thesis: detected [%]",
)
_ANY = "any of them"


@dataclass(frozen=True, slots=True)
class DetectionFigures:
    """Percentages of one landmark in one session; ``None`` where nothing was shown or found.

    ``shown``: frames that show it large enough; ``found``: of these, where the box is at the right place; ``overlap``:
    median intersection over union of the boxes at the right place; ``false``: frames with a box at another place;
    ``detected``: frames with a box at all, as the thesis counts.
    """

    shown: float
    found: float | None
    overlap: float | None
    false: float
    detected: float


def detection_figures(seen: Seen, name: str, detections: Sequence[Sequence[Detection]]) -> DetectionFigures:
    """Of all frames of a session (n), with what a detector says of each (n)."""
    column = seen.names.index(name)
    truth, shown = seen.boxes[:, column], seen.detectable[:, column]
    overlap = np.full(len(truth), np.nan)
    for frame, found in enumerate(detections):
        for one in found:
            if one.name == name:
                there = np.isfinite(truth[frame]).all()
                overlap[frame] = one.box.iou(Box(*truth[frame].tolist())) if there else 0.0
    detected = np.isfinite(overlap)
    right: NDArray[np.bool_] = detected & (overlap >= SAME_PLACE_IOU)
    return DetectionFigures(
        shown=_percent(shown),
        found=_percent(right[shown]) if shown.any() else None,
        overlap=float(np.median(overlap[right])) if right.any() else None,
        false=_percent(detected & ~right),
        detected=_percent(detected),
    )


def detection_table(
    title: str,
    seen: Seen,
    names: Sequence[str],
    detections: Sequence[Sequence[Detection]],
    thesis: Sequence[float],
) -> tuple[Table, dict[str, Any]]:
    """A row for each landmark and one for all; ``thesis`` are its detection rates, the last that of any landmark."""
    figures = {name: detection_figures(seen, name, detections) for name in names}
    columns = [seen.names.index(name) for name in names]
    any_shown = np.asarray(seen.detectable[:, columns].any(axis=1))
    any_detected = np.array([any(one.name in names for one in found) for found in detections])
    rows: list[tuple[Cell, ...]] = [
        (name, one.shown, one.found, one.overlap, one.false, one.detected, theirs)
        for (name, one), theirs in zip(figures.items(), thesis[:-1], strict=False)
    ]
    rows.append((_ANY, _percent(any_shown), None, None, None, _percent(any_detected), thesis[-1]))
    return Table(title, _COLUMNS, tuple(rows)), {name: asdict(one) for name, one in figures.items()}


def _percent(which: NDArray[np.bool_]) -> float:
    return 100.0 * float(which.mean())
