"""``andante navigate``: a map, a simulated world and a goal in, a drive out."""

from __future__ import annotations

import math
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from andante.cli.options import AsJson, MapFile, check_folder
from andante.cli.output import examples, print_facts, print_json
from andante.errors import InputError

if TYPE_CHECKING:
    from andante.cli.worlds import SimulatedWorld
    from andante.data import Pose2D
    from andante.mapping import SlowMap


EPILOG = examples(
    "andante navigate garden.andante --world plan.toml --goal 2.5,-1",
    "andante navigate garden.andante --world garden --goal 2.5,-1,1.57 --season winter --report report",
    "andante navigate garden.andante --world garden --goal-image come-back-here.jpg --json",
)

Season = Literal["spring", "summer", "autumn", "winter"]
_REACH_M = 1.5
_BODY_M = 0.2


@dataclass(frozen=True)
class Options:
    """Of the drive, apart from where it goes."""

    guard: bool
    noise: float
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
    start: Annotated[str | None, typer.Option(metavar="X,Y,HEADING", help="Default: a mapped place by chance.")] = None,
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
        Path | None, typer.Option(metavar="DIR", help="Write drive.svg and drive.json there. Default: none.")
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Drive a simulated robot to a goal along the ways of a map, seeing only what its camera renders."""
    from andante.cli.worlds import world_of
    from andante.mapping import SlowMap

    if (goal is None) == (goal_image is None):
        raise typer.BadParameter("give one of --goal and --goal-image")
    if report is not None:
        check_folder(report, "--report")
    slowmap = SlowMap.load(map_file, with_memory=True)
    where = _goal(slowmap, goal, goal_image)
    options = Options(guard, odometry_noise, timeout, seed)
    values, picture = _drive(slowmap, world_of(world, season), where, start, options)
    if report is not None:
        _write(report, values, picture)
    if as_json:
        print_json(values)
    else:
        print_facts(str(map_file), values)


def _drive(
    slowmap: SlowMap, world: SimulatedWorld, goal: Pose2D, start: str | None, options: Options
) -> tuple[dict[str, Any], str]:
    """The figures of a drive and its picture."""
    import numpy as np

    from andante.evaluation.drive_plot import drive_plot
    from andante.evaluation.experiments.navigation_trials import WatchedRobot
    from andante.localization import make_tracker
    from andante.navigation import Guarded, Limits, PlaceGraph, PlaceGraphNavigator, drive, tracked
    from andante.navigation.place_graph import length_m
    from andante.simulator import OdometryNoise, Scene, make_garden

    graph = PlaceGraph.of(slowmap)
    garden = make_garden(world.garden)
    scene = Scene.of(garden.things)
    begin = _numbers(start, "--start", (3,)) if start else _start(slowmap, options.seed)
    if scene.obstacles.clearance_m([(begin.x_m, begin.y_m)])[0] < _BODY_M:
        raise InputError(f"the start ({begin.x_m:g}, {begin.y_m:g}) is inside of something; choose another --start")
    usual = OdometryNoise().model_dump()
    robot = WatchedRobot(
        scene,
        begin,
        conditions=world.conditions,
        camera=world.camera,
        noise=OdometryNoise(**{name: value * options.noise for name, value in usual.items()}),
        radius_m=_BODY_M,
        range_reach_m=_REACH_M,
        seed=options.seed,
    )
    inner = PlaceGraphNavigator(graph, goal, Limits(timeout_s=options.timeout_s))
    navigator = Guarded(inner) if options.guard else inner
    run = drive(robot, tracked(make_tracker(slowmap, seed=options.seed)), navigator)
    way, shortest = np.array(robot.xy_m), graph.path((begin.x_m, begin.y_m), (goal.x_m, goal.y_m))
    values = {
        "arrived": run.arrived,
        "outcome": str(run.outcome),
        "reason": run.reason,
        "distance_m": math.dist(way[-1], (goal.x_m, goal.y_m)),
        "path_m": length_m(way),
        "shortest_m": None if shortest is None else length_m(shortest),
        "seconds": run.seconds,
        "bumps": robot.hits,
        "replans": inner.replans,
        "ms_per_step": float(np.median(run.milliseconds)),
    }
    return values, drive_plot(run, way, shortest, graph.xy_m, garden)


def _start(slowmap: SlowMap, seed: int) -> Pose2D:
    import numpy as np

    from andante.data import Pose2D

    rng = np.random.default_rng(seed)
    places = np.concatenate([session.xy for session in slowmap.memory or ()])
    x, y = places[rng.integers(len(places))]
    return Pose2D(float(x), float(y), float(rng.uniform(-np.pi, np.pi)))


def _goal(slowmap: SlowMap, text: str | None, image: Path | None) -> Pose2D:
    from andante.data import Pose2D
    from andante.recordings import read_image

    if any(source.poses != "reference" for source in slowmap.sources):
        raise InputError("this map has a frame of its own; to drive in a simulated world, map it with reference poses")
    if image is None:
        return _numbers(text or "", "--goal", (2, 3))
    estimate = slowmap.localize(read_image(image))
    if estimate.x_m is None or estimate.y_m is None:
        raise InputError(f"--goal-image {image} cannot be located: {estimate.reason}; use another one or --goal")
    return Pose2D(estimate.x_m, estimate.y_m)


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


def _write(folder: Path, values: dict[str, Any], picture: str) -> None:
    import json

    from andante.evaluation.files import write_text

    folder.mkdir(parents=True, exist_ok=True)
    write_text(folder / "drive.svg", picture)
    write_text(folder / "drive.json", json.dumps(values, indent=2) + "\n")
