"""Polynomial and Gaussian process in a graph, and what every readout gives there."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations_with_replacement

import numpy as np
from numpy.typing import NDArray
from scipy import linalg

from andante.export.graph import Graph
from andante.mapping.regressions import GaussianProcessReadout, PolynomialReadout


@dataclass(frozen=True)
class LocatedNames:
    """Where in a graph the parts of a ``Located`` are found: (2,), (2, 2), and (1,) each."""

    xy: str
    covariance: str
    likeness: str
    agreement: str
    spread: str


def add_polynomial(graph: Graph, slow: str, readout: PolynomialReadout) -> LocatedNames:
    """Slow features (k,) -> position; see ``PolynomialReadout.locate``."""
    inputs = graph.part(slow, 0, readout.inputs)
    # A one before the signals fills the terms that have fewer factors than the degree.
    factors = graph("Gather", graph("Concat", np.ones(1), inputs, axis=0), _factors(readout), axis=0)
    terms = graph("ReduceProd", factors, axes=[1], keepdims=0)
    xy = graph("MatMul", terms, readout.coefficients)
    energy = graph("ReduceMean", graph.square(inputs), axes=[0], keepdims=1)
    likeness = graph("Div", 1.0, graph("Max", energy, 1.0))
    return _without_rivals(xy, graph("Div", readout.residual, likeness), likeness, graph)


def add_gaussian_process(graph: Graph, slow: str, readout: GaussianProcessReadout) -> LocatedNames:
    """Slow features (k,) -> position; see ``GaussianProcessReadout.locate``."""
    # The weights of the mean have both signs and sum up to little: squared distances are made from differences, since
    # the shortcut by products would lose what single precision has to offer.
    offset = graph("Sub", readout.points, graph("Mul", slow, readout.metric))
    squared = graph.total(graph.square(offset), 1)
    kernel = graph("Exp", graph("Mul", squared, -0.5 / readout.length**2))
    xy = graph("Add", graph("MatMul", kernel, readout.dual), readout.mean)
    inverse = linalg.solve_triangular(readout.factor, np.eye(len(readout.factor)), lower=True)
    explained = graph.total(graph.square(graph("MatMul", inverse, graph.shaped(kernel, -1, 1))), 0)
    unexplained = graph("Clip", graph("Sub", 1.0, explained), 0.0, 1.0)
    variance = graph("Mul", graph("Add", unexplained, readout.noise), readout.prior)
    return _without_rivals(xy, graph("Mul", variance, np.eye(2)), graph("Sub", 1.0, unexplained), graph)


def _factors(readout: PolynomialReadout) -> NDArray[np.int32]:
    """(terms, degree): the signals, counted from one, whose product each term is; zero stands for none."""
    table = [
        chosen + (0,) * (readout.degree - power)
        for power in range(readout.degree + 1)
        for chosen in combinations_with_replacement(range(1, readout.inputs + 1), power)
    ]
    return np.array(table, np.int32)


def _without_rivals(xy: str, covariance: str, likeness: str, graph: Graph) -> LocatedNames:
    """The answer of a regression, which considers no other place."""
    certain, unknown = (graph("Identity", np.full(1, value)) for value in (1.0, np.inf))
    return LocatedNames(xy, covariance, likeness, certain, unknown)
