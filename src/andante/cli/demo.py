"""``andante demo``: the whole story on the example garden."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from andante.cli.figures import print_figures
from andante.cli.options import AsJson
from andante.cli.output import examples, print_facts, print_json, progress_bars
from andante.errors import RecordingError

EPILOG = examples("andante demo", "andante demo output/demo --data ../shared/data")

_TRAINING = ("border_summer", "border_autumn")
_TEST = "border_winter"


def command(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", show_default=False, help="Where the map and the report go. Default: output/demo."
        ),
    ] = Path("output/demo"),
    data: Annotated[
        Path,
        typer.Option(
            envvar="ANDANTE_DATA",
            show_default=False,
            help="The folder with garden_a. Default: $ANDANTE_DATA or ../shared/data.",
        ),
    ] = Path("../shared/data"),
    as_json: AsJson = False,
) -> None:
    """Map a garden in summer and autumn, find the way in winter, and write a report."""
    from andante.evaluation import evaluate, write_report
    from andante.mapping import BuildLog, build_map
    from andante.recordings import open_recording

    garden = data / "garden_a"
    for name in (*_TRAINING, _TEST):
        if not (garden / name).is_dir():
            raise RecordingError(f"the demo needs {garden / name}, which is missing; say where it is with --data")
    folder.mkdir(parents=True, exist_ok=True)
    log = BuildLog()
    with progress_bars() as progress:
        slowmap = build_map([open_recording(garden / name) for name in _TRAINING], progress=progress, log=log)
        slowmap.save(folder / "garden.andante")
        evaluation = evaluate(slowmap, open_recording(garden / _TEST), baselines=True, progress=progress)
    page = write_report(evaluation, folder, slowmap)
    if as_json:
        print_json({**evaluation.as_dict(), "seconds": log.seconds, "report": str(page)})
        return
    print_figures(evaluation.as_dict())
    print_facts("Seconds to map", log.seconds)
    typer.echo(f"report: {page}")
