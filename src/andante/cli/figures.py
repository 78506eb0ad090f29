"""Figures of an evaluation as a table for people."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import typer

from andante.cli.output import hint, print_table

_METRES = {
    "median_m": "median [m]",
    "mean_m": "mean [m]",
    "p95_m": "p95 [m]",
    "max_m": "max [m]",
    "share_over_1m": "> 1 m [%]",
    "share_over_3m": "> 3 m [%]",
}
_PLACES = {
    "median": "median [places]",
    "mean": "mean",
    "p95": "p95",
    "max": "max",
    "share_within_1": "within 1 [%]",
    "share_within_3": "within 3 [%]",
}
_OTHERS = {"lost_share": "lost [%]", "heading_median_deg": "heading [deg]", "ms_per_image": "ms/image"}


def print_figures(values: Mapping[str, Any]) -> None:
    """``Evaluation.as_dict()``: the map in the first row, below it the baselines where they were asked for."""
    columns = _PLACES if values["unit"] == "place" else _METRES
    rows = []
    for name, figures in {"map": values, **values["baselines"]}.items():
        shown = {**figures, **(figures["places"] or {})}
        rows.append((name, *(_shown(key, shown[key]) for key in (*columns, *_OTHERS))))
    print_table(f"{values['recording']}: {values['n']} images", ("", *columns.values(), *_OTHERS.values()), rows)
    if values["verdict"] is not None:
        typer.echo(values["verdict"])
    for note in values["notes"]:
        hint(note)


def _shown(key: str, value: float | None) -> float | None:
    return 100 * value if value is not None and "share" in key else value
