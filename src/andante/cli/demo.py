"""``andante demo``: the whole story on a garden of its own."""

from __future__ import annotations

import os
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from andante.cli.figures import print_figures
from andante.cli.options import AsJson, check_folder
from andante.cli.output import examples, print_facts, print_json, progress_bars

if TYPE_CHECKING:
    from andante.evaluation import Evaluation
    from andante.simulator import Plan
    from andante.simulator.conditions import Season

EPILOG = examples("andante demo", "andante demo output/demo --open")

_MAPPED: tuple[Season, ...] = ("summer", "autumn")
_TEST: Season = "winter"
_GRID = "grid"
# The thesis' network (5.1), smaller because it learns from some hundred pictures only.
_EVERYWHERE = {
    "features": {"n_frequencies": 15, "normalise": False, "orientations": 0, "unit": False},
    "learning": {"expansion": "quadratic", "reduced_dim": 10, "slow_features": 8, "ridge": 1e-2, "edge_ridge": 0.0},
}


def command(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="DIR", show_default=False, help="Where recordings, map and report go. Default: output/demo."
        ),
    ] = Path("output/demo"),
    *,
    frames: Annotated[int, typer.Option(min=10, help="Images a season. Default: 150.", show_default=False)] = 150,
    image_px: Annotated[
        int, typer.Option("--image-px", min=48, max=1024, help="Side of the images. Default: 320.", show_default=False)
    ] = 320,
    show: Annotated[bool, typer.Option("--open", help="Open the report in a browser. Default: off.")] = False,
    as_json: AsJson = False,
) -> None:
    """Render a garden, map it in summer and autumn, find the way in winter, and write a report."""
    check_folder(folder, "DIR")
    told = _tell(_plan(frames, image_px), folder)
    if as_json:
        print_json({**told.evaluation.as_dict(), "seconds": told.seconds, "report": str(told.page)})
    else:
        print_figures(told.evaluation.as_dict())
        print_facts("Seconds", told.seconds)
        typer.echo(f"report: {told.page}")
    if show:
        import webbrowser

        webbrowser.open(told.page.resolve().as_uri())


@dataclass
class _Told:
    """What the demo came to, and the seconds of its stages."""

    evaluation: Evaluation
    page: Path
    seconds: dict[str, float]


@dataclass
class _Clock:
    seconds: dict[str, float] = field(default_factory=dict)

    @contextmanager
    def stage(self, name: str) -> Iterator[None]:
        start = time.perf_counter()
        yield
        self.seconds[name] = time.perf_counter() - start


def _plan(frames: int, image_px: int) -> Plan:
    """Three drives around a small garden, things left lying about in two, and a grid of places."""
    from andante.cli.plans import plan_of
    from andante.simulator import GardenSpec, GridRun, Plan

    plan = plan_of(GardenSpec(seed=3), (*_MAPPED, _TEST), "border", frames, image_px)
    summer, autumn, winter = plan.sessions
    return Plan(
        garden=plan.garden,
        camera=plan.camera,
        sessions=(
            summer,
            autumn.model_copy(update={"objects": ("car", "bicycle", "umbrella")}),
            winter.model_copy(update={"objects": ("cow", "person", "suitcase")}),
            summer.model_copy(update={"name": _GRID, "drive": GridRun(spacing_m=0.8)}),
        ),
    )


def _tell(plan: Plan, folder: Path) -> _Told:
    """Render, map, localize, look at what was learnt, write."""
    from andante.evaluation import Section, evaluate, slow_feature_maps, write_report
    from andante.evaluation.story import sections_of
    from andante.mapping import MapConfig, build_map
    from andante.simulator import render_plan

    clock = _Clock()
    with progress_bars() as progress:
        with clock.stage("render"):
            # Another plan gets another folder, so that what an older version rendered is never in the way.
            rendered = folder / f"recordings-{plan.fingerprint(_TEST)[:8]}"
            recordings = render_plan(plan, rendered, workers=os.cpu_count() or 1, progress=progress)
            drives = {recording.name: recording for recording in recordings}
        with clock.stage("map"):
            slowmap = build_map([drives[name] for name in _MAPPED], progress=progress)
            slowmap.save(folder / "garden.andante")
        with clock.stage("localize"):
            evaluation = evaluate(slowmap, drives[_TEST], baselines=True, progress=progress)
        with clock.stage("slow features"):
            # As in thesis figure 9.1 a: learnt from, and shown for, pictures from all over the garden.
            everywhere = build_map([drives[_GRID]], MapConfig().with_values(_EVERYWHERE), progress=progress)
            maps = slow_feature_maps(everywhere, drives[_GRID], progress=progress)
        with clock.stage("report"):
            spent = tuple((stage, f"{seconds:.1f}") for stage, seconds in clock.seconds.items())
            sections = sections_of(plan, (*_MAPPED, _TEST), evaluation, slowmap, maps)
            sections.append(Section("Seconds", rows=spent))
            page = write_report(evaluation, folder, slowmap, sections)
    return _Told(evaluation, page, {**clock.seconds, "total": sum(clock.seconds.values())})
