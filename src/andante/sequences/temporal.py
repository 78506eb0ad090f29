"""Edges along time: each frame with the next one of its recording."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from andante.data import Edges
from andante.errors import ArrayError, ConfigError


def temporal_edges(
    session: ArrayLike, *, timestamp_s: ArrayLike | None = None, max_gap_s: float | None = None
) -> Edges:
    """Edges of weight 1 between consecutive frames of the same session, as plain slow feature analysis has them.

    ``session`` (n,) numbers the recording of each frame; the frames of one recording are in order of time. With
    ``timestamp_s`` (n,) seconds and ``max_gap_s`` pairs that lie further apart are left out, as the robot may have been
    carried meanwhile. Raises ``ArrayError`` for other shapes, ``ConfigError`` for a gap without time stamps or
    not above 0.
    """
    session = np.asarray(session)
    if session.ndim != 1:
        raise ArrayError(f"session has to be one number per frame (n,), got shape {session.shape}")
    joined = session[1:] == session[:-1]
    if max_gap_s is not None:
        if timestamp_s is None or not max_gap_s > 0:
            raise ConfigError(f"max_gap_s={max_gap_s}: has to be above 0 and needs timestamp_s beside it")
        times = np.asarray(timestamp_s, dtype=np.float64)
        if times.shape != session.shape:
            raise ArrayError(f"timestamp_s has shape {times.shape}, session {session.shape}: one of each per frame")
        joined &= np.diff(times) <= max_gap_s
    first = np.flatnonzero(joined)
    return Edges.between(first, first + 1)
