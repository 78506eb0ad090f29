"""``andante simulate``: a plan or a few options in, rendered recordings out."""

from __future__ import annotations

import os
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from andante.cli.options import AsJson, check_folder
from andante.cli.output import examples, hint, print_facts, print_json, progress_bars

if TYPE_CHECKING:
    from andante.simulator import Plan

Trajectory = Literal["border", "infield", "grid"]

EPILOG = examples(
    "andante simulate -o garden",
    "andante simulate -o garden --size 20x15 --sessions summer,winter --frames 200 --seed 3",
    "andante simulate -o garden --plan plan.toml --boxes",
)


def command(
    *,
    output: Annotated[
        Path,
        typer.Option("--output", "-o", metavar="DIR", show_default=False, help="One recording for each session there."),
    ],
    plan: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="TOML file that says everything; goes without the six below. Default: none."),
    ] = None,
    seed: Annotated[
        int | None, typer.Option(min=0, help="Garden, light, way and noise follow from it. Default: 0.")
    ] = None,
    size: Annotated[
        str | None, typer.Option(metavar="WxH", help="Width and depth of the garden in metres. Default: 15x15.")
    ] = None,
    sessions: Annotated[
        str | None,
        typer.Option(metavar="SEASONS", help="Of spring, summer, autumn, winter. Default: summer,autumn,winter."),
    ] = None,
    trajectory: Annotated[Trajectory | None, typer.Option(help="The way of the robot. Default: border.")] = None,
    frames: Annotated[
        int | None,
        typer.Option(min=1, help="Images a session. Default: one every 0.134 m (infield: 500; grid: every 0.5 m)."),
    ] = None,
    image_px: Annotated[
        int | None, typer.Option("--image-px", min=16, max=4096, help="Side of the fisheye images. Default: 480.")
    ] = None,
    workers: Annotated[
        int | None, typer.Option(min=1, help="Processes, which do not change a byte. Default: one for each processor.")
    ] = None,
    boxes: Annotated[
        bool, typer.Option("--boxes", help="Write object boxes to DIR/SESSION.boxes.csv. Default: off.")
    ] = False,
    as_json: AsJson = False,
) -> None:
    """Render drives through a made garden; sessions that are complete already are kept."""
    check_folder(output, "-o")
    flags = {
        "seed": seed,
        "size": size,
        "sessions": sessions,
        "trajectory": trajectory,
        "frames": frames,
        "image_px": image_px,
    }
    values = _render(
        _resolved(plan, {name: value for name, value in flags.items() if value is not None}), output, workers, boxes
    )
    for name in values["skipped"]:
        hint(f"{output / name} is complete already and was kept")
    if as_json:
        print_json(values)
    else:
        _print(output, values)


def _resolved(file: Path | None, flags: dict[str, Any]) -> Plan:
    """The plan of a file, or that of the options; both at once is wrong usage."""
    from andante.cli.plans import garden_of, plan_of, seasons_of
    from andante.simulator import Plan

    if file is None:
        garden = garden_of(flags.get("size", "15x15"), flags.get("seed", 0))
        seasons = seasons_of(flags.get("sessions", "summer,autumn,winter"))
        trajectory, frames = flags.get("trajectory", "border"), flags.get("frames")
        return plan_of(garden, seasons, trajectory, frames, flags.get("image_px", 480))
    if flags:
        named = ", ".join(f"--{name.replace('_', '-')}" for name in flags)
        raise typer.BadParameter(f"--plan says everything already; leave out {named} or write it into {file}")
    return Plan.from_toml(file)


def _render(plan: Plan, output: Path, workers: int | None, boxes: bool) -> dict[str, Any]:
    from andante.simulator import render_plan

    started = time.perf_counter()
    there = [session.name for session in plan.sessions if (output / session.name).exists()]
    with progress_bars() as progress:
        found = render_plan(plan, output, workers=workers or os.cpu_count() or 1, boxes=boxes, progress=progress)
    seconds = time.perf_counter() - started
    rendered = sum(len(one.infos) for one in found if one.folder.name not in there)
    return {
        "recordings": [str(one.folder) for one in found],
        "frames": sum(len(one.infos) for one in found),
        "seconds": seconds,
        "images_per_second": rendered / seconds if rendered else None,
        "skipped": there,
    }


def _print(output: Path, values: dict[str, Any]) -> None:
    rate = values["images_per_second"]
    facts = {
        "recordings": ", ".join(Path(path).name for path in values["recordings"]),
        "images": values["frames"],
        "seconds": f"{values['seconds']:.1f}",
        "speed": None if rate is None else f"{rate:.1f} images/s",
    }
    print_facts(str(output), facts)
