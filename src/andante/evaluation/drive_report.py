"""One self-contained HTML page on a drive to a goal."""

from __future__ import annotations

import json
from pathlib import Path

from andante.evaluation.pages import render_page
from andante.evaluation.report import shown_plots, write_page
from andante.evaluation.simulated_drive import DrivenWorld, SimulatedDrive
from andante.evaluation.steering import Steering
from andante.mapping import SlowMap

_MOST_CHANGES = 60
_CONDITIONS = ("season", "hour", "clouds")


def write_drive_report(
    one: SimulatedDrive, folder: str | Path, slowmap: SlowMap, world: DrivenWorld, steering: Steering
) -> Path:
    """Write ``report.html`` to a folder, which is made where it does not exist; gives the path of the page.

    The page needs nothing but itself. Raises ``InputError`` where it cannot be written.
    """
    figures = one.as_dict()
    shortest = figures["shortest_m"]
    tiles = [
        ("from the goal at the end, m", f"{figures['distance_m']:.2f}"),
        ("driven, m", f"{figures['path_m']:.1f}"),
        ("the shortest way, m", "none" if shortest is None else f"{shortest:.1f}"),
        ("seconds", f"{figures['seconds']:.0f}"),
        ("contacts", str(figures["collisions"])),
        ("ms a control step", f"{figures['ms_per_step']:.1f}"),
    ]
    begun = one.run.timestamp_s[0]
    changes = [
        {"time": f"{c.timestamp_s - begun:.1f}", "state": str(c.state).replace("_", " "), "reason": c.reason}
        for c in one.changes
    ]
    conditions = world.conditions.model_dump()
    page = render_page(
        "drive.html.j2",
        map_name=slowmap.name,
        goal=one.goal.name,
        navigator=steering.navigator.name,
        conditions=[(key, conditions[key]) for key in _CONDITIONS] + [("odometry noise", f"x{world.odometry_noise:g}")],
        tiles=tiles,
        outcome=str(one.run.outcome).replace("_", " ").capitalize(),
        reason=one.run.reason,
        plots=shown_plots(*_plots(one, world, steering)),
        changes=changes[:_MOST_CHANGES],
        more_changes=max(0, len(changes) - _MOST_CHANGES),
        sources=slowmap.sources,
        config=json.dumps(slowmap.config.model_dump(mode="json"), indent=2),
    )
    return write_page(folder, page)


def _plots(one: SimulatedDrive, world: DrivenWorld, steering: Steering) -> list[tuple[str, str | None]]:
    from andante.evaluation import drive_plots

    drawn: list[tuple[str, str | None]] = [
        ("The way", drive_plots.from_above(one, steering.places_m, steering.plans, world.garden)),
        ("Distance over time; what the navigator was about, and how sure estimates were", drive_plots.over_time(one)),
    ]
    if steering.cost is not None:
        title = "What every mapped place costs, by slow features alone"
        drawn.append((title, drive_plots.costs(steering.places_m, steering.cost, one, world.garden)))
    return drawn
