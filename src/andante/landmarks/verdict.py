"""What a learnt network is worth on held-out pictures, and the scores that follow from it. Imported by what learns."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.landmarks.augmentation import Batch
from andante.landmarks.boxes import SAME_PLACE_IOU
from andante.landmarks.heatmaps import FloatArray32, Grid, decoded
from andante.landmarks.network import LandmarkNetwork


@dataclass(frozen=True, slots=True)
class Places:
    """The best place of one landmark in n pictures of which it is known whether it is there.

    ``heat`` (n,) as logits, ``there`` (n,) whether the landmark is in the picture, ``overlap`` (n,) of the boxes, 0
    where it is not; ``beside`` (m,) is the hottest heat outside of the landmark's box where there is one: what is left
    to be found when the landmark is gone.
    """

    heat: FloatArray
    there: NDArray[np.bool_]
    overlap: FloatArray
    beside: FloatArray

    @property
    def right(self) -> NDArray[np.bool_]:
        """(n,) whether the place is where the landmark is."""
        return np.asarray(self.overlap >= SAME_PLACE_IOU, np.bool_)

    def figures(self, passed: NDArray[np.bool_]) -> dict[str, float | None]:
        """What remains of the places that ``passed`` (n,) a threshold.

        ``found``: share of the pictures with the landmark in which its place passed; ``false``: share of all pictures
        in which a wrong place passed; ``iou``: median overlap of what was found.
        """
        found = passed & self.right
        return {
            "found": round(float(found.sum() / max(int(self.there.sum()), 1)), 4),
            "false": round(float((passed & ~self.right).mean()), 4),
            "iou": round(float(np.median(self.overlap[found])), 3) if found.any() else None,
        }


def best_places(network: LandmarkNetwork, batches: Iterable[Batch], grid: Grid) -> list[Places]:
    """The best place of every landmark in all pictures."""
    rows: list[list[tuple[float, bool, float]]] = [[] for _ in range(network.landmarks)]
    beside: list[list[float]] = [[] for _ in range(network.landmarks)]
    for batch in batches:
        with torch.no_grad():
            told = network(batch.pictures).numpy()
        for maps, cells, counts in zip(told, batch.cells, batch.counts, strict=True):
            peaks, boxes = decoded(maps[:, 0], maps[:, 1:])
            for k in np.flatnonzero(counts):
                there = bool(np.isfinite(cells[k, 0]))
                overlap = grid.box_of(boxes[k]).iou(grid.box_of(cells[k])) if there else 0.0
                rows[k].append((float(peaks[k]), there, overlap))
                if there:
                    beside[k].append(_hottest_outside(maps[k, 0], cells[k]))
    return [_places(*both) for both in zip(rows, beside, strict=True)]


def _places(rows: list[tuple[float, bool, float]], beside: list[float]) -> Places:
    table = np.array(rows, np.float64).reshape(-1, 3)
    return Places(table[:, 0], table[:, 1] > 0.0, table[:, 2], np.array(beside, np.float64))


def _hottest_outside(heat: FloatArray32, cells: FloatArray) -> float:
    """The greatest heat (rows, columns) outside of a box and one cell around it."""
    rows, columns = heat.shape
    across = np.mod(np.arange(columns) - cells[0] + columns / 2.0, columns) - columns / 2.0
    outside = (np.abs(across)[None, :] > cells[2] / 2.0 + 1.0) | (
        np.abs(np.arange(rows) - cells[1])[:, None] > cells[3] / 2.0 + 1.0
    )
    return float(heat[outside].max(initial=float(heat.min())))
