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
from numpy.typing import NDArray

from andante.data import FloatArray, IndexArray
from andante.errors import LearningError
from andante.mapping.config import CalibrationConfig
from andante.mapping.learning import Ground
from andante.mapping.located import Located

Kind = Literal["sessions", "blocks", "none"]
FoldLocator = Callable[[NDArray[np.bool_], NDArray[np.bool_]], tuple[Located, FloatArray]]
"""Learns from the frames of the first mask, locates those of the second and says how like strangers they are."""

_STRANGERS: dict[str, tuple[float, float]] = {"sessions": (0.9, 0.99), "blocks": (0.5, 0.9)}
_FEW_DISAGREE = 0.01


@dataclass(frozen=True)
class Fold:
    """Errors of one held-out part, in metres or places."""

    left_out: str
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


def calibrate(ground: Ground, names: list[str], locate_fold: FoldLocator, config: CalibrationConfig) -> Calibration:
    """Cross-validate and turn held-out errors into a radius factor and thresholds."""
    kind, fold_of, labels = _folds(ground, names, config)
    errors, sigmas, agreement, strangers, folds = [], [], [], [], []
    for fold, label in enumerate(labels):
        test = fold_of == fold
        if not test.any() or test.all():
            continue
        try:
            located, strange = locate_fold(~test, test)
        except LearningError:
            continue  # too little is left to learn from without this part: nothing can be said of it
        error = np.linalg.norm(located.xy - ground.xy[test], axis=1)
        errors.append(error)
        sigmas.append(located.sigma)
        agreement.append(located.agreement)
        strangers.append(strange)
        folds.append(_fold(label, error))
    if not errors:
        return Calibration("none", 3.0, 0.0, 0.0, 0.0)
    off_map, degraded = _quantiles(np.concatenate(strangers), *_STRANGERS[kind])
    return Calibration(
        kind=kind,
        radius_factor=conformal_factor(np.concatenate(errors), np.concatenate(sigmas), config.coverage),
        degraded_below=degraded,
        lost_below=min(0.5, float(np.quantile(np.concatenate(agreement), _FEW_DISAGREE))),
        off_map_below=off_map,
        folds=tuple(folds),
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


def _folds(ground: Ground, names: list[str], config: CalibrationConfig) -> tuple[Kind, IndexArray, list[str]]:
    """The fold of every frame (n,) and the name of every fold."""
    sessions = np.unique(ground.session)
    if len(sessions) > 1:
        count = min(len(sessions), config.folds)
        fold_of = np.searchsorted(sessions, ground.session) % count
        labels = [" + ".join(names[int(s)] for s in sessions[fold::count]) for fold in range(count)]
        return "sessions", fold_of, labels
    # Long enough that the neighbours of most frames are gone, short enough that a place remains near.
    block = config.block_m or 4 * ground.radius
    steps = np.linalg.norm(np.diff(ground.xy, axis=0), axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(steps)])
    fold_of = (travelled // block).astype(np.int64) % config.folds
    return "blocks", fold_of, [f"blocks {fold + 1} of {config.folds}" for fold in range(config.folds)]


def _fold(label: str, error: FloatArray) -> Fold:
    median, mean, p95, worst = np.median(error), error.mean(), np.quantile(error, 0.95), error.max()
    return Fold(label, len(error), float(median), float(mean), float(p95), float(worst))
