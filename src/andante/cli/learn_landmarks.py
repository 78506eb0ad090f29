"""``andante learn-landmarks``: labels of landmarks in, a detector of them out."""

from __future__ import annotations

import shlex
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from andante.cli.options import AsJson, check_place
from andante.cli.output import examples, hint, print_json, print_table, progress_bars

if TYPE_CHECKING:
    from andante.landmarks.detector import LandmarkDetector

EPILOG = examples(
    "andante learn-landmarks garden/monday.landmarks -o garden.onnx",
    "andante learn-landmarks garden/monday.landmarks garden/friday.landmarks -o garden.onnx --elsewhere street/monday",
    "andante learn-landmarks labels -o garden.onnx --recordings garden/monday --max-minutes 10 --json",
)

_LOW_SHARE = 0.5


def command(
    folders: Annotated[
        list[Path],
        typer.Argument(metavar="FOLDER...", show_default=False, help="What andante teach wrote, as REC.landmarks."),
    ],
    *,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="NAME.onnx", show_default=False, help="The detector to write; it replaces one."
        ),
    ],
    recordings: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="REC", help="Where a recording that was taught in is now; repeatable. Default: beside its folder."
        ),
    ] = None,
    elsewhere: Annotated[
        list[Path] | None,
        typer.Option(
            metavar="REC",
            help="A recording that shows none of the landmarks, against false ones; repeatable. Default: none.",
        ),
    ] = None,
    steps: Annotated[int, typer.Option(min=1, help="Of learning at most, a number. Default: 600.")] = 600,
    max_minutes: Annotated[float, typer.Option(min=0.01, help="Of learning at most, minutes. Default: 5.")] = 5.0,
    seed: Annotated[int, typer.Option(min=0, help="For all random choices, a number. Default: 0.")] = 0,
    as_json: AsJson = False,
) -> None:
    """Learn to find taught landmarks, in minutes on a CPU, and write a detector for: andante map --landmarks."""
    from andante.landmarks.lesson_folders import read_lessons
    from andante.landmarks.training import TrainingConfig, train_detector
    from andante.recordings import open_recording

    check_place(output, "-o")
    config = TrainingConfig(steps=steps, max_seconds=60.0 * max_minutes, seed=seed)
    taught = read_lessons(folders, recordings or ())
    others = [open_recording(one) for one in elsewhere or ()]
    with progress_bars() as progress:
        detector = train_detector(taught, config, elsewhere=others, progress=progress)
    detector.save(output)
    paths = [str(getattr(recording, "folder", recording.name)) for recording, _ in taught]
    summary = {"detector": str(output), **_summary(detector), "recordings": paths}
    summary["next"] = shlex.join(
        ["andante", "map", *paths, "--landmarks", str(output), "-o", f"{output.with_suffix('').name}.andante"]
    )
    if as_json:
        print_json(summary)
    else:
        _print(summary)


def _summary(detector: LandmarkDetector) -> dict[str, Any]:
    notes = detector.header.notes
    landmarks = []
    for one in detector.header.landmarks:
        reached = notes["held_out"][one.name]
        landmarks.append(
            {
                "name": one.name,
                "labels": notes["labels"][one.name],
                "found": reached["found"],
                "false_positives": reached["false"],
                "iou": reached["iou"],
                "threshold": one.threshold,
            }
        )
    told = {key: notes[key] for key in ("examples", "steps", "seconds", "stopped", "never_found")}
    return {"bytes": len(detector.data), "sha256": detector.sha256, "landmarks": landmarks, **told}


def _print(summary: dict[str, Any]) -> None:
    rows = [
        (
            one["name"],
            one["labels"],
            100 * one["found"],
            100 * one["false_positives"],
            one["threshold"],
        )
        for one in summary["landmarks"]
    ]
    title = (
        f"{summary['detector']}: {summary['bytes'] / 1e6:.2f} MB, {summary['steps']} steps in "
        f"{summary['seconds']:.0f} s, {summary['stopped']}"
    )
    columns = ("landmark", "labels used", "found [%]", "false positives [%]", "threshold")
    print_table(title, columns, rows)
    hint("found and false positives are shares of pictures that were held out, each in light of its own")
    for why in summary["never_found"].values():
        hint(f"never found: {why}")
    for one in summary["landmarks"]:
        if one["found"] < _LOW_SHARE and one["name"] not in summary["never_found"]:
            hint(f"{one['name']} is found in {one['found']:.0%} of them: label it in another drive, or learn longer")
    hint(f"next: {summary['next']}")
