"""The hierarchical network of a map: its layers, the pictures that they need, and its arrays in a file.

What layers there are, whether they cross the seam and how large panoramas are stands in the configuration and in the
camera already, so a file holds the nodes alone.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.errors import ConfigError, MapError
from andante.mapping.config import NetworkConfig
from andante.mapping.frontend import FrontEnd
from andante.sfa import AffineModel, HierarchicalModel, Layer, QuadraticModel, expanded_dim, grids_of
from andante.sfa.layers import Grid

_MOST_NUMBERS = 20_000_000
"""Table 5.1 takes 205,000."""
_LARGEST_WEIGHT = 1e9
_DTYPES = {"mean": "f4", "weights": "f4", "deltas": "f8", "rank": "i8", "rank_tolerance": "f8"}


def layers_of(config: NetworkConfig) -> tuple[Layer, ...]:
    """The layers that are learnt, from the panorama upwards."""
    return tuple(Layer(**one.model_dump(), residual=config.residual) for one in config.layers[: config.depth])


def crosses_seam(config: NetworkConfig, front_end: FrontEnd) -> bool:
    """Whether receptive fields reach over the sides of the panorama."""
    return front_end.camera.heading_invariant if config.wrap is None else config.wrap


def require_room(config: NetworkConfig, front_end: FrontEnd) -> None:
    """Raise ``ConfigError`` for panoramas that are too small for the layers."""
    layers, wrap = layers_of(config), crosses_seam(config, front_end)
    height, width = front_end.panorama_shape
    least_height, least_width = least_shape(layers, wrap=wrap)
    if height < least_height or width < least_width:
        raise ConfigError(
            f"the network needs panoramas of at least {least_width}x{least_height} px, this camera gives "
            f"{width}x{height}; take features of kind flat (andante map --features flat) or fourier, or declare "
            "smaller network.layers"
        )
    _require_small(layers, front_end.panorama_shape, wrap=wrap)  # and whatever else does not fit


def _require_small(layers: tuple[Layer, ...], shape: tuple[int, int], *, wrap: bool) -> tuple[Grid, ...]:
    """The grids of the layers; raises ``ConfigError`` for more numbers than a picture may take on its way up."""
    grids = grids_of(layers, shape, wrap=wrap)
    for number, (layer, grid) in enumerate(zip(layers, grids, strict=True), 1):
        numbers = grid.positions * max(grid.input_dim, expanded_dim(layer.reduced_dim))
        if numbers > _MOST_NUMBERS:
            raise ConfigError(
                f"layer {number} of the network would take {numbers} numbers a picture, at most {_MOST_NUMBERS} are "
                "allowed; enlarge network.layers.stride or make panoramas smaller"
            )
    return grids


def least_shape(layers: tuple[Layer, ...], *, wrap: bool) -> tuple[int, int]:
    """The smallest (height, width) of a picture in which every layer has room for one receptive field."""
    height = width = 1
    for layer, channels in reversed(list(zip(layers, (1, *(one.output_dim for one in layers)), strict=False))):
        # A field that is all of the map below needs as many nodes of it as give the signals to reduce.
        field, stride = layer.field or (math.ceil(layer.reduced_dim / channels), 1), layer.stride
        height = (height - 1) * stride[1] + field[1]
        # Around a circle there is a field every stride, however far it reaches.
        around = max(field[0] + 1, width * stride[0])
        width = around if wrap and width > 1 else (width - 1) * stride[0] + field[0]
    return height, width


def as_stored(network: HierarchicalModel) -> HierarchicalModel:
    """The same network, rounded to what a file holds."""
    nodes = tuple(QuadraticModel(_rounded(node.reduce), _rounded(node.slow)) for node in network.nodes)
    return replace(network, nodes=nodes)


def same_network(first: HierarchicalModel | None, second: HierarchicalModel | None) -> bool:
    """Whether two networks turn the same pictures into the same features."""
    if first is None or second is None:
        return first is second
    one, other = network_arrays(first), network_arrays(second)
    setting = (first.layers, first.shape, first.wrap, first.deviation_floor)
    return setting == (second.layers, second.shape, second.wrap, second.deviation_floor) and all(
        np.array_equal(array, other[name]) for name, array in one.items()
    )


def network_arrays(network: HierarchicalModel) -> dict[str, NDArray[Any]]:
    """``0.reduce.mean``, ``0.reduce.weights`` and so on, of a network that is ``as_stored``."""
    arrays = dict[str, NDArray[Any]]()
    for number, node in enumerate(network.nodes):
        for name, array in node.to_arrays().items():
            arrays[f"{number}.{name}"] = array.astype(_DTYPES[name.rpartition(".")[2]])
    return arrays


def network_of(arrays: Mapping[str, NDArray[Any]], config: NetworkConfig, front_end: FrontEnd) -> HierarchicalModel:
    """The inverse, checked: raises ``MapError`` or ``ConfigError`` for arrays that do not fit the layers."""
    layers, shape, wrap = layers_of(config), front_end.panorama_shape, crosses_seam(config, front_end)
    expected = dict[str, tuple[int, ...]]()
    for number, (layer, grid) in enumerate(zip(layers, _require_small(layers, shape, wrap=wrap), strict=True)):
        expected |= _shapes(f"{number}.reduce", grid.input_dim, layer.reduced_dim)
        expected |= _shapes(f"{number}.slow", expanded_dim(layer.reduced_dim), layer.output_dim)
    _require_shapes(arrays, expected)
    nodes = tuple(QuadraticModel.from_arrays(_below(arrays, f"{number}.")) for number in range(len(layers)))
    return HierarchicalModel(layers, nodes, shape, wrap, config.deviation_floor)


def _rounded(model: AffineModel) -> AffineModel:
    return replace(model, mean=_single(model.mean), weights=_single(model.weights))


def _single(array: FloatArray) -> FloatArray:
    return array.astype(np.float32).astype(np.float64)


def _shapes(stage: str, inputs: int, outputs: int) -> dict[str, tuple[int, ...]]:
    return {
        f"{stage}.mean": (inputs,),
        f"{stage}.weights": (inputs, outputs),
        f"{stage}.deltas": (outputs,),
        f"{stage}.rank": (1,),
        f"{stage}.rank_tolerance": (1,),
    }


def _require_shapes(arrays: Mapping[str, NDArray[Any]], expected: Mapping[str, tuple[int, ...]]) -> None:
    if not arrays:
        raise MapError("it has features of kind pixels, but no network that makes them")
    if odd := sorted(set(arrays) ^ set(expected)):
        raise MapError(f"its network has not the nodes that its layers need: network.{odd[0]} is missing or too much")
    for name, shape in expected.items():
        array, dtype = arrays[name], np.dtype(_DTYPES[name.rpartition(".")[2]])
        if array.shape != shape or array.dtype != dtype:
            raise MapError(f"array network.{name} is {array.dtype} of shape {array.shape}, expected {dtype} {shape}")
        if array.size and np.abs(array).max() > _LARGEST_WEIGHT:
            raise MapError(f"array network.{name} holds numbers beyond {_LARGEST_WEIGHT:g}")


def _below(arrays: Mapping[str, NDArray[Any]], prefix: str) -> dict[str, NDArray[Any]]:
    return {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
