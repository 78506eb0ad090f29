"""``andante navigate``: a map, a simulated world and a goal in, a drive out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from andante.cli.options import AsJson, MapFile, check_folder
from andante.cli.output import examples, print_facts, print_json, progress_bars
from andante.errors import InputError

if TYPE_CHECKING:
    from andante.data import ImageArray, Pose2D
    from andante.evaluation.steering import Steering
    from andante.mapping import SlowMap
    from andante.navigation import Goal


EPILOG = examples(
    "andante navigate garden.andante --world plan.toml --goal 2.5,-1",
    "andante navigate garden.andante --world garden --goal 2.5,-1,1.57 --season winter --report report",
    "andante navigate garden.andante --world garden --goal-image come-back-here.jpg --json",
    "andante navigate garden.andante --world garden --goal-place charging-station",
)

Season = Literal["spring", "summer", "autumn", "winter"]


@dataclass(frozen=True)
class Options:
    """How to steer."""

    gradient: bool
    timeout_s: float
    seed: int


def command(
    map_file: MapFile,
    *,
    world: Annotated[
        Path,
        typer.Option(metavar="DIR_OR_PLAN", show_default=False, help="Plan (TOML), or a folder of andante simulate."),
    ],
    goal: Annotated[
        str | None, typer.Option(metavar="X,Y[,HEADING]", help="Metres and radians in the map. Default: none.")
    ] = None,
    goal_image: Annotated[
        Path | None, typer.Option(metavar="FILE", help="Where this image was taken. Default: none.")
    ] = None,
    goal_place: Annotated[
        str | None,
        typer.Option(metavar="NAME", help="A place of MAP's NAME.places.toml: name = [x, y, heading]. Default: none."),
    ] = None,
    start: Annotated[str | None, typer.Option(metavar="X,Y,HEADING", help="Default: a mapped place by chance.")] = None,
    navigator: Annotated[
        Literal["graph", "gradient"],
        typer.Option(
            help="Plan on driven ways, or follow the gradient of slow features (patented: EP3367061B1, "
            "US10955852B2; learns anew from the images of the longest mapped drive). Default: graph."
        ),
    ] = "graph",
    guard: Annotated[
        bool, typer.Option("--guard/--no-guard", help="Brake before contact (range sensor). Default: on.")
    ] = True,
    odometry_noise: Annotated[float, typer.Option(min=0, max=100, help="Times the usual drift. Default: 1.")] = 1.0,
    season: Annotated[
        Season | None, typer.Option(help="To drive in. Default: that of the world's first session.")
    ] = None,
    timeout: Annotated[float, typer.Option(min=1, metavar="SECONDS", help="Of driving. Default: 300.")] = 300.0,
    seed: Annotated[int, typer.Option(min=0, help="Start, noise and particles follow from it. Default: 0.")] = 0,
    report: Annotated[
        Path | None, typer.Option(metavar="DIR", help="Write report.html and drive.json there. Default: none.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Drive a simulated robot to a goal along the ways of a map, seeing only what its camera renders."""
    from andante.cli.worlds import world_of
    from andante.evaluation.drive_report import write_drive_report
    from andante.evaluation.simulated_drive import DrivenWorld, drive_in_garden
    from andante.mapping import SlowMap
    from andante.navigation import Guarded
    from andante.simulator import make_garden

    if [goal, goal_image, goal_place].count(None) != 2:
        raise typer.BadParameter("give one of --goal, --goal-image and --goal-place")
    if report is not None:
        check_folder(report, "--report")
    slowmap = SlowMap.load(map_file, with_memory=True)
    where, image = _goal(map_file, slowmap, goal, goal_image, goal_place)
    begin = _start(slowmap, seed) if start is None else _numbers(start, "--start", (3,))
    seen = world_of(world, season)
    driven = DrivenWorld(make_garden(seen.garden), seen.camera, seen.conditions, odometry_noise)
    steering = _steering(slowmap, where, image, Options(navigator == "gradient", timeout, seed))
    pilot = Guarded(steering.navigator) if guard else steering.navigator
    one = drive_in_garden(driven, begin, where, pilot, steering.localize, seed=seed)
    page = None if report is None else write_drive_report(one, report, slowmap, driven, steering)
    values = {**one.as_dict(), "replans": steering.replans, "report": None if page is None else str(page)}
    if page is not None:
        _write(page.with_name("drive.json"), values)
    if as_json:
        print_json(values)
    else:
        print_facts(str(map_file), values)


def _steering(slowmap: SlowMap, goal: Goal, image: ImageArray | None, options: Options) -> Steering:
    from andante.evaluation.steering import by_gradient, by_graph
    from andante.navigation import Limits

    limits = Limits(timeout_s=options.timeout_s)
    if not options.gradient:
        return by_graph(slowmap, goal, limits, options.seed)
    with progress_bars() as progress:
        return by_gradient(slowmap, goal, image, limits, progress)


def _start(slowmap: SlowMap, seed: int) -> Pose2D:
    import numpy as np

    from andante.data import Pose2D

    rng = np.random.default_rng(seed)
    places = np.concatenate([session.xy for session in slowmap.memory or ()])
    x, y = places[rng.integers(len(places))]
    return Pose2D(float(x), float(y), float(rng.uniform(-np.pi, np.pi)))


def _goal(
    map_file: Path, slowmap: SlowMap, text: str | None, image: Path | None, place: str | None
) -> tuple[Goal, ImageArray | None]:
    """Where to go, and its image where that is how it was told."""
    from andante.navigation import image_goal, named_goal, pose_goal
    from andante.recordings import read_image

    if any(source.poses != "reference" for source in slowmap.sources):
        raise InputError("this map has a frame of its own; to drive in a simulated world, map it with reference poses")
    if place is not None:
        return named_goal(map_file, place), None
    if image is not None:
        picture = read_image(image)
        return image_goal(slowmap, picture, image.name), picture
    pose = _numbers(text or "", "--goal", (2, 3))
    return pose_goal(pose.x_m, pose.y_m, pose.heading_rad), None


def _numbers(text: str, option: str, counts: tuple[int, ...]) -> Pose2D:
    from andante.data import Pose2D

    try:
        numbers = [float(word) for word in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) not in counts or not all(map(math.isfinite, numbers)):
        form = "X,Y,HEADING" if counts == (3,) else "X,Y or X,Y,HEADING"
        raise InputError(f"{option} {text!r} is no pose; give {form} in metres and radians, such as 1.5,-2,0.5")
    return Pose2D(*numbers)


def _write(path: Path, values: dict[str, Any]) -> None:
    import json

    from andante.evaluation.files import write_text

    write_text(path, json.dumps(values, indent=2) + "\n")
