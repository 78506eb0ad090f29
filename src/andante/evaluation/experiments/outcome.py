"""What an experiment comes to: tables, plots, and figures as plain values."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

from andante.evaluation.experiments.contenders import Contender
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.statistics import Summary
from andante.evaluation.experiments.trials import Bench
from andante.evaluation.tables import Cell, Table
from andante.simulator import Plan

if TYPE_CHECKING:
    from matplotlib.figure import Figure

__all__ = ["ERROR_COLUMNS", "Cell", "Experiment", "Outcome", "Plot", "Table", "error_cells"]

ERROR_COLUMNS = ("mean [m]", "median [m]", "95 % [m]", "max [m]", "> 1 m [%]")
"""Of ``error_cells``."""


def error_cells(of: Summary) -> tuple[Cell, ...]:
    """The errors of a summary as a row; kilometres have no decimals."""
    values = (of.mean_m, of.median_m, of.p95_m, of.max_m, 100 * of.share_over_1m)
    return tuple(value if value < 1000 else round(value) for value in values)


@dataclass(frozen=True)
class Plot:
    """A drawing; ``suffix`` tells it from others of its experiment, empty for the main one."""

    suffix: str
    caption: str
    figure: Figure = field(repr=False)


@dataclass(frozen=True)
class Outcome:
    """``figures`` are plain values for JSON; ``contenders`` are those whose configurations are written beside them."""

    tables: tuple[Table, ...]
    plots: tuple[Plot, ...]
    figures: Mapping[str, Any]
    contenders: tuple[Contender, ...]
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Experiment:
    """An experiment of the thesis: what it records, how it is run, and what the ``thesis`` got."""

    name: str
    title: str
    source: str
    thesis: str
    plan: Callable[[int, Scale], Plan]
    run: Callable[[Bench, int, Scale], Outcome]
    small: Scale
    full: Scale
