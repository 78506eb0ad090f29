"""What a map of gazes may promise: drives are left out in turn, and parts of their horizon are covered.

A single drive cannot tell what another light will do; every third of its frames is held out then.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.data import FloatArray
from andante.features import PatchEncoder
from andante.mapping.gaze_config import GazeConfig
from andante.mapping.gaze_lesson import GazeDrive, gallery_of, learn_gaze
from andante.mapping.gaze_votes import Rules, Verdict, verdict
from andante.mapping.uncertainty import LEAST_OFF_RAD, conformal_factor

FLOOR_M = 0.03
"""No position is told more finely than this, before calibration."""
_COVERED = (0.0, 0.25, 0.5)
_TRIED_FRAMES = 40
_ANOTHER_DRIVE = 1.8
"""How much larger errors are on another drive than between the frames of one, as for whole images."""
_WRONG_M = 1.0
_OK_WRONG, _DEGRADED_WRONG = 0.01, 0.1
"""Of held-out frames with at least a margin, the share that may be wrong."""


@dataclass(frozen=True, slots=True)
class GazeBounds:
    """An estimate is lost below one margin and degraded below another.

    ``radius_factor`` times the deviation of a verdict (and ``FLOOR_M``) holds the truth for the configured share of
    held-out frames that are not lost; ``heading_rad`` holds their heading.
    """

    lost_below: float
    degraded_below: float
    radius_factor: float
    heading_rad: float

    def radius_m(self, seen: Verdict) -> float:
        """The calibrated radius of a verdict."""
        return self.radius_factor * sigma_of(seen)


@dataclass(frozen=True, slots=True, eq=False)
class _Tried:
    """Held-out frames (n,): margin, error in metres, deviation, and error of the heading in radians."""

    margin: FloatArray
    error: FloatArray
    sigma: FloatArray
    turn: FloatArray


def sigma_of(seen: Verdict) -> float:
    """The expected error in metres of a verdict, before calibration."""
    return float(np.sqrt(np.trace(seen.covariance) + FLOOR_M**2))


def calibrated(drives: Sequence[GazeDrive], encoder: PatchEncoder, config: GazeConfig, rules: Rules) -> GazeBounds:
    """Learn from all drives but one, look from that one, for every drive."""
    rng = np.random.default_rng(0)
    rows = [
        row for held_in, held_out in _folds(drives) for row in _tried(held_in, held_out, encoder, config, rules, rng)
    ]
    tried = _Tried(*np.array(rows).T)
    wrong = tried.error > _WRONG_M
    lost, degraded = (least_margin(tried.margin, wrong, share) for share in (_DEGRADED_WRONG, _OK_WRONG))
    kept = (tried.margin >= lost) & ~wrong
    if not kept.any():
        kept[:] = True
    unseen = _ANOTHER_DRIVE if len(drives) == 1 else 1.0
    factor = conformal_factor(tried.error[kept], tried.sigma[kept], config.coverage)
    turn = float(np.quantile(tried.turn[kept], config.coverage))
    return GazeBounds(lost, degraded, unseen * factor, max(LEAST_OFF_RAD, unseen * turn))


def least_margin(margin: FloatArray, wrong: NDArray[np.bool_], share: float) -> float:
    """The smallest margin (of n) such that of those at least as large no more than a ``share`` are ``wrong``."""
    order = np.argsort(-margin, kind="stable")
    errors = np.cumsum(wrong[order]) / np.arange(1, len(order) + 1)
    good = np.flatnonzero(errors <= share)
    # Where even the largest margin is one of a wrong place, nothing is promised.
    return float(margin[order[good[-1]]]) if len(good) else float(np.nextafter(margin.max(), np.inf))


def _folds(drives: Sequence[GazeDrive]) -> Iterator[tuple[list[GazeDrive], GazeDrive]]:
    if len(drives) > 1:
        for number, held_out in enumerate(drives):
            yield [*drives[:number], *drives[number + 1 :]], held_out
    else:
        third = np.arange(len(drives[0])) % 3 == 1
        yield [drives[0].subset(~third)], drives[0].subset(third)


def _tried(
    held_in: list[GazeDrive],
    held_out: GazeDrive,
    encoder: PatchEncoder,
    config: GazeConfig,
    rules: Rules,
    rng: np.random.Generator,
) -> Iterator[tuple[float, float, float, float]]:
    model = learn_gaze(held_in, encoder, config)
    gallery = gallery_of(held_in, encoder, model, config)
    chosen = np.unique(np.linspace(0, len(held_out) - 1, _TRIED_FRAMES).astype(int))
    azimuth = 2 * np.pi * np.arange(config.patches) / config.patches
    for number, frame in enumerate(chosen.tolist()):
        fields = covered(held_out.fields[frame], _COVERED[number % len(_COVERED)], held_out.fields, rng)
        slow = model.transform(encoder.cut(fields[None], azimuth[None])[0])
        seen = verdict(gallery, slow, azimuth, rules)
        x, y, heading = held_out.poses[frame]
        error = float(np.hypot(*(seen.xy - (x, y))))
        yield seen.margin, error, sigma_of(seen), abs(wrapped(seen.heading_rad - heading))


def covered(
    fields: NDArray[np.float32], share: float, others: NDArray[np.float32], rng: np.random.Generator
) -> NDArray[np.float32]:
    """Fields (width, channels) with a part of the horizon taken from elsewhere: other things stand before it."""
    width = len(fields)
    columns = (int(rng.integers(width)) + np.arange(round(share * width))) % width
    other = others[int(rng.integers(len(others)))]
    result = fields.copy()
    result[columns] = other[(columns + int(rng.integers(width))) % width]
    return result
