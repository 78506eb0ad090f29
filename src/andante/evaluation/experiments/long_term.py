"""Thesis 6.3.1, figures 6.10 and 6.11: more and more sessions mapped, the next one localized, 15 permutations."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from andante.evaluation.experiments.contenders import (
    ANDANTE,
    CONTENDERS,
    NEAREST_NOTE,
    NETWORK_NOTE,
    ODOMETRY,
    ODOMETRY_NOTE,
    PIXELS,
    THESIS,
    THESIS_PIXELS,
    Contender,
)
from andante.evaluation.experiments.outcome import ERROR_COLUMNS, Cell, Outcome, Plot, Table, error_cells
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.statistics import Summary, summary
from andante.evaluation.experiments.trials import Bench, Drive, Result, Trial
from andante.simulator import Plan

THESIS_AT_NINE = {"thesis: Fourier": 0.4, "thesis: raw images": 0.5}
"""Mean error in metres with nine sessions mapped (figure 6.10)."""
_CONTENDERS = (*CONTENDERS, PIXELS, THESIS_PIXELS, ODOMETRY)
_THESIS_SESSIONS = 9
_PERMUTATIONS = 610  # tells this use of the seed from others; the thesis' figure
_COLUMNS = ("sessions", *ERROR_COLUMNS, "variance of means [m²]", "learning [s]", "size [kB]")


@dataclass(frozen=True, eq=False)
class LongTerm:
    """All results: by localizer, number of mapped sessions and permutation of the sessions."""

    plan: Plan
    orders: tuple[tuple[str, ...], ...]
    results: Mapping[tuple[str, int, int], Result]
    contenders: tuple[Contender, ...]

    @property
    def sizes(self) -> range:
        """Numbers of mapped sessions."""
        return range(1, len(self.plan.sessions))

    @cached_property
    def summaries(self) -> dict[str, list[Summary]]:
        """By localizer, one for each number of mapped sessions."""
        return {one.name: [self._over_orders(one.name, size) for size in self.sizes] for one in self.contenders}

    def _over_orders(self, name: str, size: int) -> Summary:
        return summary([self.results[name, size, at] for at in range(len(self.orders))])

    def by_season(self) -> dict[str, dict[str, Summary]]:
        """By season of the localized session and localizer, with as many sessions mapped as possible."""
        seasons: dict[str, list[int]] = {}
        for at, order in enumerate(self.orders):
            seasons.setdefault(self.plan.session(order[-1]).conditions.season, []).append(at)
        last = self.sizes[-1]
        return {
            season: {one.name: summary([self.results[one.name, last, at] for at in numbers]) for one in self.contenders}
            for season, numbers in sorted(seasons.items())
        }


def run_long_term(bench: Bench, seed: int, scale: Scale, contenders: tuple[Contender, ...] = _CONTENDERS) -> Outcome:
    """Learn from the first k sessions of every permutation and localize session k + 1."""
    names = [session.name for session in bench.plan.sessions]
    orders = permutations(names, scale.permutations, seed)
    where = [(one, size, at) for at in range(len(orders)) for one in contenders for size in range(1, len(names))]
    trials = [Trial(one, tuple(map(Drive, orders[at][:size])), Drive(orders[at][size])) for one, size, at in where]
    done = zip(where, bench.run(trials), strict=True)
    found = LongTerm(bench.plan, orders, {(one.name, size, at): result for (one, size, at), result in done}, contenders)
    return Outcome(_tables(found), _plots(found), _figures(found), contenders, _notes(found))


def permutations(names: Sequence[str], count: int, seed: int) -> tuple[tuple[str, ...], ...]:
    """Random orders, each the same however many there are."""
    generators = (np.random.default_rng([seed, _PERMUTATIONS, number]) for number in range(count))
    return tuple(tuple(names[index] for index in rng.permutation(len(names))) for rng in generators)


def _tables(found: LongTerm) -> tuple[Table, ...]:
    names = tuple(one.name for one in found.contenders)
    means: list[tuple[Cell, ...]] = [
        (size, *(_mean_and_deviation(found.summaries[name][size - 1]) for name in names)) for size in found.sizes
    ]
    if found.sizes[-1] == _THESIS_SESSIONS:
        thesis = THESIS_AT_NINE["thesis: Fourier"]
        means.append(("thesis, 9", *(f"{thesis:.3f}" if name == THESIS.name else None for name in names)))
    overview = Table("Mean error and its standard deviation [m]", ("sessions", *names), tuple(means))
    each = (
        Table(name, _COLUMNS, tuple(_row(size, found.summaries[name][size - 1]) for size in found.sizes))
        for name in names
    )
    by_season: list[tuple[Cell, ...]] = [
        (season, of[names[0]].trials, *(of[name].mean_m for name in names)) for season, of in found.by_season().items()
    ]
    title = f"Mean error [m] by season of the localized session, {found.sizes[-1]} mapped"
    return (overview, *each, Table(title, ("season", "trials", *names), tuple(by_season)))


def _mean_and_deviation(of: Summary) -> str:
    shown = [
        f"{value:.3f}" if value < 1000 else f"{value:.0f}" for value in (of.mean_m, of.deviation_m) if value is not None
    ]
    return " ± ".join(shown)


def _row(size: int, of: Summary) -> tuple[Cell, ...]:
    variance = None if of.variance_m2 is None else f"{of.variance_m2:.2g}"
    return (size, *error_cells(of), variance, of.seconds, round(of.bytes / 1000))


def _figures(found: LongTerm) -> dict[str, Any]:
    by_size = {
        name: [{"sessions": size, **of.as_dict()} for size, of in zip(found.sizes, all_sizes, strict=True)]
        for name, all_sizes in found.summaries.items()
    }
    by_season = {season: {name: of.as_dict() for name, of in row.items()} for season, row in found.by_season().items()}
    trials = [
        {
            "localizer": name,
            "mapped": list(found.orders[at][:size]),
            "localized": found.orders[at][size],
            **summary([result]).as_dict(),
        }
        for (name, size, at), result in found.results.items()
    ]
    return {"by_sessions": by_size, "by_season": by_season, "thesis_mean_m_at_9": THESIS_AT_NINE, "trials": trials}


def _plots(found: LongTerm) -> tuple[Plot, ...]:
    from andante.evaluation.experiments.plots import Panel, error_over_sessions, estimated_ways

    marks = {name: (_THESIS_SESSIONS, mean) for name, mean in THESIS_AT_NINE.items()}
    over = error_over_sessions(found.summaries, marks)
    last, unseen = found.sizes[-1], found.orders[0][-1]
    own = [name for name in (ANDANTE.name, THESIS.name) if name in found.summaries]
    panels = [Panel(name, found.results[name, last, 0]) for name in own]
    title = f"{unseen}, {last} other sessions mapped"
    return (
        Plot("", "Mean error over permutations, and one standard deviation on both sides (thesis figure 6.10).", over),
        Plot("way", "An unseen session: driven (grey) and estimated (blue), first permutation (thesis figure 6.11).",
             estimated_ways([title], [panels])),
    )  # fmt: skip


def _notes(found: LongTerm) -> tuple[str, ...]:
    tested = {order[-1] for order in found.orders}
    return (
        f"{len(found.orders)} permutations of {len(found.plan.sessions)} sessions; with {found.sizes[-1]} mapped, "
        f"{len(tested)} different sessions are localized",
        "the means and variances are over permutations, 95 %, max and the share over 1 m over all their frames",
        NEAREST_NOTE,
        NETWORK_NOTE,
        ODOMETRY_NOTE,
    )
