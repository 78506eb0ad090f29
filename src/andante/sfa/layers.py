"""The layers of a hierarchical network as plain values, and the grids that follow from them.

A layer looks at the map below it through receptive fields on a regular grid; all fields share one node. Layers are
declared by what they look at and how many signals they keep; the size of every grid and the number of inputs of
every node follow.

>>> [(grid.columns, grid.rows, grid.input_dim) for grid in grids_of(PANORAMA_LAYERS, (60, 600))]
[(99, 9, 144), (48, 3, 180), (15, 1, 252), (1, 1, 240)]
>>> [(grid.columns, grid.rows, grid.input_dim) for grid in grids_of(LANDMARK_LAYERS, (120, 120))]
[(23, 23, 100), (10, 10, 300), (4, 4, 192), (1, 1, 192)]
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from andante.errors import ConfigError
from andante.sfa.expansion import expanded_dim

Maps = NDArray[Any]
"""(n, channels, height, width): n pictures, or what a layer made of them."""


@dataclass(frozen=True, slots=True)
class Layer:
    """One layer: linear SFA to ``reduced_dim`` signals, quadratic expansion, SFA to ``output_dim``, clipping.

    ``field`` and ``stride`` are (width, height) in nodes of the layer below, or pixels; a field of ``None`` is all of
    it. ``noise`` is the variance of white noise that the second SFA expects on its terms, of which the linear ones have
    unit variance; it takes effect in closed form, without random numbers. Outputs, of unit variance, are cut off at
    plus and minus ``clip``; ``None`` lets all pass. ``residual`` is the share of the reduced signals, and of the
    outputs, rounded down, that are not slow but carry on what the slow ones leave unsaid (see ``with_residual``).
    Raises ``ConfigError`` for values out of range.
    """

    output_dim: int
    field: tuple[int, int] | None = None
    stride: tuple[int, int] = (1, 1)
    reduced_dim: int = 20
    noise: float = 0.0
    clip: float | None = 4.0
    residual: float = 0.0

    def __post_init__(self) -> None:
        sizes = {"output_dim": (self.output_dim,), "stride": self.stride, "reduced_dim": (self.reduced_dim,)}
        if self.field is not None:
            sizes["field"] = self.field
        for name, value in sizes.items():
            if min(value) < 1:
                raise ConfigError(f"a layer with {name}={getattr(self, name)}: has to be at least 1")
        if not 0 <= self.noise < np.inf:
            raise ConfigError(f"a layer with noise={self.noise}: has to be a finite variance >= 0")
        if self.clip is not None and not self.clip > 0:
            raise ConfigError(f"a layer with clip={self.clip}: has to be above 0, or None")
        if not 0 <= self.residual < 1:
            raise ConfigError(f"a layer with residual={self.residual}: has to be a share in [0, 1)")
        if self.output_dim > expanded_dim(self.reduced_dim):
            raise ConfigError(
                f"a layer with output_dim={self.output_dim}: {self.reduced_dim} reduced signals have only "
                f"{expanded_dim(self.reduced_dim)} terms; ask for fewer outputs or a larger reduced_dim"
            )


PANORAMA_LAYERS = (
    Layer(12, field=(12, 12), stride=(6, 6)),
    Layer(14, field=(5, 3), stride=(2, 3)),
    Layer(16, field=(6, 3), stride=(3, 1)),
    Layer(8),
)
"""Thesis table 5.1, for panoramas of 600 x 60 pixels. The tables do not say to how many signals a node reduces its
inputs before it expands them; 20 is what 5.1.1 states for the Fourier features."""

LANDMARK_LAYERS = (
    Layer(12, field=(10, 10), stride=(5, 5)),
    Layer(12, field=(5, 5), stride=(2, 2)),
    Layer(12, field=(4, 4), stride=(2, 2)),
    Layer(8),
)
"""Thesis table 5.2, for landmark views of 120 x 120 pixels."""


@dataclass(frozen=True, slots=True)
class Grid:
    """Receptive fields over maps of ``channels`` signals on (height, width) nodes: (rows, columns) of them.

    Fields are (width, height) ``field`` at ``stride``. With ``wrap`` the map closes around its sides, as panoramas do:
    there is a field every ``stride`` around the circle, and those at the seam see both ends.
    """

    shape: tuple[int, int, int]
    field: tuple[int, int]
    stride: tuple[int, int]
    wrap: bool

    @property
    def columns(self) -> int:
        """Number of fields side by side."""
        width = self.shape[2]
        if self.wrap and self.field[0] < width:
            return max(1, width // self.stride[0])
        return (width - self.field[0]) // self.stride[0] + 1

    @property
    def rows(self) -> int:
        """Number of fields above each other."""
        return (self.shape[1] - self.field[1]) // self.stride[1] + 1

    @property
    def positions(self) -> int:
        """Number of fields P."""
        return self.rows * self.columns

    @property
    def input_dim(self) -> int:
        """Number of signals d in a field."""
        return self.shape[0] * self.field[0] * self.field[1]

    def fields(self, maps: Maps, dtype: DTypeLike) -> NDArray[Any]:
        """(n, channels, height, width) -> (d, n * P) of a floating ``dtype``, a column for every field.

        Down a column run the channels, in each of them the rows and the columns of the field; columns are
        ordered by picture, then row, then column of the grid. Columns side by side make every later step run over
        contiguous memory, however small the number of signals.
        """
        (channels, _, width), (fw, fh), (sx, sy) = self.shape, self.field, self.stride
        reach = (self.columns - 1) * sx + fw
        if reach > width:
            maps = np.concatenate([maps, maps[..., : reach - width]], axis=-1)
        n, (by_n, by_c, by_y, by_x) = len(maps), maps.strides
        views = np.lib.stride_tricks.as_strided(
            maps,
            (channels, fh, fw, n, self.rows, self.columns),
            (by_c, by_y, by_x, by_n, by_y * sy, by_x * sx),
            writeable=False,
        )
        return views.astype(dtype, order="C", copy=True).reshape(self.input_dim, n * self.positions)


def grids_of(layers: Sequence[Layer], shape: tuple[int, int], *, wrap: bool = False) -> tuple[Grid, ...]:
    """The grid of every layer over pictures (height, width); raises ``ConfigError`` where one does not fit."""
    if not layers:
        raise ConfigError("a hierarchical network needs at least one layer, got none")
    grids: list[Grid] = []
    below = (1, *shape)
    for number, layer in enumerate(layers, start=1):
        field = (below[2], below[1]) if layer.field is None else layer.field
        if field[0] > below[2] or field[1] > below[1]:
            raise ConfigError(
                f"layer {number} has receptive fields of {field[0]}x{field[1]} on a map of {below[2]}x{below[1]}: "
                "they have to fit; make the fields smaller, the strides below smaller or the pictures larger"
            )
        grid = Grid(below, field, layer.stride, wrap)
        if layer.reduced_dim > grid.input_dim:
            raise ConfigError(
                f"layer {number} cannot reduce {grid.input_dim} signals to reduced_dim={layer.reduced_dim}: ask for at "
                f"most {grid.input_dim}, or make its receptive fields larger"
            )
        grids.append(grid)
        below = (layer.output_dim, grid.rows, grid.columns)
    return tuple(grids)
