"""``andante merge``: two maps of one place become one."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer

from andante.cli.options import AsJson, check_place
from andante.cli.output import examples, print_json, progress_bars
from andante.cli.update import Force, learnt_summary, print_learnt

EPILOG = examples("andante merge spring.andante autumn.andante -o year.andante")


def command(
    first: Annotated[Path, typer.Argument(metavar="MAP", show_default=False, help="A map; its camera is kept.")],
    second: Annotated[
        Path, typer.Argument(metavar="MAP", show_default=False, help="Another map of the same place and frame.")
    ],
    *,
    output: Annotated[
        Path,
        typer.Option(
            "--output", "-o", metavar="MAP", show_default=False, help="The map file to write; what it replaces is kept."
        ),
    ],
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Learn one map from all drives of two; drives that are in both count once, those that do not fit are refused."""
    from andante.mapping import SlowMap
    from andante.mapping.history import replace_map
    from andante.mapping.living import merge_maps

    check_place(output, "-o")
    started = time.perf_counter()
    with progress_bars() as progress:
        maps = [SlowMap.load(path, with_memory=True) for path in (first, second)]
        slowmap, trials = merge_maps(*maps, force=force, progress=progress)
    size = replace_map(slowmap, output)
    summary = {"map": str(output), "bytes": size, **learnt_summary(slowmap.describe(), list(trials))}
    summary["seconds"] = {"total": time.perf_counter() - started}
    if as_json:
        print_json(summary)
    else:
        print_learnt(summary)
