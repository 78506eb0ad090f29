"""``andante evaluate``: a map and a recording with reference poses in, errors out."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from andante.cli.figures import print_figures
from andante.cli.options import AsJson, MapFile, ReportFolder, TrainingError, check_folder
from andante.cli.output import examples, print_json, progress_bars

EPILOG = examples(
    "andante evaluate garden.andante garden/sunday",
    "andante evaluate garden.andante garden/sunday --baselines --report report",
    "andante evaluate garden.andante garden/monday --training-error --json",
)


def command(
    map_file: MapFile,
    recording: Annotated[
        Path,
        typer.Argument(
            metavar="REC", show_default=False, help="A recording with reference poses that the map was not learnt from."
        ),
    ],
    *,
    baselines: Annotated[
        bool,
        typer.Option("--baselines", help="Compare with plain localizers on the same split. Default: off."),
    ] = False,
    train: Annotated[
        list[Path] | None,
        typer.Option(metavar="REC", help="What baselines learn from; repeatable. Default: the map's recordings."),
    ] = None,
    report: ReportFolder = None,
    training_error: TrainingError = False,
    as_json: AsJson = False,
) -> None:
    """Measure how far a map is wrong on a recording that it has not seen."""
    from andante.evaluation import evaluate, write_report
    from andante.mapping import SlowMap
    from andante.recordings import open_recording

    if report is not None:
        check_folder(report, "--report")
    # With what it remembers, by which a map of odometry is laid over the truth.
    slowmap, test = SlowMap.load(map_file, with_memory=True), open_recording(recording)
    training = [open_recording(one) for one in train] if train else None
    with progress_bars() as progress:
        evaluation = evaluate(
            slowmap, test, baselines=baselines, training=training, training_error=training_error, progress=progress
        )
    page = None if report is None else write_report(evaluation, report, slowmap)
    if as_json:
        print_json({**evaluation.as_dict(), "report": None if page is None else str(page)})
        return
    print_figures(evaluation.as_dict())
    if page is not None:
        typer.echo(f"report: {page}")
