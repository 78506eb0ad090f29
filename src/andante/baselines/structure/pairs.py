"""Which pictures are matched: those shortly after each other, and those taken near each other."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import cKDTree

from andante.data import FloatArray, IndexArray

_GAPS = (1, 2, 3, 5, 8, 13, 21)
"""Frames from one to the other in a drive: near ones have many matches, far ones a wide base."""


def matched_pairs(xy: FloatArray, session: IndexArray, *, neighbours: int, radius_m: float) -> IndexArray:
    """Positions (n, 2) and drives (n,) in order of time -> sorted pairs (m, 2), the smaller number first, each once.

    Besides the followers in its drive, each picture is matched with the ``neighbours`` nearest ones within
    ``radius_m`` that are not among those between.
    """
    number = np.arange(len(xy))
    followers = [_followers(number, session, gap) for gap in _GAPS]
    nearest = [_near(xy, session, neighbours, radius_m)] if neighbours else []
    pairs = np.sort(np.concatenate(followers + nearest), axis=1)
    unique: IndexArray = np.unique(pairs, axis=0).astype(np.int64)
    return unique


def _followers(number: NDArray[np.int64], session: IndexArray, gap: int) -> NDArray[np.int64]:
    pairs = np.column_stack([number[:-gap], number[gap:]])
    same_drive: NDArray[np.int64] = pairs[session[pairs[:, 0]] == session[pairs[:, 1]]]
    return same_drive


def _near(xy: FloatArray, session: IndexArray, neighbours: int, radius_m: float) -> NDArray[np.int64]:
    """The nearest pictures of other drives or of other rounds of this one."""
    rows = []
    for one, others in enumerate(cKDTree(xy).query_ball_point(xy, radius_m)):
        other = np.array(others, np.int64)
        other = other[(session[other] != session[one]) | (np.abs(other - one) > max(_GAPS))]
        order = np.argsort(np.linalg.norm(xy[other] - xy[one], axis=1), kind="stable")[:neighbours]
        rows.append(np.column_stack([np.full(len(order), one), other[order]]))
    return np.concatenate(rows)
