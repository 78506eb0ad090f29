"""Features to slow features in a graph."""

from __future__ import annotations

import numpy as np

from andante.export.graph import Graph
from andante.mapping.compact import CompactModel


def add_slow_model(graph: Graph, features: str, model: CompactModel) -> tuple[str, str]:
    """Features (d,) -> slow features (k,), and how far (1,) the features are from the average."""
    centred = graph("Sub", features, model.mean)
    rows = graph("Mul", graph.table(model.weights), model.scale[:, None])
    slow = graph.shaped(graph("MatMul", rows, graph.shaped(centred, -1, 1)), -1)
    if model.quadratic is not None:
        terms = graph("Sub", add_expansion(graph, slow, len(model.weights)), model.quadratic.mean)
        slow = graph("MatMul", terms, model.quadratic.weights)
    return slow, graph("ReduceL2", centred, axes=[0], keepdims=1)


def add_expansion(graph: Graph, signals: str, dim: int) -> str:
    """Signals (d,) or (d, n) and every product of two: the terms of ``expand_quadratic`` along the first axis."""
    factors = [graph("Gather", signals, side.astype(np.int32), axis=0) for side in np.triu_indices(dim)]
    return graph("Concat", signals, graph("Mul", *factors), axis=0)
