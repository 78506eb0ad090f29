"""A learnt hierarchical network: whole pictures in, slow features out, one picture or many in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import DTypeLike, NDArray

from andante.data import FloatArray
from andante.errors import ArrayError, ConfigError
from andante.sfa.arrays import require_names
from andante.sfa.field_moments import block_length
from andante.sfa.layers import Grid, Layer, Maps, grids_of
from andante.sfa.quadratic import QuadraticModel
from andante.sfa.shared_node import SharedNode, fields_of, maps_of
from andante.sfa.threads import one_thread

_LAYER_COLUMNS = 9
"""Numbers a layer takes in a file: outputs, field, stride, reduced, noise, residual, clip."""


@dataclass(frozen=True, eq=False)
class HierarchicalModel:
    """Layers of shared nodes over pictures (height, width) = ``shape`` (thesis 5.1.1, tables 5.1 and 5.2).

    ``nodes`` holds one model for each of ``layers``; ``wrap`` lets receptive fields cross the seam of a panorama;
    ``deviation_floor`` is that of the patch normalisation in the first layer, in units of the pixels, or ``None``.
    The first layers of a network are a network too. Raises ``ConfigError`` for layers that do not fit the pictures,
    ``ArrayError`` for nodes that do not fit the layers.
    """

    layers: tuple[Layer, ...]
    nodes: tuple[QuadraticModel, ...]
    shape: tuple[int, int]
    wrap: bool = False
    deviation_floor: float | None = None

    def __post_init__(self) -> None:
        if len(self.layers) != len(self.nodes):
            raise ArrayError(f"a network of {len(self.layers)} layers needs as many nodes, got {len(self.nodes)}")
        for number, (layer, grid, node) in enumerate(zip(self.layers, self.grids, self.nodes, strict=True), start=1):
            expected = grid.input_dim, layer.reduced_dim, layer.output_dim
            found = node.input_dim, node.reduce.output_dim, node.output_dim
            if found != expected:
                raise ArrayError(
                    f"layer {number} is declared as {' -> '.join(map(str, expected))} signals, "
                    f"but its node is {' -> '.join(map(str, found))}"
                )

    @cached_property
    def grids(self) -> tuple[Grid, ...]:
        """Where the receptive fields of each layer lie."""
        return grids_of(self.layers, self.shape, wrap=self.wrap)

    @property
    def input_dim(self) -> int:
        """Number of pixels of a picture."""
        return self.shape[0] * self.shape[1]

    @property
    def output_dim(self) -> int:
        """Number of slow features k of a picture: the outputs of the last layer at all its positions."""
        return self.layers[-1].output_dim * self.grids[-1].positions

    @property
    def deltas(self) -> FloatArray:
        """(k,) mean squared difference of each output, before clipping, along the edges it was learnt on."""
        return np.repeat(self.nodes[-1].deltas, self.grids[-1].positions)

    def transform(self, pictures: NDArray[Any], *, dtype: DTypeLike = np.float32) -> FloatArray:
        """Slow features (k,) of a picture (height, width), or (n, k) of many (n, height, width).

        Pictures are uint8 or floating, also as rows of pixels (n, height * width); arithmetic is in ``dtype``, the
        result float64. Raises ``ArrayError`` for another size.
        """
        stack = self._stack(pictures)
        outputs = np.empty((len(stack), self.output_dim))
        block = block_length(self.grids[0].positions)
        with one_thread():
            for start in range(0, len(stack), block):
                maps = self.run(stack[start : start + block, None], dtype)
                outputs[start : start + block] = maps.reshape(len(maps), -1)
        return outputs[0] if pictures.shape == self.shape else outputs

    def run(self, maps: Maps, dtype: DTypeLike = np.float32) -> Maps:
        """Pictures (n, 1, height, width) -> what the last layer makes of them, (n, channels, rows, columns)."""
        for number, (grid, node) in enumerate(zip(self.grids, self._ready(np.dtype(dtype)), strict=True)):
            fields = fields_of(grid, maps, self.deviation_floor if number == 0 else None, dtype)
            maps = maps_of(grid, node(fields))
        return maps

    def first(self, count: int) -> HierarchicalModel:
        """The network of the first ``count`` layers."""
        return HierarchicalModel(self.layers[:count], self.nodes[:count], self.shape, self.wrap, self.deviation_floor)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """``layers`` (L, 9), ``shape`` (2,), ``wrap`` (1,), ``deviation_floor`` (0 or 1,), ``0.reduce.mean`` ..."""
        floor = [] if self.deviation_floor is None else [self.deviation_floor]
        arrays: dict[str, NDArray[Any]] = {
            "layers": np.array([_layer_row(layer) for layer in self.layers]),
            "shape": np.array(self.shape, dtype=np.int64),
            "wrap": np.array([self.wrap], dtype=np.int64),
            "deviation_floor": np.array(floor, dtype=np.float64),
        }
        for number, node in enumerate(self.nodes):
            arrays |= {f"{number}.{name}": array for name, array in node.to_arrays().items()}
        return arrays

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The inverse of ``to_arrays``; raises ``ArrayError`` or ``ConfigError`` for what does not fit."""
        require_names(arrays, ("layers", "shape", "wrap", "deviation_floor"), "HierarchicalModel")
        table, shape, floor = arrays["layers"], arrays["shape"], arrays["deviation_floor"]
        if (
            table.ndim != 2
            or table.shape[1] != _LAYER_COLUMNS
            or shape.shape != (2,)
            or floor.shape not in ((0,), (1,))
        ):
            raise ArrayError(
                f"a stored network needs layers (L, {_LAYER_COLUMNS}), shape (2,) and deviation_floor (0,) or (1,), "
                f"got shapes {table.shape}, {shape.shape} and {floor.shape}"
            )
        return cls(
            layers=tuple(_layer_of(row) for row in table.tolist()),
            nodes=tuple(QuadraticModel.from_arrays(_below(arrays, f"{number}.")) for number in range(len(table))),
            shape=(int(shape[0]), int(shape[1])),
            wrap=bool(arrays["wrap"].item()),
            deviation_floor=float(floor[0]) if len(floor) else None,
        )

    def _stack(self, pictures: NDArray[Any]) -> NDArray[Any]:
        flat = pictures.ndim == 2 and pictures.shape[1] == self.input_dim
        if not flat and (pictures.ndim not in (2, 3) or pictures.shape[-2:] != self.shape):
            raise ArrayError(
                f"this network takes pictures ({self.shape[0]}, {self.shape[1]}), one or a stack of them, got shape "
                f"{pictures.shape}; bring them to the size that it was learnt on"
            )
        return pictures.reshape(-1, *self.shape)

    def _ready(self, dtype: np.dtype[Any]) -> tuple[SharedNode, ...]:
        return self._single if dtype == np.float32 else nodes_in(self.layers, self.nodes, dtype)

    @cached_property
    def _single(self) -> tuple[SharedNode, ...]:
        return nodes_in(self.layers, self.nodes, np.float32)


def nodes_in(layers: Sequence[Layer], nodes: Sequence[QuadraticModel], dtype: DTypeLike) -> tuple[SharedNode, ...]:
    """Nodes that are ready to run in a floating type."""
    return tuple(SharedNode.of(node, layer.clip, dtype) for layer, node in zip(layers, nodes, strict=True))


def _layer_row(layer: Layer) -> list[float]:
    clip = np.inf if layer.clip is None else layer.clip
    return [
        layer.output_dim,
        *(layer.field or (0, 0)),
        *layer.stride,
        layer.reduced_dim,
        layer.noise,
        layer.residual,
        clip,
    ]


def _layer_of(row: Sequence[float]) -> Layer:
    output_dim, field_x, field_y, stride_x, stride_y, reduced_dim, noise, residual, clip = row
    if not np.isfinite(row[:-1]).all():
        raise ConfigError(f"a stored layer has to consist of finite numbers, got {row}")
    return Layer(
        int(output_dim),
        (int(field_x), int(field_y)) if field_x else None,
        (int(stride_x), int(stride_y)),
        int(reduced_dim),
        noise,
        clip if np.isfinite(clip) else None,
        residual,
    )


def _below(arrays: Mapping[str, NDArray[Any]], prefix: str) -> dict[str, NDArray[Any]]:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
