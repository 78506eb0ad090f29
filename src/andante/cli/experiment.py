"""``andante experiment``: an experiment of the thesis once more."""

from __future__ import annotations

import os
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

import typer

from andante.cli.options import AsJson, check_folder
from andante.cli.output import examples, hint, print_json, print_table, progress_bars

if TYPE_CHECKING:
    from andante.evaluation.experiments import Written

EPILOG = examples(
    "andante experiment --list",
    "andante experiment static",
    "andante experiment long-term --scale thesis --out output/thesis",
)


def command(
    name: Annotated[
        str | None, typer.Argument(metavar="NAME", show_default=False, help="Which one. Default: list them.")
    ] = None,
    *,
    scale: Annotated[
        Literal["small", "thesis"],
        typer.Option(help="A few minutes, or all images of the thesis. Default: small.", show_default=False),
    ] = "small",
    out: Annotated[
        Path, typer.Option(metavar="DIR", help="Where figures go. Default: output/experiments.", show_default=False)
    ] = Path("output/experiments"),
    cache: Annotated[
        Path | None,
        typer.Option(metavar="DIR", help="Rendered drives and finished parts. Default: ~/.cache/andante/simulated."),
    ] = None,
    seed: Annotated[int | None, typer.Option(min=0, help="Another garden, other drives. Default: 23.")] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes that render. Default: one for each processor.")
    ] = None,
    list_: Annotated[bool, typer.Option("--list", help="List all experiments. Default: off.")] = False,
    as_json: AsJson = False,
) -> None:
    """Redo an experiment of the thesis; a run that was stopped goes on where it was."""
    if name is None or list_:
        _list(as_json=as_json)
        return
    from andante.evaluation.experiments import run_experiment

    check_folder(out, "--out")
    if cache is not None:
        check_folder(cache, "--cache")
    with progress_bars() as progress:
        written = run_experiment(
            name,
            out,
            scale=scale,
            cache=cache,
            seed=seed,
            workers=workers or os.cpu_count() or 1,
            progress=progress,
        )
    if as_json:
        print_json(written.as_dict())
    else:
        _print(written)


def _list(*, as_json: bool) -> None:
    from andante.evaluation.experiments import EXPERIMENTS

    if as_json:
        keys = ("name", "title", "source", "thesis")
        print_json({"experiments": [{key: getattr(one, key) for key in keys} for one in EXPERIMENTS]})
        return
    rows = [(one.name, one.title, one.thesis, one.source) for one in EXPERIMENTS]
    print_table("Experiments", ("name", "what", "the thesis got", "thesis"), rows)


def _print(written: Written) -> None:
    for table in written.outcome.tables:
        print_table(table.title, table.columns, table.rows)
        if table.verdict:
            typer.echo(table.verdict)
    typer.echo(f"thesis {written.experiment.source}: {written.experiment.thesis}")
    for note in written.outcome.notes:
        hint(note)
    for path in (written.json, *written.plots, written.page):
        typer.echo(path)
