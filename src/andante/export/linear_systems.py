"""Small linear systems in a graph, for which ONNX has no operation."""

from __future__ import annotations

import numpy as np

from andante.export.graph import Graph


def add_solution(graph: Graph, matrix: str, sides: str, dim: int) -> str:
    """X (dim, n) of ``matrix`` (dim, dim) X = ``sides`` (dim, n), for a symmetric positive definite matrix.

    Gauss-Jordan elimination, unrolled. Such a matrix needs no pivoting; with ones on its diagonal all pivots are at
    most one, which keeps single precision good to the condition of the matrix times 1e-7.
    """
    identity = np.eye(dim)
    root = graph("Sqrt", graph.total(graph("Mul", matrix, identity), 1, keep=True))
    unit = graph("Div", graph("Div", matrix, root), graph("Transpose", root, perm=[1, 0]))
    rows = graph("Concat", unit, graph("Div", sides, root), axis=1)
    for at in range(dim):
        row, column = graph.part(rows, at, at + 1), graph.part(rows, at, at + 1, axis=1)
        pivot = graph.part(row, at, at + 1, axis=1)
        # Less the pivot's own row once, so that it stays as it is, divided by the pivot.
        others = graph("Sub", column, identity[:, at : at + 1])
        rows = graph("Sub", rows, graph("Mul", others, graph("Div", row, pivot)))
    return graph("Div", graph.part(rows, dim, np.iinfo(np.int64).max, axis=1), root)
