"""How wrong a map is on frames it has not seen, and what may be promised from that.

Whole sessions are left out in turn; a single session is cut into short blocks instead, which cannot tell what another
light or season will do. Slow features, metric and readout are learnt anew for every fold; only the compression to
principal components, which knows no positions, is shared.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal

import numpy as np

from andante.data import FloatArray
from andante.errors import LearningError
from andante.mapping.folds import Folds, Mask
from andante.mapping.learning import Ground
from andante.mapping.located import Located

Kind = Literal["sessions", "blocks", "none"]
FoldLocator = Callable[[Mask, Mask], tuple[Located, FloatArray]]
"""Learns from the frames of the first mask, locates those of the second and says how like strangers they are."""

_STRANGERS: dict[str, tuple[float, float]] = {"sessions": (0.9, 0.99), "blocks": (0.5, 0.9)}
_FEW_DISAGREE = 0.01


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

    ``radius_factor`` times a readout's sigma holds the truth for the configured share of held-out frames (split
    conformal, theory 9). An image is off the map where its likeness is below ``off_map_below`` and degraded where
    likeness times agreement is below ``degraded_below``: what 90 % and 99 % of held-out images do not reach once
    their own place is taken off the map. Held-out blocks of one session show no other light, in which all likeness is
    smaller; there it is 50 % and 90 %. Lost is where less than ``lost_below`` of the evidence agrees.
    """

    kind: Kind
    radius_factor: float
    degraded_below: float
    lost_below: float
    off_map_below: float
    folds: tuple[Fold, ...] = ()


def calibrate(ground: Ground, folds: Folds, locate_fold: FoldLocator, coverage: float) -> Calibration:
    """Cross-validate and turn held-out errors into a radius factor and thresholds."""
    errors, sigmas, agreement, strangers, figures = [], [], [], [], []
    for label, members, (train, test) in zip(folds.labels, folds.members, folds, strict=True):
        if not test.any() or test.all():
            continue
        try:
            located, strange = locate_fold(train, test)
        except LearningError:
            continue  # too little is left to learn from without this part: nothing can be said of it
        error = np.linalg.norm(located.xy - ground.xy[test], axis=1)
        errors.append(error)
        sigmas.append(located.sigma)
        agreement.append(located.agreement)
        strangers.append(strange)
        figures.append(_fold(label, members, error))
    if not errors:
        return Calibration("none", 3.0, 0.0, 0.0, 0.0)
    off_map, degraded = _quantiles(np.concatenate(strangers), *_STRANGERS[folds.kind])
    return Calibration(
        kind=folds.kind,
        radius_factor=conformal_factor(np.concatenate(errors), np.concatenate(sigmas), coverage),
        degraded_below=degraded,
        lost_below=min(0.5, float(np.quantile(np.concatenate(agreement), _FEW_DISAGREE))),
        off_map_below=off_map,
        folds=tuple(figures),
    )


def _quantiles(values: FloatArray, *shares: float) -> list[float]:
    """Zero where there are no values to go by."""
    return [float(np.quantile(values, share)) if len(values) else 0.0 for share in shares]


def conformal_factor(error: FloatArray, sigma: FloatArray, coverage: float) -> float:
    """The factor f with error <= f sigma for at least ``coverage`` of exchangeable new frames.

    The ceil((n + 1) coverage)-th smallest score of n; the largest where n is too small for that.
    """
    scores = np.sort(error / sigma)
    rank = int(np.ceil((len(scores) + 1) * coverage))
    return float(scores[min(rank, len(scores)) - 1])


def _fold(label: str, members: tuple[int, ...], error: FloatArray) -> Fold:
    median, mean, p95, worst = np.median(error), error.mean(), np.quantile(error, 0.95), error.max()
    return Fold(label, members, len(error), float(median), float(mean), float(p95), float(worst))
