"""What a map of gazes may promise: drives are left out in turn, and parts of their horizon are covered.

A single drive cannot tell what another light will do; every third of its frames is held out then. Few patches can err
together more easily than many, so that every number of patches has bounds of its own.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.data import FloatArray, Status
from andante.mapping.gaze_lesson import GazeDrive
from andante.mapping.gaze_readout import GazeReadout, spaced_azimuths
from andante.mapping.gaze_votes import Verdict
from andante.mapping.uncertainty import LEAST_OFF_RAD, conformal_factor

COUNTS = (1, 3, 8, 24)
"""Of patches that are tried."""
_COVERED = (0.0, 0.25, 0.5)
_TRIED_FRAMES = 90
"""Of all drives together."""
_ANOTHER_DRIVE = 1.8
"""How much larger errors are on another drive than between the frames of one, as for whole images."""
_WRONG_M = 1.0
_LARGEST_MARGIN = 1e6
_OK_WRONG, _DEGRADED_WRONG = 0.01, 0.1
"""Of held-out frames with at least a margin, the share that may be wrong."""


@dataclass(frozen=True, slots=True)
class GazeBounds:
    """What holds for estimates of at least so many ``patches``: lost below one margin, degraded below another.

    ``ok_factor`` times the deviation of a verdict holds the truth for the configured share of held-out frames that are
    ok, ``degraded_factor`` for that of all which are not lost, and ``heading_rad`` their heading.
    """

    patches: int
    lost_below: float
    degraded_below: float
    ok_factor: float
    degraded_factor: float
    heading_rad: float

    def status(self, seen: Verdict) -> Status:
        """How far a verdict can be believed."""
        if seen.margin < self.lost_below:
            return Status.LOST
        return Status.OK if seen.margin >= self.degraded_below else Status.DEGRADED

    def radius_m(self, seen: Verdict) -> float:
        """The calibrated radius of a verdict."""
        return (self.ok_factor if seen.margin >= self.degraded_below else self.degraded_factor) * sigma_of(seen)


@dataclass(frozen=True, slots=True)
class _Try:
    """One held-out frame: errors in metres and radians, deviation and margin of what was said."""

    margin: float
    sigma_m: float
    error_m: float
    turn_rad: float


Learn = Callable[[Sequence[GazeDrive]], GazeReadout]


def sigma_of(seen: Verdict) -> float:
    """The expected error in metres of a verdict, before calibration."""
    return float(np.sqrt(np.trace(seen.covariance)))


def calibrated(drives: Sequence[GazeDrive], learn: Learn, coverage: float) -> tuple[GazeBounds, ...]:
    """Learn from all drives but one and look from that one, for every drive; bounds by rising number of patches."""
    rng = np.random.default_rng(0)
    tries: dict[int, list[_Try]] = {count: [] for count in COUNTS}
    for held_in, held_out in _folds(drives):
        readout = learn(held_in)
        shown = np.linspace(0, len(held_out) - 1, -(-_TRIED_FRAMES // len(drives))).astype(int)
        for number, frame in enumerate(np.unique(shown).tolist()):
            fields = covered(held_out.fields, frame, _COVERED[number % len(_COVERED)], rng)
            for count in COUNTS:
                seen = readout.look(fields, spaced_azimuths(count, rng.uniform(-np.pi, np.pi)))
                tries[count].append(_tried(seen, held_out.poses[frame]))
    unseen = _ANOTHER_DRIVE if len(drives) == 1 else 1.0
    return tuple(_bounds(count, tried, unseen, coverage) for count, tried in tries.items())


def least_margin(margin: FloatArray, wrong: NDArray[np.bool_], share: float) -> float:
    """The smallest margin (of n) such that of those at least as large no more than a ``share`` are ``wrong``."""
    order = np.argsort(-margin, kind="stable")
    errors = np.cumsum(wrong[order]) / np.arange(1, len(order) + 1)
    good = np.flatnonzero(errors <= share)
    # Where even the largest margin is one of a wrong place, nothing is promised.
    return float(margin[order[good[-1]]]) if len(good) else float(np.nextafter(margin.max(), np.inf))


def covered(fields: NDArray[np.float32], frame: int, share: float, rng: np.random.Generator) -> NDArray[np.float32]:
    """One of the fields (n, width, channels) with a part of its horizon from another: other things stand before it."""
    width = fields.shape[1]
    columns = (int(rng.integers(width)) + np.arange(round(share * width))) % width
    result: NDArray[np.float32] = fields[frame].copy()
    result[columns] = fields[int(rng.integers(len(fields)))][(columns + int(rng.integers(width))) % width]
    return result


def _folds(drives: Sequence[GazeDrive]) -> Iterator[tuple[list[GazeDrive], GazeDrive]]:
    if len(drives) > 1:
        for number, held_out in enumerate(drives):
            yield [*drives[:number], *drives[number + 1 :]], held_out
    else:
        third = np.arange(len(drives[0])) % 3 == 1
        yield [drives[0].subset(~third)], drives[0].subset(third)


def _tried(seen: Verdict, pose: FloatArray) -> _Try:
    error = float(np.linalg.norm(seen.xy - pose[:2]))
    return _Try(seen.margin, sigma_of(seen), error, abs(wrapped(seen.heading_rad - float(pose[2]))))


def _bounds(patches: int, tried: Sequence[_Try], unseen: float, coverage: float) -> GazeBounds:
    # Where all that was mapped is one place margins are infinite, which no file could hold.
    margin = np.minimum([one.margin for one in tried], _LARGEST_MARGIN)
    error = np.array([one.error_m for one in tried])
    sigma, turn = np.array([one.sigma_m for one in tried]), np.array([one.turn_rad for one in tried])
    wrong = error > _WRONG_M
    lost, degraded = (least_margin(margin, wrong, share) for share in (_DEGRADED_WRONG, _OK_WRONG))
    # Where nothing is ever ok or answered, no radius is asked for either.
    ok, answered = (np.where(margin >= least, True, not (margin >= least).any()) for least in (degraded, lost))
    ok_factor, factor = (unseen * conformal_factor(error[kept], sigma[kept], coverage) for kept in (ok, answered))
    heading = max(LEAST_OFF_RAD, unseen * float(np.quantile(turn[answered], coverage)))
    return GazeBounds(patches, lost, degraded, ok_factor, factor, heading)
