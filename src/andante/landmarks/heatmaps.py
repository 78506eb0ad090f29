"""Landmarks as peaks of heat maps over the panorama (CenterNet: Zhou et al. 2019, "Objects as points").

A heat map has one cell for ``stride`` x ``stride`` pixels of the panorama. Where a landmark's middle lies its map is
1, around it a Gaussian whose width follows the box (TTFNet: Liu et al. 2020), everywhere else 0. Beside the heat, a
cell tells four numbers of the box around it, in cells: how far right and down of the cell its middle lies, and the
logarithms of width and height. Columns go around the horizon, so the last one is a neighbour of the first.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.camera import PanoramaGeometry
from andante.data import FloatArray
from andante.errors import ConfigError
from andante.landmarks.boxes import Box

_SPREAD = 0.54 / 6.0  # TTFNet: a box is six standard deviations wide, shrunk by alpha = 0.54
_LEAST_SPREAD = 0.5
_LEAST_WEIGHT = 0.15

FloatArray32 = NDArray[np.float32]


@dataclass(frozen=True, slots=True)
class Targets:
    """What a network should say: ``heat`` (n, k, rows, columns), ``shape`` (n, k, 4, rows, columns) of the boxes.

    ``weight`` (n, k, rows, columns) is how much a cell's shape counts: its heat near a middle, 0 elsewhere.
    """

    heat: FloatArray32
    shape: FloatArray32
    weight: FloatArray32


@dataclass(frozen=True, slots=True)
class Grid:
    """The cells of a panorama; raises ``ConfigError`` where they do not fill it exactly."""

    geometry: PanoramaGeometry
    stride: int

    def __post_init__(self) -> None:
        if self.geometry.width_px % self.stride or self.geometry.height_px % self.stride:
            raise ConfigError(
                f"the sides of the panorama must be multiples of {self.stride} px, got {self.geometry.width_px} x "
                f"{self.geometry.height_px}"
            )

    @property
    def rows(self) -> int:
        """Number of rows."""
        return self.geometry.height_px // self.stride

    @property
    def columns(self) -> int:
        """Number of columns."""
        return self.geometry.width_px // self.stride

    def cells_of(self, boxes: Sequence[Box | None]) -> FloatArray:
        """(n, 4) middle column and row, width and height in cells, cell middles at whole numbers; NaN for ``None``."""
        rows = np.full((len(boxes), 4), np.nan)
        for row, box in zip(rows, boxes, strict=True):
            if box is not None:
                row[:] = box.azimuth_rad, box.elevation_rad, box.width_rad, box.height_rad
        across, down = self._per_rad()
        column = np.mod((np.pi - rows[:, 0]) * across - 0.5, self.columns)
        line = (np.radians(self.geometry.max_deg) - rows[:, 1]) * down - 0.5
        return np.column_stack([column, line, rows[:, 2] * across, rows[:, 3] * down])

    def box_of(self, cells: FloatArray) -> Box:
        """The inverse of ``cells_of`` for one row (4,)."""
        column, line, width, height = (float(number) for number in cells)
        across, down = self._per_rad()
        azimuth = -wrapped((column + 0.5) / across - np.pi)
        elevation = float(np.radians(self.geometry.max_deg)) - (line + 0.5) / down
        return Box(azimuth, elevation, min(width / across, 2.0 * np.pi), min(height / down, np.pi))

    def _per_rad(self) -> tuple[float, float]:
        """Cells per radian, across and down."""
        seen = np.radians(self.geometry.max_deg - self.geometry.min_deg)
        return self.columns / (2.0 * np.pi), self.rows / float(seen)


def targets(cells: FloatArray, grid: Grid) -> Targets:
    """Targets of k landmarks in n panoramas from their boxes (n, k, 4) in cells, NaN where there is none."""
    column, line, width, height = (cells[..., i, None, None] for i in range(4))
    there = np.isfinite(column)
    across = np.arange(grid.columns)[None, :]
    down = np.arange(grid.rows)[:, None]
    with np.errstate(invalid="ignore"):
        peak = np.round(column), np.clip(np.round(line), 0, grid.rows - 1)
        far = [_around(across - peak[0], grid.columns), down - peak[1]]
        spread = [np.maximum(_SPREAD * size, _LEAST_SPREAD) for size in (width, height)]
        heat = np.exp(-0.5 * sum((d / s) ** 2 for d, s in zip(far, spread, strict=True)))
        aside = _around(column - across, grid.columns), line - down
        shape = np.stack(np.broadcast_arrays(*aside, np.log(width), np.log(height)), axis=-3)
    heat = np.where(there, heat, 0.0)
    weight = np.where(heat >= _LEAST_WEIGHT, heat, 0.0)
    shape = np.where((weight > 0.0)[..., None, :, :], shape, 0.0)
    return Targets(heat.astype(np.float32), shape.astype(np.float32), weight.astype(np.float32))


def decoded(heat: FloatArray32, shape: FloatArray32) -> tuple[FloatArray, FloatArray]:
    """The one best place of every landmark: its height (k,) in the map and its box (k, 4) in cells.

    ``heat`` (k, rows, columns) may be on any scale that rises with the heat, ``shape`` is (k, 4, rows, columns).
    """
    count, rows, columns = heat.shape
    best = heat.reshape(count, -1).argmax(axis=1)
    row, column = np.divmod(best, columns)
    which = np.arange(count)
    told = shape[which, :, row, column].astype(np.float64)
    size = np.exp(np.clip(told[:, 2:], -4.0, np.log(max(rows, columns))))
    boxes = np.column_stack([np.mod(column + told[:, 0], columns), row + told[:, 1], size])
    return heat[which, row, column].astype(np.float64), boxes


def _around(difference: FloatArray, columns: int) -> FloatArray:
    """Differences of columns the shorter way around the horizon."""
    return np.mod(difference + columns / 2.0, columns) - columns / 2.0
