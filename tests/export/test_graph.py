"""A graph in the making does nothing twice."""

import numpy as np

from andante.export.graph import Graph


def built(add) -> tuple[int, int]:
    """Numbers of operations and of constants."""
    graph = Graph()
    graph.output("result", add(graph, graph.image("image", (2, 3))), (2, 3))
    model = graph.model("piece", "0", {})
    return len(model.graph.node), len(model.graph.initializer)


def test_the_same_operation_on_the_same_is_done_once():
    def twice(graph: Graph, name: str) -> str:
        one, other = (graph("Mul", graph.floats(name), np.full(3, 2.0)) for _ in range(2))
        assert one == other
        return graph("Add", one, other)

    assert built(twice) == (4, 1)  # Cast, Mul, Add, Identity


def test_what_differs_in_anything_is_another():
    def differing(graph: Graph, name: str) -> str:
        pixels = graph.floats(name)
        products = [graph("Mul", pixels, factor) for factor in (np.full(3, 2.0), np.full((1, 3), 2.0), np.full(3, 3.0))]
        sums = [graph("ReduceSum", pixels, np.array([axis]), keepdims=1) for axis in (0, 1)]
        assert len({*products, *sums, graph("ReduceMax", pixels, axes=[0]), graph("ReduceMax", pixels, axes=[1])}) == 7
        return products[0]

    nodes, constants = built(differing)
    assert (nodes, constants) == (9, 5)
