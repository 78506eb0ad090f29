"""Arguments and options that several commands share."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer

from andante.errors import InputError

MapFile = Annotated[Path, typer.Argument(metavar="MAP", show_default=False, help="A map file, made with: andante map.")]
TumFile = Annotated[
    Path | None,
    typer.Option(metavar="FILE", help="Write poses as a TUM trajectory (seconds, metres). Default: none."),
]
CsvFile = Annotated[
    Path | None, typer.Option(metavar="FILE", help="Write a table (seconds, metres, radians). Default: none.")
]
ReportFolder = Annotated[
    Path | None, typer.Option(metavar="DIR", help="Write an HTML report with plots there. Default: none.")
]
TrainingError = Annotated[
    bool,
    typer.Option("--training-error", help="Allow a recording that the map was learnt from. Default: refused."),
]
AsJson = Annotated[
    bool, typer.Option("--json", help="Print one JSON object to stdout instead of tables. Default: tables.")
]


def check_folder(path: Path, option: str) -> None:
    """Raise ``InputError`` where no folder can be: before the work that would be lost, not after it."""
    if path.exists() and not path.is_dir():
        raise InputError(f"{option} {path} is a file; give the name of a folder, which may be new")


def check_place(path: Path, option: str) -> None:
    """Raise ``InputError`` where a file cannot be written: before the work that would be lost, not after it."""
    folder = path.parent
    if not folder.is_dir():
        raise InputError(f"{option} {path}: the folder {folder} does not exist; create it or choose another place")
    if path.is_dir():
        raise InputError(f"{option} {path} is a folder; give the name of a file in it")
    if not os.access(folder, os.W_OK):
        raise InputError(f"{option} {path}: the folder {folder} cannot be written to; choose another place")
