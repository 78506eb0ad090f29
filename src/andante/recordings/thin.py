"""One frame for every stand: a robot that waits must not weigh more than a robot that drives."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from andante.data import FrameInfo, IndexArray
from andante.errors import ConfigError


def moving_frames(infos: Sequence[FrameInfo], tolerance_m: float = 0.01) -> IndexArray:
    """Positions (m,) in ``infos`` of the frames to keep: of a stationary stretch only the first (thesis 4.2.3).

    A frame is stationary within ``tolerance_m`` of the last kept one, by reference where both have it, else by
    odometry; the two frames of reference are never mixed. Where neither is known, the frame is kept. Raises
    ``ConfigError`` for a negative tolerance.
    """
    if not tolerance_m >= 0:
        raise ConfigError(f"tolerance_m = {tolerance_m} is not allowed; use 0 or more metres")
    kept: list[int] = []
    for at, info in enumerate(infos):
        if not kept or not _distance_m(infos[kept[-1]], info) <= tolerance_m:
            kept.append(at)
    return np.array(kept, dtype=np.int64)


def _distance_m(first: FrameInfo, second: FrameInfo) -> float:
    """Distance in metres, NaN where it is unknown."""
    for a, b in ((first.reference, second.reference), (first.odometry, second.odometry)):
        if a is not None and b is not None:
            return math.hypot(b.x_m - a.x_m, b.y_m - a.y_m)
    return math.nan
