"""The vote of the nearest references in a graph, and the interpolation between them; see ``LocalReadout``."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.export.compass import CompassInGraph
from andante.export.graph import Graph
from andante.export.linear_systems import add_solution
from andante.export.regressions import LocatedNames
from andante.mapping.codes import LARGEST_CODE, Codes
from andante.mapping.readout import INTERPOLATED, LEAST_PULL, SAME_SUPPORT, LocalReadout


@dataclass(frozen=True)
class _Neighbours:
    """The m nearest references: squared distances ``d2`` (m,), ``positions`` (m, 2), ``votes`` (m,).

    ``offset`` (few, k) is where the first few lie, seen from the image.
    """

    d2: str
    positions: str
    votes: str
    offset: str


def add_local(graph: Graph, slow: str, readout: LocalReadout, compass: CompassInGraph | None) -> LocatedNames:
    """Slow features (k,) -> position, likeness and agreement; a compass is asked for its opinion on the candidates."""
    # Around their middle, references and positions are small numbers, of which single precision keeps more digits.
    middle, origin = readout.references.mean(axis=0), readout.xy.mean(axis=0)
    references = graph("Sub", _references(graph, readout.codes), middle)
    query = graph("Sub", graph("Mul", slow, readout.metric), middle)
    squared = _squared_distances(graph, query, references, readout.references - middle)
    ascending, order = graph.top(squared, max(readout.neighbours, len(readout.codes) // 2 + 1))
    nearest = graph.part(order, 0, readout.neighbours)
    d2 = graph.part(ascending, 0, readout.neighbours)
    positions = graph("Gather", (readout.xy - origin).astype(np.float32), nearest, axis=0)
    few = graph("Gather", references, graph.part(order, 0, min(INTERPOLATED, readout.neighbours)), axis=0)
    persuasion = None if compass is None else compass.persuasion(nearest, readout.xy, readout.neighbours)
    around = _Neighbours(d2, positions, _votes(graph, d2, persuasion, readout), graph("Sub", few, query))
    chosen = _consensus(graph, around, readout)
    share = graph("Mul", around.votes, chosen)
    agreement = graph.total(share, 0, keep=True)
    weights = _interpolated(graph, around, chosen, graph("Div", share, agreement), readout)
    centred = graph("MatMul", weights, positions)
    usual = graph("Max", _median(graph, ascending, len(readout.codes)), np.finfo(np.float32).tiny)
    likeness = graph("Clip", graph("Sub", 1.0, graph("Div", graph.part(d2, 0, 1), usual)), 0.0, 1.0)
    spreads, _ = graph.top(graph("Gather", readout.spread, nearest, axis=0), readout.neighbours)
    return LocatedNames(
        graph("Add", centred, origin),
        _covariance(graph, around, centred, readout.floor_m),
        likeness,
        agreement,
        _median(graph, spreads, readout.neighbours),
    )


def _references(graph: Graph, codes: Codes) -> str:
    """(r, k) from one byte a number, as in the map: the signed square of a code, times the scale of its row."""
    steps = graph.floats(codes.codes)
    signed = graph("Mul", steps, graph("Abs", steps))
    return graph("Mul", signed, codes.scale[:, None] / np.float32(LARGEST_CODE**2))


def _squared_distances(graph: Graph, query: str, references: str, values: NDArray[np.float32]) -> str:
    """(r,) by one product."""
    products = graph.shaped(graph("MatMul", references, graph.shaped(query, -1, 1)), -1)
    squared = graph("Sub", (values**2).sum(axis=1), graph("Mul", products, 2.0))
    return graph("Max", graph("Add", squared, graph.total(graph.square(query), 0, keep=True)), 0.0)


def _votes(graph: Graph, d2: str, persuasion: str | None, readout: LocalReadout) -> str:
    """(m,) how clearly each neighbour loses against the nearest one, and what the phases think of it."""
    best = graph("Max", graph.part(d2, 0, 1), 1e-9 * readout.typical)
    logarithm = graph("Mul", graph("Div", d2, best), -readout.sharpness)
    if persuasion is not None:
        logarithm = graph("Add", logarithm, persuasion)
    # Softmax is the same exponential, brought to a sum of one.
    return graph("Softmax", logarithm, axis=0)


def _consensus(graph: Graph, around: _Neighbours, readout: LocalReadout) -> str:
    """(m,) one for the neighbours around the winner, zero for the others."""
    m = readout.neighbours
    rows, columns = graph.shaped(around.positions, m, 1, 2), graph.shaped(around.positions, 1, m, 2)
    apart = graph("Sqrt", graph.total(graph.square(graph("Sub", rows, columns)), 2))
    together = graph.floats(graph("LessOrEqual", apart, readout.consensus_m))
    support = graph("MatMul", together, around.votes)
    least = graph("Sub", graph("ReduceMax", support, axes=[0], keepdims=1), SAME_SUPPORT)
    winner = graph("ArgMax", graph.floats(graph("GreaterOrEqual", support, least)), axis=0, keepdims=0)
    return graph("Gather", together, winner, axis=0)


def _interpolated(graph: Graph, around: _Neighbours, chosen: str, votes: str, readout: LocalReadout) -> str:
    """Weights (m,) that place an image between its references; see ``LocalReadout._interpolated``."""
    m, few = readout.neighbours, min(INTERPOLATED, readout.neighbours)
    held, taken = graph.part(votes, 0, few), graph.part(chosen, 0, few)
    gram = graph("MatMul", around.offset, graph("Transpose", around.offset, perm=[1, 0]))
    both = graph("Mul", graph.shaped(taken, few, 1), taken)
    own = graph.total(graph("Mul", gram, np.eye(few)), 1)
    apart = graph("Sub", graph("Add", graph.shaped(own, few, 1), own), graph("Mul", gram, 2.0))
    pairs = graph("Sub", graph.total(both, 0, 1), graph.total(taken, 0))
    gap = graph("Div", graph.total(graph("Mul", both, apart), 0, 1), graph("Max", pairs, 1.0))
    gap = graph("Max", gap, 1e-9 * readout.typical)
    foreign = graph("Div", graph("Mul", graph.square(graph.part(around.d2, 0, 1)), readout.caution), gap)
    pull = graph("Max", foreign, graph("Mul", gap, LEAST_PULL))
    # What was not chosen stands alone with a one on the diagonal, so its weight is its vote of zero.
    diagonal = graph("Where", graph("Greater", taken, 0.5), pull, 1.0)
    matrix = graph("Add", graph("Mul", gram, both), graph("Mul", np.eye(few), diagonal))
    sides = [graph.shaped(side, few, 1) for side in (graph("Mul", pull, held), taken)]
    solved = add_solution(graph, matrix, graph("Concat", *sides, axis=1), few)
    free, ones = (graph.shaped(graph.part(solved, at, at + 1, 1), -1) for at in (0, 1))
    missing = graph("Sub", 1.0, graph.total(free, 0))
    weights = graph("Add", free, graph("Mul", ones, graph("Div", missing, graph.total(ones, 0))))
    if m > few:
        weights = graph("Concat", weights, np.zeros(m - few), axis=0)
    return graph("Where", graph("Greater", pairs, 0.5), weights, votes)


def _covariance(graph: Graph, around: _Neighbours, xy: str, floor_m: float) -> str:
    """(2, 2) of all votes, so that two places that look alike give a large one."""
    offset = graph("Sub", around.positions, xy)
    weighted = graph("Mul", graph("Transpose", offset, perm=[1, 0]), around.votes)
    return graph("Add", graph("MatMul", weighted, offset), np.eye(2) * floor_m**2 / 2)


def _median(graph: Graph, ascending: str, count: int) -> str:
    """(1,) of ``count`` values of which at least the smaller half is there."""
    upper = graph.part(ascending, count // 2, count // 2 + 1)
    if count % 2:
        return upper
    return graph("Mul", graph("Add", graph.part(ascending, count // 2 - 1, count // 2), upper), 0.5)
