"""``andante compare``: all methods of localizing on one split of a user's own drives."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal

import typer

from andante.cli.options import AsJson, ReportFolder, check_folder
from andante.cli.output import examples, hint, print_json, print_table, progress_bars

EPILOG = examples(
    "andante compare garden/monday garden/tuesday --test garden/sunday",
    "andante compare garden/border --test garden/border-later --test garden/lawn --report report",
    "andante compare garden/monday --test garden/sunday --method andante --method posenet --json",
    "andante compare garden/monday --test garden/sunday --method andante --method embedding --weights network.onnx",
    "andante compare --list",
)


def command(
    recordings: Annotated[
        list[Path] | None,
        typer.Argument(metavar="REC", show_default=False, help="Drives that every method learns from. Default: none."),
    ] = None,
    *,
    test: Annotated[
        list[Path] | None,
        typer.Option(
            "--test",
            metavar="REC",
            help="An unseen drive with reference poses; repeatable. Default: none.",
            show_default=False,
        ),
    ] = None,
    method: Annotated[
        list[str] | None,
        typer.Option(
            "--method",
            metavar="NAME",
            show_default=False,
            help="One of the methods that --list names; repeatable. Default: all whose libraries are there.",
        ),
    ] = None,
    positions: Annotated[
        Literal["reference", "odometry"],
        typer.Option(help="What the methods learn positions from. Default: reference.", show_default=False),
    ] = "reference",
    weights: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="ONNX file of a network for the method embedding. Default: none."),
    ] = None,
    quick: Annotated[
        bool, typer.Option("--quick", help="Cut what learns for minutes short, at the price of accuracy. Default: off.")
    ] = False,
    seed: Annotated[int, typer.Option(min=0, help="Decides everything random. Default: 0.", show_default=False)] = 0,
    report: ReportFolder = None,
    list_: Annotated[bool, typer.Option("--list", help="List all methods. Default: off.")] = False,
    as_json: AsJson = False,
) -> None:
    """Learn the same drives by every method, and measure on unseen ones how far each is wrong and what it costs.

    Each table says below it where another method beats andante. One that fails is a row with its reason.
    """
    from andante.baselines import MethodOptions, default_methods, make_methods
    from andante.evaluation.compare import compare
    from andante.evaluation.compare_report import remarks, write_comparison
    from andante.evaluation.compare_tables import tables_of
    from andante.recordings import open_recording

    if list_:
        _list(as_json=as_json)
        return
    if not recordings or not test:
        raise typer.BadParameter("give drives to learn from, and at least one drive with --test REC")
    if report is not None:
        check_folder(report, "--report")
    options = MethodOptions(weights=weights, seed=seed, quick=quick)
    methods, left_out = (make_methods(method, options), ()) if method else default_methods(options)
    mapped, tests = [open_recording(one) for one in recordings], [open_recording(one) for one in test]
    with progress_bars() as progress:
        comparison = compare(mapped, tests, methods, positions=positions, progress=progress)
    comparison = replace(comparison, notes=comparison.notes + left_out)
    page = None if report is None else write_comparison(comparison, report)
    tables = tables_of(comparison)
    if as_json:
        verdicts = {table.title: table.verdict for table in tables if table.verdict}
        print_json({**comparison.as_dict(), "verdicts": verdicts, "report": None if page is None else str(page)})
        return
    for table in tables:
        print_table(table.title, table.columns, table.rows)
        if table.verdict:
            typer.echo(f"{table.verdict}\n")
    typer.echo(f"measured on {comparison.hardware}")
    for remark in remarks(comparison):
        hint(remark)
    if page is not None:
        typer.echo(f"report: {page}")


def _list(*, as_json: bool) -> None:
    from andante.baselines import METHODS

    if as_json:
        rows = [{"name": one.name, "what": one.what, "missing": one.lacks and str(one.lacks)} for one in METHODS]
        print_json({"methods": rows})
        return
    shown = [(one.name, one.what, "yes" if one.lacks is None else str(one.lacks)) for one in METHODS]
    print_table("Methods", ("name", "what", "ready"), shown)
