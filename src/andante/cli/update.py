"""``andante update``: learns more drives into a map."""

from __future__ import annotations

import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from andante.cli.options import AsJson, MapFile
from andante.cli.output import examples, hint, print_facts, print_json, print_table, progress_bars
from andante.cli.trials import held_out_mean, print_closings, print_trials

if TYPE_CHECKING:
    from andante.mapping.living import Trial

EPILOG = examples(
    "andante update garden.andante garden/winter",
    "andante update garden.andante garden/november garden/december --json",
)

Force = Annotated[
    bool, typer.Option("--force", help="Add drives that do not seem to fit as well. Default: they are refused.")
]


def command(
    map_file: MapFile,
    recordings: Annotated[
        list[Path],
        typer.Argument(metavar="REC...", show_default=False, help="New drives in the map's frame of reference."),
    ],
    *,
    force: Force = False,
    as_json: AsJson = False,
) -> None:
    """Learn more drives into a map, as if they had been there from the beginning.

    Where one of them would make the map worse (wrong poses, another garden, a robot that stood) it is refused, and the
    map stays as it was. The map before is kept: see andante history, andante rollback.
    """
    from andante.mapping import BuildLog, SlowMap
    from andante.mapping.history import digest_of, replace_map
    from andante.mapping.living import update_map
    from andante.recordings import open_recording

    started, log, trials = time.perf_counter(), BuildLog(), list["Trial"]()
    expected = digest_of(map_file)
    slowmap = SlowMap.load(map_file, with_memory=True)
    with progress_bars() as progress:
        for one in recordings:
            slowmap, trial = update_map(slowmap, open_recording(one), force=force, progress=progress, log=log)
            trials.append(trial)
    size = replace_map(slowmap, map_file, expected=expected)
    log.seconds["total"] = time.perf_counter() - started
    summary = {"map": str(map_file), "bytes": size, **learnt_summary(slowmap.describe(), trials)}
    summary["seconds"] = {
        stage: log.seconds.get(stage) for stage in ("decode", "features", "learn", "readout", "total")
    }
    summary["odometry"] = [asdict(closing) for closing in log.closings]
    if as_json:
        print_json(summary)
    else:
        print_learnt(summary)
        print_closings(summary["odometry"])


def learnt_summary(described: dict[str, Any], trials: list[Trial]) -> dict[str, Any]:
    """What is told of a map that has learnt more, as plain values."""
    return {
        "recordings": [one["name"] for one in described["recordings"]],
        "frames": sum(one["frames"] for one in described["recordings"]),
        "slow_features": described["slow_features"],
        "unit": described["unit"],
        "added": [trial.as_dict() for trial in trials],
        "held_out_mean": held_out_mean(described["cross_validation"]),
        "cross_validation": described["cross_validation"],
    }


def print_learnt(summary: dict[str, Any]) -> None:
    """The same as tables."""
    facts = {
        "drives": f"{len(summary['recordings'])}: {', '.join(summary['recordings'])}",
        "frames": summary["frames"],
        "slow features": summary["slow_features"],
        "size": f"{summary['bytes'] / 1e6:.2f} MB",
        "seconds": ", ".join(
            f"{stage} {value:.2f}" for stage, value in summary["seconds"].items() if value is not None
        ),
    }
    print_facts(summary["map"], facts)
    unit = summary["unit"]
    columns = ("added", "images", "on mapped places", "agreeing", "by chance", f"median off [{unit}]")
    keys = ("name", "frames", "overlap", "agreeing", "chance", "off")
    print_table("How the new drives fitted", columns, [tuple(one[key] for key in keys) for one in summary["added"]])
    for one in summary["added"]:
        if one["objection"]:
            hint(f"{one['name']} was added by --force although {one['objection']}")
    print_trials(summary["cross_validation"], unit)
