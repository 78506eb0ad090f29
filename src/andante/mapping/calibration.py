"""How wrong a map is on frames it has not seen, and what may be promised from that.

Whole sessions are left out in turn; a single session is cut into short blocks instead, which cannot tell what another
light or season will do. Slow features, metric and readout are learnt anew for every fold; only the compression to
principal components, which knows no positions, is shared.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Literal

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray
from andante.errors import LearningError
from andante.mapping.folds import Folds, Mask
from andante.mapping.learning import Ground
from andante.mapping.locating import Sighting
from andante.mapping.off_path import ViewBounds
from andante.mapping.uncertainty import conformal_factor

Kind = Literal["sessions", "blocks", "none"]
FoldLocator = Callable[[Mask, Mask], tuple[Sighting, FloatArray]]
"""Learns from the frames of the first mask, locates those of the second and says how like strangers they are."""

_STRANGERS: dict[str, tuple[float, float]] = {"sessions": (0.9, 0.99), "blocks": (0.5, 0.9)}
_FEW_DISAGREE = 0.01
_ANOTHER_DRIVE = 1.8
"""How much larger errors are on another drive, off this one's line, than between its frames: measured in gardens."""


@dataclass(frozen=True)
class Fold:
    """Errors of one held-out part, in metres or places; ``sessions`` are the numbers of those it came from."""

    left_out: str
    sessions: tuple[int, ...]
    n: int
    median: float
    mean: float
    p95: float
    max: float


@dataclass(frozen=True)
class Calibration:
    """What held-out frames allow to promise.

    ``radius_factor`` times the sigma of a sighting holds the truth for the configured share of held-out frames (split
    conformal, theory 9), ``heading_factor`` in radians times its doubt the heading, ``None`` where none is known. An
    image is off the map where its likeness is below ``off_map_below`` and degraded where likeness times agreement is
    below ``degraded_below``: what 90 % and 99 % of held-out images do not reach once their own place is taken off the
    map. Held-out blocks of one session show no other light, in which all likeness is smaller; there it is 50 % and
    90 %. Lost is where less than ``lost_below`` of the evidence agrees. ``usual_likeness`` is the median of held-out
    images; ``views`` is what holds for images from away of all mapped places.
    """

    kind: Kind
    radius_factor: float
    degraded_below: float
    lost_below: float
    off_map_below: float
    heading_factor: float | None = None
    usual_likeness: float | None = None
    views: ViewBounds | None = None
    folds: tuple[Fold, ...] = ()


def calibrate(
    ground: Ground, heading: FloatArray, folds: Folds, locate_fold: FoldLocator, coverage: float
) -> Calibration:
    """Cross-validate and turn held-out errors into factors and thresholds; ``heading`` (n,) is NaN where unknown."""
    tries, figures = list[_Held](), list[Fold]()
    for label, members, (train, test) in zip(folds.labels, folds.members, folds, strict=True):
        tried = _held_out(ground, heading, train, test, locate_fold)
        if tried is not None:
            tries.append(tried)
            figures.append(_fold(label, members, tried.error))
    if not tries:
        return Calibration("none", 3.0, 0.0, 0.0, 0.0)
    every = _Held.joined(tries)
    off_map, degraded = _quantiles(every.strangers, *_STRANGERS[folds.kind])
    promised, unseen = every, 1.0
    if folds.kind == "blocks":
        # In the middle of a block there is nothing near that is mapped; between two frames there is, as in a drive.
        every_third = np.arange(len(ground)) % 3 == 1
        promised, unseen = _held_out(ground, heading, ~every_third, every_third, locate_fold) or every, _ANOTHER_DRIVE
    turn = promised.turn[np.isfinite(promised.turn)]
    return Calibration(
        kind=folds.kind,
        radius_factor=unseen * conformal_factor(promised.error, promised.sigma, coverage),
        degraded_below=degraded,
        lost_below=min(0.5, float(np.quantile(every.agreement, _FEW_DISAGREE))),
        off_map_below=off_map,
        heading_factor=unseen * conformal_factor(turn, np.ones(len(turn)), coverage) if len(turn) else None,
        usual_likeness=float(np.median(promised.likeness)),
        folds=tuple(figures),
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Held:
    """Held-out frames (n,): how wrong they were, ``turn`` divided by the doubt, and m of their likes as strangers."""

    error: FloatArray
    turn: FloatArray
    sigma: FloatArray
    agreement: FloatArray
    likeness: FloatArray
    strangers: FloatArray

    @classmethod
    def joined(cls, parts: Sequence[_Held]) -> _Held:
        return cls(*(np.concatenate([getattr(part, one.name) for part in parts]) for one in fields(cls)))


def _held_out(ground: Ground, heading: FloatArray, train: Mask, test: Mask, locate_fold: FoldLocator) -> _Held | None:
    """``None`` where nothing is held out, or too little is left to learn from."""
    if not test.any() or test.all():
        return None
    try:
        sighting, strangers = locate_fold(train, test)
    except LearningError:
        return None
    located, bearings = sighting.located, sighting.bearings
    turn = np.full(len(located.xy), np.nan)
    if bearings is not None:
        turn = np.abs(wrapped(bearings.heading - heading[test])) / sighting.doubt
    error = np.linalg.norm(located.xy - ground.xy[test], axis=1)
    return _Held(error, turn, sighting.sigma, located.agreement, sighting.likeness, strangers)


def _quantiles(values: FloatArray, *shares: float) -> list[float]:
    """Zero where there are no values to go by."""
    return [float(np.quantile(values, share)) if len(values) else 0.0 for share in shares]


def _fold(label: str, members: tuple[int, ...], error: FloatArray) -> Fold:
    median, mean, p95, worst = np.median(error), error.mean(), np.quantile(error, 0.95), error.max()
    return Fold(label, members, len(error), float(median), float(mean), float(p95), float(worst))
