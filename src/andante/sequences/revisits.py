"""Where a drive comes back to a place it has seen before, from features and a gate of odometry."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from andante.data import FloatArray, IndexArray
from andante.errors import ArrayError, ConfigError, RecordingError
from andante.sequences.likeness import centred_cosine, checked_features

_MOST_FRAMES = 10_000
"""Of one drive: every pair of them is looked at, in 2 GB."""
_AROUND_M = 1.5
"""Frames this close to a match along the path look like it and are no rivals."""


@dataclass(frozen=True, slots=True)
class Revisits:
    """Frames ``later`` (c,) that show the place of frames ``earlier`` (c,), with a ``confidence`` (c,) in 0..1."""

    earlier: IndexArray
    later: IndexArray
    confidence: FloatArray

    def __len__(self) -> int:
        return len(self.earlier)

    @property
    def pairs(self) -> IndexArray:
        """(c, 2) as ``close_wire_loop`` takes them."""
        return np.column_stack([self.earlier, self.later])


def find_loop_closures(
    features: ArrayLike,
    odometry: ArrayLike,
    *,
    min_travel_m: float = 5.0,
    ratio: float = 0.8,
    gate_m: float = 1.0,
    gate_share: float = 0.1,
) -> Revisits:
    """Pairs of frames of one drive that show the same place: mutual nearest neighbours that stand out.

    ``features`` (n, d); ``odometry`` (n, 2) or (n, 3) positions (and headings) or (n,) metres travelled, which knows
    no gate. Frames of a pair are ``min_travel_m`` apart along the path or more; by odometry they are at most ``gate_m``
    apart and ``gate_share`` of the way between them. The distance to the match is less than ``ratio`` times that to
    the next best place, confidence is how much less: 1 - distance / (ratio * next best). Each frame is matched at most
    once, with the visit that looks most like it.
    Raises ``ArrayError`` for other shapes, ``ConfigError`` for values out of range, ``RecordingError`` for a drive of
    more than 10,000 frames.
    """
    values = checked_features(features, "features")
    travelled, path = _ways(odometry, len(values))
    if not (min_travel_m > 0 and 0 < ratio <= 1 and gate_m >= 0 and gate_share >= 0):
        raise ConfigError(
            f"min_travel_m={min_travel_m}, ratio={ratio}, gate_m={gate_m}, gate_share={gate_share}: have to be "
            f"above 0, in (0, 1], and at least 0"
        )
    if len(values) > _MOST_FRAMES:
        raise RecordingError(
            f"a drive of {len(values)} frames is too long to look for places that it came back to, at most "
            f"{_MOST_FRAMES} can be: cut it into drives, or leave frames out"
        )
    # Two numbers for each pair of frames are many: float32 holds a millimetre in a garden well enough.
    distance = np.maximum(1.0 - centred_cosine(values, values), 0.0)
    between = np.abs(travelled[:, None] - travelled).astype(np.float32)
    allowed = between >= min_travel_m
    elsewhere = (between > _AROUND_M) & ~allowed
    if path is not None:
        apart = np.hypot(path[:, None, 0] - path[:, 0], path[:, None, 1] - path[:, 1])
        gated = apart <= gate_m + gate_share * between
        elsewhere |= allowed & ~gated
        allowed &= gated
    best = np.where(allowed, distance, np.inf).argmin(axis=1)
    frames = np.arange(len(values))
    # A match has to be allowed and mutual, and counts once.
    later = frames[allowed[frames, best] & (best[best] == frames) & (best < frames)]
    earlier = best[later]
    # What may be a third visit is no rival; what is certainly another place is.
    rival = np.where(elsewhere[later], distance[later], np.inf).min(axis=1, initial=1.0)
    confidence = 1.0 - distance[later, earlier] / np.maximum(ratio * rival.astype(np.float64), 1e-9)
    sure = confidence > 0
    return Revisits(earlier[sure], later[sure], confidence[sure])


def _ways(odometry: ArrayLike, n: int) -> tuple[FloatArray, NDArray[np.float32] | None]:
    """Metres travelled (n,) and, where known, positions (n, 2)."""
    given = np.asarray(odometry, np.float64)
    if given.shape not in ((n,), (n, 2), (n, 3)) or not np.isfinite(given).all():
        raise ArrayError(
            f"odometry has to be (n, 3), (n, 2) or metres travelled (n,) for {n} frames, all known; got {given.shape}"
        )
    if given.ndim == 1:
        return given, None
    steps = np.hypot(*np.diff(given[:, :2], axis=0).T)
    return np.concatenate([[0.0], np.cumsum(steps)]), given[:, :2].astype(np.float32)
