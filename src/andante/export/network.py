"""A hierarchical network in a graph: receptive fields by one table each layer, nodes by two products."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from andante.export.graph import Graph
from andante.export.slow_models import add_expansion
from andante.sfa import HierarchicalModel
from andante.sfa.hierarchy import nodes_in
from andante.sfa.layers import Grid
from andante.sfa.shared_node import SharedNode


def add_network(graph: Graph, panorama: str, model: HierarchicalModel) -> str:
    """Panorama (height, width) -> outputs (k,) of the last layer."""
    maps = panorama
    for number, (grid, node) in enumerate(
        zip(model.grids, nodes_in(model.layers, model.nodes, np.float32), strict=True)
    ):
        fields = graph("Gather", graph.shaped(maps, -1), _field_table(grid), axis=0)
        if number == 0 and model.deviation_floor is not None:
            fields = _normalised(graph, fields, model.deviation_floor)
        maps = _outputs(graph, fields, node)
    return graph.shaped(maps, -1)


def _field_table(grid: Grid) -> NDArray[np.int32]:
    """(d, P): which node of the flat map below is which signal of which field."""
    below = np.arange(np.prod(grid.shape)).reshape(1, *grid.shape)
    # Through the same function that makes the fields; doubles hold these numbers exactly.
    return grid.fields(below, np.float64).astype(np.int32)


def _normalised(graph: Graph, fields: str, deviation_floor: float) -> str:
    """Every field (column) at zero mean and about unit deviation; see ``normalise_fields``."""
    centred = graph("Sub", fields, graph("ReduceMean", fields, axes=[0], keepdims=1))
    variance = graph("ReduceMean", graph.square(centred), axes=[0], keepdims=1)
    floored = graph("Max", graph("Add", variance, deviation_floor**2), np.finfo(np.float32).tiny)
    return graph("Div", centred, graph("Sqrt", floored))


def _outputs(graph: Graph, fields: str, node: SharedNode) -> str:
    """Fields (d, P) -> outputs (k, P)."""
    reduced = graph("Add", graph("MatMul", node.reduce.weights, fields), node.reduce.offset)
    terms = add_expansion(graph, reduced, len(node.reduce.weights))
    slow = graph("Add", graph("MatMul", node.slow.weights, terms), node.slow.offset)
    return slow if node.clip is None else graph("Clip", slow, -node.clip, node.clip)
