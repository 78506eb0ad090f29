"""How long a localizer is without a pose that it is sure of, and right to be."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, Status
from andante.evaluation.figures import WRONG_M

LASTING_FRAMES = 10
"""So many frames in a row are no lucky guess."""


@dataclass(frozen=True, kw_only=True, slots=True)
class Recovery:
    """``outages`` in frames: the ``first`` from the start, the ``median`` and the ``worst`` of all.

    ``None`` where the recording ended first; an outage that never ended counts in ``unrecovered`` and, as long as it
    was seen to last, in ``median`` and ``worst``.
    """

    outages: int
    unrecovered: int
    first: int | None
    median: float | None
    worst: int | None


def recovery_of(statuses: Sequence[Status], errors: FloatArray) -> Recovery:
    """Outages of a track whose frames have these statuses and errors (n,) in metres, NaN where there is no truth.

    A frame is *settled* where its status is ok and its error at most 1 m. An outage begins at the first frame, and
    after it was over at every frame without a pose (lost, off the map) or with one that is more than 1 m off. It is
    over at the first of ten settled frames in a row, or of fewer where the recording ends with them; its length are the
    frames before that one. Being degraded and right neither begins nor ends an outage. Frames without truth are left
    out, as if they were not there.
    """
    known = np.isfinite(errors)
    off = errors[known]
    said = [status for status, counted in zip(statuses, known, strict=True) if counted]
    settled = np.array([status is Status.OK for status in said], dtype=bool) & (off <= WRONG_M)
    failing = np.array([not status.has_pose for status in said], dtype=bool) | (off > WRONG_M)
    lengths, unrecovered = _outages(settled, failing)
    ended = len(lengths) - unrecovered
    return Recovery(
        outages=len(lengths),
        unrecovered=unrecovered,
        first=lengths[0] if ended else None,
        median=float(np.median(lengths)) if lengths else None,
        worst=max(lengths, default=None),
    )


def frames_to_settle(settled: NDArray[np.bool_], start: int = 0) -> int | None:
    """Frames from ``start`` to the first of a lasting run of ``settled`` (n,) ones; ``None`` where there is none."""
    run = 0
    for at in range(start, len(settled)):
        run = run + 1 if settled[at] else 0
        if run == LASTING_FRAMES or (run and at == len(settled) - 1):
            return at + 1 - run - start
    return None


def _outages(settled: NDArray[np.bool_], failing: NDArray[np.bool_]) -> tuple[list[int], int]:
    """The lengths of all outages, and whether the last one never ended: 0 or 1."""
    lengths, start = list[int](), 0
    while start < len(settled):
        waited = frames_to_settle(settled, start)
        if waited is None:
            return [*lengths, len(settled) - start], 1
        lengths.append(waited)
        again = np.flatnonzero(failing[start + waited :])
        if not len(again):
            break
        start += waited + int(again[0])
    return lengths, 0
