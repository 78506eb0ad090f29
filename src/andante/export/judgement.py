"""What an estimate is worth, in a graph: the same bounds and factors as ``SlowMap.estimate`` has."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from andante.data import Status
from andante.export.compass import BearingNames
from andante.export.graph import Graph
from andante.export.regressions import LocatedNames
from andante.mapping.calibration import Calibration
from andante.mapping.frontend import MIN_CONTRAST
from andante.mapping.locating import DOUBT
from andante.mapping.uncertainty import DEVIATIONS_OF_90_PERCENT, LEAST_OFF_RAD, RADIUS_OF_90_PERCENT

STATUSES = (Status.OK, Status.DEGRADED, Status.LOST, Status.OFF_MAP)
"""What the numbers of the output ``status`` mean; there is a position with the first two."""


def add_tempered(graph: Graph, located: LocatedNames, spread: str) -> str:
    """Likeness (1,), less where an image lies further from the average than mapped ones of its kind do."""
    excess = graph("Max", graph("Div", spread, located.spread), 1.0)
    return graph("Div", located.likeness, graph.square(excess))


def add_status(graph: Graph, panorama: str, likeness: str, agreement: str, bounds: Calibration) -> str:
    """Status (1,) int64, an index of ``STATUSES``."""
    clear = graph("GreaterOrEqual", graph("Mul", likeness, agreement), bounds.degraded_below)
    # A map that has not learnt what a foreign place looks like is never sure.
    best = Status.OK if bounds.off_map_below > 0 else Status.DEGRADED
    status = graph("Where", clear, _code(best), _code(Status.DEGRADED))
    status = graph("Where", graph("Less", agreement, bounds.lost_below), _code(Status.LOST), status)
    status = graph("Where", graph("Less", likeness, bounds.off_map_below), _code(Status.OFF_MAP), status)
    # What is not a number fails no bound.
    unknown = graph("IsNaN", graph("Mul", likeness, agreement))
    return graph("Where", graph("Or", unknown, _blank(graph, panorama)), _code(Status.LOST), status)


def add_known(graph: Graph, values: str, status: str) -> str:
    """The values where the status has a pose, else NaN: who does not ask for the status must not get a pose."""
    return graph("Where", graph("LessOrEqual", status, _code(Status.DEGRADED)), values, np.nan)


def add_doubt(graph: Graph, peak: str) -> str:
    """(1,) how much less certain all is than it would be of an image just like its place; see ``doubt_of``."""
    return graph("Exp", graph("Mul", graph("Sub", 1.0, peak), DOUBT))


def add_radius(graph: Graph, covariance: str, doubt: str, factor: float) -> str:
    """Radius (1,) around the position, in the unit of the map."""
    return graph("Mul", graph("Mul", graph("Sqrt", _trace(graph, covariance)), doubt), factor)


def add_covariance(graph: Graph, covariance: str, radius: str) -> str:
    """Covariance (2, 2) of which the radius holds 90 %, were it round."""
    variance = graph.square(graph("Div", radius, RADIUS_OF_90_PERCENT))
    return graph("Mul", covariance, graph("Div", graph("Mul", variance, 2.0), _trace(graph, covariance)))


def add_heading(graph: Graph, bearings: BearingNames | None, doubt: str, factor: float | None) -> tuple[str, str]:
    """Heading and its standard deviation (1,) in radians, NaN where it is not known."""
    if bearings is None or factor is None:
        unknown = graph("Identity", np.full(1, np.nan))
        return unknown, unknown
    off = graph("Max", graph("Mul", doubt, factor), LEAST_OFF_RAD)
    deviation = graph("Div", off, DEVIATIONS_OF_90_PERCENT)
    return bearings.heading, graph("Where", graph("IsNaN", bearings.heading), np.nan, deviation)


def _trace(graph: Graph, matrix: str) -> str:
    """(1,) of a matrix (2, 2)."""
    return graph.shaped(graph.total(graph("Mul", matrix, np.eye(2)), 0, 1), 1)


def _blank(graph: Graph, panorama: str) -> str:
    offset = graph("Sub", panorama, graph("ReduceMean", panorama, keepdims=1))
    deviation = graph("Sqrt", graph("ReduceMean", graph.square(offset), keepdims=0))
    return graph("Less", deviation, MIN_CONTRAST)


def _code(status: Status) -> NDArray[np.int64]:
    return np.array([STATUSES.index(status)])
