"""Figures in rows below named columns, for the command line, pages and files alike."""

from __future__ import annotations

from dataclasses import dataclass

Cell = str | float | int | None


@dataclass(frozen=True)
class Table:
    """Rows below named columns; the first column names the row, ``None`` is what is unknown.

    ``verdict`` is what stands first below the table, empty where there is nothing to say.
    """

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[Cell, ...], ...]
    verdict: str = ""
