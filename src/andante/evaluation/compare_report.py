"""One self-contained HTML page on a comparison."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from andante.data import FloatArray, Trajectory
from andante.evaluation.compare import Comparison
from andante.evaluation.compare_tables import tables_of
from andante.evaluation.pages import render_page
from andante.evaluation.plots import svg
from andante.evaluation.report import conditions, number, shown_plots, write_page
from andante.evaluation.tables import Cell, Table


def write_comparison(comparison: Comparison, folder: str | Path) -> Path:
    """Write ``report.html`` to a folder, which is made where it does not exist; gives the path of the page.

    The page needs nothing but itself. Raises ``InputError`` where it cannot be written.
    """
    return write_page(folder, render_comparison(comparison))


def render_comparison(comparison: Comparison) -> str:
    """The page as text."""
    return render_page(
        "compare.html.j2",
        comparison=comparison,
        frames=sum(len(one.infos) for one in comparison.mapped),
        tests=[(test.name, conditions(test)) for test in comparison.tests],
        tables=[_as_text(table) for table in tables_of(comparison)],
        remarks=remarks(comparison),
        plots=_plots(comparison),
    )


def remarks(comparison: Comparison) -> tuple[str, ...]:
    """Why methods failed, what those that did not have to say, and the notes of the comparison."""
    failed = [f"{one.name} failed: {one.failure}" for one in comparison.entries if one.failure is not None]
    said = [f"{one.name}: {note}" for one in comparison.entries for note in one.notes]
    return (*failed, *said, *comparison.notes)


def mapped_positions(comparison: Comparison) -> FloatArray:
    """Where the mapped frames truly were (n, 2); none where only their odometry is known."""
    xy = np.concatenate([Trajectory.of(one.infos, "reference").xy_m for one in comparison.mapped])
    known: FloatArray = xy[np.isfinite(xy).all(axis=1)]
    return known


def _plots(comparison: Comparison) -> list[dict[str, str]]:
    from andante.evaluation.compare_plots import error_distributions, error_maps

    told = {
        test.name: {one.name: one.tests[test.name] for one in comparison.entries if one.failure is None}
        for test in comparison.tests
    }
    mapped = mapped_positions(comparison)
    maps = [(f"Where: {name}", svg(error_maps(answers, mapped))) for name, answers in told.items()]
    return shown_plots(*maps, ("How often how wrong", svg(error_distributions(told))))


def _as_text(table: Table) -> dict[str, Any]:
    """A table as the page shows it, without columns that have no value."""
    used = [at for at in range(len(table.columns)) if any(row[at] is not None for row in table.rows)]
    return {
        "title": table.title,
        "columns": [table.columns[at] for at in used],
        "rows": [[_text(row[at]) for at in used] for row in table.rows],
        "verdict": table.verdict,
    }


def _text(cell: Cell) -> str:
    return number(cell, 3) if cell is None or isinstance(cell, float) else str(cell)
