"""Thesis chapter 9: to a goal down the slope of slow features, in the open and around an obstacle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np

from andante.data import FloatArray
from andante.evaluation.experiments.cache import rendered
from andante.evaluation.experiments.navigation_maps import CostMap, cost_maps, travel_correlations
from andante.evaluation.experiments.navigation_trials import (
    DRIVERS,
    KERNEL,
    MAP,
    THESIS,
    Result,
    Task,
    World,
    run_tasks,
)
from andante.evaluation.experiments.navigation_world import (
    GRID,
    MAPPED,
    Errand,
    Lawn,
    fixed_errands,
    navigation_plan,
    random_errands,
    v_wall,
)
from andante.evaluation.experiments.outcome import Cell, Outcome, Plot, Table
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.trials import Bench
from andante.mapping import SlowMap, build_map
from andante.navigation import KERNEL_SIGHT, THESIS_SIGHT, SlowSight, learn_sight
from andante.simulator import Conditions, OdometryNoise, Plan, make_garden
from andante.simulator.conditions import Season

OPEN, OBSTACLE = "in the open", "around the obstacle"
NOTE = (
    "False are drives that claim to have arrived, more than 0.8 m away. "
    "Every image is rendered where the robot is: no table of features is behind these drives. The gradient "
    "methods are patented (EP3367061B1, US10955852B2); the place graph, which is told where the goal is and drives "
    "with the guard on, uses none of it."
)
_COLUMNS = (
    "navigator", "< 0.3 m [%]", "< 0.5 m [%]", "< 0.8 m [%]", "hit [%]", "false [%]", "median end [m]",
    "way / shortest", "seconds",
)  # fmt: skip
_MAIN = tuple(driver.name for driver in DRIVERS if not driver.aside)
_PARTS = tuple(driver.name for driver in DRIVERS)
_ROBUST = ("thesis' gradient", "andante's gradient", "place graph")
_ASIDE_SHARE, _ROBUST_SHARE, _ROBUST_LEAST = 4, 8, 2


@dataclass(frozen=True, eq=False)
class Place:
    """One of the two lawns with what was learnt on it."""

    name: str
    plan: Plan
    lawn: Lawn
    world: World
    sights: dict[str, SlowSight]
    slowmap: SlowMap
    costs: tuple[CostMap, ...]


@dataclass(frozen=True)
class Case:
    """One kind of errand in one world."""

    name: str
    place: Place
    world: World
    errands: tuple[Errand, ...]
    drivers: tuple[str, ...]


def run_navigation(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """Free space and the obstacle, four fixed pairs and random ones; slow-feature maps; robustness (thesis 9.4)."""
    places = tuple(_place(bench, seed, scale, obstacle) for obstacle in (False, True))
    cases = [case for place in places for case in _cases(place, seed, scale)] + _robustness(places[1], seed, scale)
    tasks = [
        Task(driver, case.place.name, case.world, errand, seed=1000 * seed + number)
        for case in cases
        for driver, (number, errand) in product(case.drivers, enumerate(case.errands))
    ]
    results = [dict[str, list[Result]]() for _ in cases]
    sights: dict[tuple[str, str], SlowSight | SlowMap] = {(place.name, MAP): place.slowmap for place in places}
    sights |= {(place.name, name): sight for place in places for name, sight in place.sights.items()}
    done = iter(run_tasks(tasks, sights, workers=bench.workers, progress=bench.progress))
    for case, by_driver in zip(cases, results, strict=True):
        for driver in case.drivers:
            by_driver[driver] = [next(done) for _ in case.errands]
    return _outcome(places, cases, results)


def _place(bench: Bench, seed: int, scale: Scale, obstacle: bool) -> Place:
    plan = navigation_plan(seed, scale, obstacle=obstacle)
    recordings = rendered(plan, bench.cache, workers=bench.workers, progress=bench.progress)
    recipes = {THESIS: THESIS_SIGHT, KERNEL: KERNEL_SIGHT}
    sights = {
        name: learn_sight(recordings[MAPPED], recipe, progress=bench.progress) for name, recipe in recipes.items()
    }
    slowmap = build_map([recordings[MAPPED]], progress=bench.progress)
    lawn = Lawn(make_garden(plan.garden))
    goal = np.array(fixed_errands(lawn, 1, seed)[0].goal)
    costs = cost_maps(sights, recordings[GRID], goal)
    world = World(plan.garden, plan.camera, plan.sessions[0].conditions)
    return Place(OBSTACLE if obstacle else OPEN, plan, lawn, world, sights, slowmap, costs)


def _cases(place: Place, seed: int, scale: Scale) -> list[Case]:
    fixed = tuple(fixed_errands(place.lawn, scale.repeats, seed))
    random = tuple(random_errands(place.lawn, scale.errands, seed))
    aside = random[: max(scale.errands // _ASIDE_SHARE, 1)]
    return [
        Case(f"{place.name}, four pairs", place, place.world, fixed, _MAIN),
        Case(f"{place.name}, random pairs", place, place.world, random, _MAIN),
        Case(f"{place.name}, random pairs, what each part is worth", place, place.world, aside, _PARTS),
    ]


def _robustness(place: Place, seed: int, scale: Scale) -> list[Case]:
    """What a mapped lawn is worth later: worse odometry, another season, an obstacle that was moved."""
    errands = tuple(random_errands(place.lawn, max(scale.errands // _ROBUST_SHARE, _ROBUST_LEAST), seed + 1))
    world, camera = place.world, place.world.camera
    cases = [
        (f"odometry noise x{factor}", World(world.garden, camera, world.conditions, OdometryNoise().times(factor)))
        for factor in (1, 2, 4)
    ]
    cases.append(("with clouds, none mapped", World(world.garden, camera, Conditions(clouds=0.45))))
    seasons: tuple[Season, ...] = ("autumn", "winter")
    for season in seasons:
        then = Conditions(season=season, clouds=0.3, hour=15.0)
        cases.append((f"mapped in summer, driven in {season}", World(world.garden, camera, then)))
        cases.append(
            (
                f"the same in {season}, goal seen in summer",
                World(world.garden, camera, then, goal_conditions=world.conditions),
            )
        )
    moved = world.garden.model_copy(update={"walls": (v_wall(world.garden, shift_m=(0.5, -0.8)),)})
    cases.append(("the obstacle moved by 0.9 m", World(moved, camera, world.conditions)))
    return [Case(name, place, one, _possible(errands, one), _ROBUST) for name, one in cases]


def _possible(errands: Sequence[Errand], world: World) -> tuple[Errand, ...]:
    """Those whose start and goal are free in this world too."""
    obstacles = make_garden(world.garden).obstacles
    free = [obstacles.clearance_m([errand.start[:2], errand.goal]).min() > 0.25 for errand in errands]
    return tuple(errand for errand, possible in zip(errands, free, strict=True) if possible)


def _outcome(places: Sequence[Place], cases: Sequence[Case], results: Sequence[dict[str, list[Result]]]) -> Outcome:
    from andante.evaluation.experiments import navigation_plots as plots

    main = [(case, found) for case, found in zip(cases, results, strict=True) if case.drivers != _ROBUST]
    rest = [(case, found) for case, found in zip(cases, results, strict=True) if case.drivers == _ROBUST]
    tables = [Table(case.name, _COLUMNS, tuple(_row(d, case, found[d]) for d in case.drivers)) for case, found in main]
    rows = tuple(_row(f"{case.name}: {d}", case, found[d]) for case, found in rest for d in case.drivers)
    correlations = {place.name: travel_correlations(place.costs, place.lawn) for place in places}
    tables += [Table("Robustness, random pairs around the obstacle", _COLUMNS, rows), _correlation_table(correlations)]
    shown = (
        Plot(
            "",
            "Share of drives that ended within a distance of the goal (thesis figure 9.5).",
            plots.approach([one for one in main if one[0].drivers == _MAIN]),
        ),
        Plot(
            "ways",
            "Four pairs: drives of the thesis' method and of andante's (figures 9.4, 9.6).",
            plots.ways(main, places),
        ),
        Plot("cost", "The cost of every place and where downhill is (figure 9.1 b).", plots.cost_surfaces(places)),
        Plot("maps", "Slow features over the lawn (figure 9.1 a).", plots.slow_maps(places)),
    )
    figures = {
        "cases": {
            case.name: {d: figures_of(found[d], case.errands) for d in case.drivers}
            for case, found in zip(cases, results, strict=True)
        },
        "correlations": correlations,
    }
    return Outcome(tuple(tables), shown, figures, (), (NOTE,))


def _correlation_table(correlations: dict[str, dict[str, float]]) -> Table:
    names = tuple(next(iter(correlations.values())))
    rows: list[tuple[Cell, ...]] = []
    for name in names:
        rows.append((name, *(round(by_name[name], 3) for by_name in correlations.values())))
    return Table("Correlation of slow-feature distance and true travel distance (Spearman, mean over goals)",
                 ("distance", *correlations), tuple(rows))  # fmt: skip


def _row(name: str, case: Case, found: Sequence[Result]) -> tuple[Cell, ...]:
    of = figures_of(found, case.errands)
    shares = (
        round(100 * of[key], 1) for key in ("within_0.3_m", "within_0.5_m", "within_0.8_m", "hit", "false_arrival")
    )
    ratio = of["way_over_shortest"]
    return (
        name,
        *shares,
        round(of["median_m"], 2),
        None if ratio is None else round(ratio, 2),
        round(of["seconds"], 1),
    )


def figures_of(found: Sequence[Result], errands: Sequence[Errand]) -> dict[str, Any]:
    """Shares over all drives; ways and seconds over those that came within half a metre."""
    end = np.array([one.distance_m for one in found])
    there = end < 0.5
    ratio = np.array([one.way_m / errand.shortest_m for one, errand in zip(found, errands, strict=True)])
    milliseconds = np.concatenate([one.milliseconds for one in found])
    states: dict[str, int] = {}
    for one in found:
        states[one.state] = states.get(one.state, 0) + 1
    return {
        "drives": len(found),
        **{f"within_{limit}_m": float((end < limit).mean()) for limit in (0.3, 0.5, 0.8, 1.0)},
        "hit": float(np.mean([one.hits > 0 for one in found])),
        "false_arrival": float(np.mean([one.state == "arrived" and one.distance_m > 0.8 for one in found])),
        "median_m": float(np.median(end)),
        "way_over_shortest": float(np.median(ratio[there])) if there.any() else None,
        "seconds": float(np.median([one.seconds for one in found])),
        "milliseconds": float(np.median(milliseconds)) if len(milliseconds) else None,
        "states": states,
        "ends_m": _rounded(end),
    }


def _rounded(values: FloatArray) -> list[float]:
    return [round(float(value), 3) for value in values]
