"""A bounded number of references, spread over the places and sessions that they stand for."""

from __future__ import annotations

import numpy as np

from andante.data import FloatArray, IndexArray

_COARSER = 1.25
_ONE_SPOT_M = 1e-6


def thinned_by_place(xy: FloatArray, session: IndexArray, at_most: int) -> IndexArray:
    """Indices (m <= at_most,) of frames to keep: one per session in every cell of a grid.

    The grid is as fine as the bound allows. Where even one cell holds more sessions than ``at_most``, sessions are
    dropped evenly. ``xy`` (n, 2), ``session`` (n,).
    """
    if len(xy) <= at_most:
        return np.arange(len(xy))
    extent = float(np.ptp(xy, axis=0).max())
    extent = extent if extent > _ONE_SPOT_M else 1.0  # any length will do where all frames share one spot
    # With one cell per frame at first, and few steps until it fits.
    cell = extent / len(xy)
    while True:
        keys = np.column_stack([session, np.floor((xy - xy.min(axis=0)) / cell).astype(np.int64)])
        kept = np.sort(np.unique(keys, axis=0, return_index=True)[1])
        if len(kept) <= at_most:
            return kept
        if cell > extent:
            return kept[np.linspace(0, len(kept) - 1, at_most).astype(np.int64)]
        cell *= _COARSER
