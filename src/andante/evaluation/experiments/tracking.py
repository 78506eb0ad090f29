"""Single images against trackers on the sessions of the long-term experiment, with odometry that drifts."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from andante.data import Estimate
from andante.evaluation.experiments.cache import code_hash
from andante.evaluation.experiments.contenders import ANDANTE
from andante.evaluation.experiments.followers import FOLLOWERS
from andante.evaluation.experiments.long_term import permutations
from andante.evaluation.experiments.outcome import Cell, Outcome, Plot, Table
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.rides import Ride, sensed
from andante.evaluation.experiments.told import TOLD_COLUMNS, Told
from andante.evaluation.experiments.trials import Bench, Drive
from andante.evaluation.recovery import frames_to_settle
from andante.mapping import SlowMap, learn_map
from andante.simulator import Conditions

_FEW = 3
_NOTE = (
    "headings are medians and 95 % of absolute errors; in radius is the share of answers within the promised 90 % "
    "radius; errors are those of the best hypothesis of every frame, whatever its status; a tracker begins every "
    "session without knowing where it is, and its first frames count"
)


@dataclass(frozen=True, eq=False)
class Tracked:
    """What every follower told of one unseen session, with ``mapped`` sessions in the map."""

    mapped: int
    session: str
    conditions: Conditions
    told: Mapping[str, Told]


def run_tracking(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """Map the first 1, 3 and all but one sessions of every permutation, and follow the next one."""
    names = [session.name for session in bench.plan.sessions]
    orders = permutations(names, scale.permutations, seed)
    sizes = mapped_sizes(len(names))
    where = [(size, at) for size in sizes for at in range(len(orders))]
    found = []
    for done, (size, at) in enumerate(where):
        bench.progress("tracks", done, len(where))
        found.append(_tracked(bench, orders[at][:size], orders[at][size], at))
    bench.progress("tracks", len(where), len(where))
    return Outcome(_tables(found, sizes), _plots(found, sizes), _figures(found), (ANDANTE,), (_NOTE,))


def mapped_sizes(sessions: int) -> list[int]:
    """How many of so many sessions are mapped: one, a few, and all but one."""
    return sorted({1, min(_FEW, sessions - 1), sessions - 1})


def learned(bench: Bench, sessions: Sequence[str]) -> SlowMap:
    """The default map of some sessions of a plan."""
    config = ANDANTE.config
    drives = [bench.drive(Drive(name), config) for name in sessions]
    return learn_map([drive.session for drive in drives], bench.front_end(config), config)


def told_by(follow: Callable[[SlowMap, Ride, int], list[Estimate]], slowmap: SlowMap, ride: Ride, seed: int) -> Told:
    """What a follower tells of a ride."""
    return Told.of(follow(slowmap, ride, seed), ride.infos)


def _tracked(bench: Bench, train: Sequence[str], test: str, number: int) -> Tracked:
    key = {
        "tracks": [bench.plan.fingerprint(name) for name in train],
        "test": bench.plan.fingerprint(test),
        "contender": ANDANTE.key,
        "followers": list(FOLLOWERS),
        "seed": number,
        "code": code_hash(tracking=True),
    }
    stored = bench.store.load(key)
    if stored is None:
        slowmap = learned(bench, train)
        ride = sensed(slowmap, bench.recording(test), progress=bench.progress)
        stored = {name: told_by(follow, slowmap, ride, number).as_dict() for name, follow in FOLLOWERS.items()}
        bench.store.save(key, stored)
    told = {name: Told.from_dict(stored[name]) for name in FOLLOWERS}
    return Tracked(len(train), test, bench.plan.session(test).conditions, told)


def _joined(found: Sequence[Tracked], name: str) -> Told:
    return Told.joined([one.told[name] for one in found])


def _tables(found: Sequence[Tracked], sizes: Sequence[int]) -> tuple[Table, ...]:
    tables = []
    for size in sizes:
        here = [one for one in found if one.mapped == size]
        rows = tuple((name, *_joined(here, name).cells()) for name in FOLLOWERS)
        title = f"{size} mapped, {len(here)} tracks of {len({one.session for one in here})} unseen sessions"
        tables.append(Table(title, ("localizer", *TOLD_COLUMNS), rows))
    return (*tables, _settling(found, sizes), _coverage(found, sizes))


def _settling(found: Sequence[Tracked], sizes: Sequence[int]) -> Table:
    rows: list[tuple[Cell, ...]] = []
    for size in sizes:
        for name in FOLLOWERS:
            waits = [frames_to_settle(one.told[name].settled) for one in found if one.mapped == size]
            ended = [wait for wait in waits if wait is not None]
            median = float(np.median(ended)) if ended else None
            rows.append((f"{size} mapped, {name}", median, max(ended, default=None), len(waits) - len(ended)))
    columns = ("localizer", "median", "worst", "tracks that never settled")
    return Table("Frames from the start to the first ten that are ok and right", columns, tuple(rows))


def _coverage(found: Sequence[Tracked], sizes: Sequence[int]) -> Table:
    """The share within the 90 % radius, by what the unseen session was like."""
    rows: list[tuple[Cell, ...]] = []
    for size in sizes:
        here = [one for one in found if one.mapped == size]
        for label, chosen in _by_condition(here).items():
            joined = {name: _joined(chosen, name) for name in FOLLOWERS}
            shares = [_percent(one.figures()["coverage_90"]) for one in joined.values()]
            rows.append((f"{size} mapped, {label}", len(chosen), *shares))
    title = "Share of answers within the 90 % radius [%] by condition of the unseen session"
    return Table(title, ("condition", "tracks", *FOLLOWERS), tuple(rows))


def _by_condition(found: Sequence[Tracked]) -> dict[str, list[Tracked]]:
    groups: dict[str, list[Tracked]] = {"all": list(found)}
    for one in sorted(found, key=lambda one: one.conditions.season):
        groups.setdefault(one.conditions.season, []).append(one)
    for label, hidden in (("sun", False), ("overcast", True)):
        chosen = [one for one in found if one.conditions.overcast is hidden]
        if chosen:
            groups[label] = chosen
    return groups


def _percent(share: float | int | None) -> float | None:
    return None if share is None else 100 * share


def _figures(found: Sequence[Tracked]) -> dict[str, Any]:
    sizes = sorted({one.mapped for one in found})
    by_size = {
        str(size): {name: _joined([one for one in found if one.mapped == size], name).figures() for name in FOLLOWERS}
        for size in sizes
    }
    tracks = [
        {
            "mapped": one.mapped,
            "session": one.session,
            "localizers": {
                name: {**told.figures(), "frames_to_settle": frames_to_settle(told.settled)}
                for name, told in one.told.items()
            },
        }
        for one in found
    ]
    return {"by_sessions": by_size, "tracks": tracks}


def _plots(found: Sequence[Tracked], sizes: Sequence[int]) -> tuple[Plot, ...]:
    from andante.evaluation.experiments.track_plots import coverage_over_radius, error_distributions

    joined = {
        size: {name: _joined([one for one in found if one.mapped == size], name) for name in FOLLOWERS}
        for size in sizes
    }
    return (
        Plot("", "How often how wrong, by the number of mapped sessions.", error_distributions(joined)),
        Plot("radius", "Whether the promised 90 % radius holds, by its size.", coverage_over_radius(joined)),
    )
