"""Trackers under everything that goes wrong: how soon they know where they are, how often they are surely wrong."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from andante.errors import ConfigError
from andante.evaluation.experiments.cache import code_hash
from andante.evaluation.experiments.contenders import ANDANTE
from andante.evaluation.experiments.followers import TRACKERS, Follow
from andante.evaluation.experiments.long_term import permutations
from andante.evaluation.experiments.outcome import Cell, Outcome, Table
from andante.evaluation.experiments.plans import Scale
from andante.evaluation.experiments.rides import Ride, covered, overexposed, sensed
from andante.evaluation.experiments.scenarios import SCENARIOS, Lap, Scenario, Staged, unknown_start
from andante.evaluation.experiments.told import Told
from andante.evaluation.experiments.tracking import learned, mapped_sizes
from andante.evaluation.experiments.trials import Bench
from andante.evaluation.recovery import frames_to_settle
from andante.localization import evidence_of
from andante.mapping import SlowMap
from andante.mapping.readout import LocalReadout
from andante.protocols import Recording
from andante.simulator import Plan, Session
from andante.simulator.movables import MOVABLE_KINDS

MOVED_OBJECTS, WRONG_REFERENCES = "moved objects", "wrong references"
_SPOILED_SHARE = 0.03
_MAPS = 5
_STRESS = 666  # tells this use of the seed from others
_COLUMNS = (
    "scenario",
    *("to recover: median [frames]", "95 %", "worst", "never [runs]"),
    *("ok and > 1 m [%]", "ok [%]", "raised [runs]"),
)
_NOTES = (
    "a tracker has recovered with the first of ten frames in a row that are ok and at most 1 m off, counted from the "
    "first frame at which it could know where it is; a run in which it never does counts with all frames it had left",
    "ok and > 1 m is the share of all frames of all runs, those without any picture included",
)


_Split = tuple[tuple[str, ...], str, str]
"""The sessions that are mapped, one that is not, and another one, or the same where all others are mapped."""


@dataclass(frozen=True, eq=False)
class Ground:
    """A map with the laps that it has not seen: as they are, with other objects, and with a map that was spoiled."""

    slowmap: SlowMap
    lap: Lap
    moved: Lap
    spoiled: SlowMap
    lap_on_spoiled: Lap


@dataclass(frozen=True, slots=True)
class Ran:
    """One run: ``frames`` in all, those ``ok``, those ok and more than 1 m ``wrong``, what was ``raised``, if anything.

    ``waited`` are the frames until it had recovered, ``None`` where it never did, ``left`` those it had for it.
    """

    frames: int
    ok: int
    wrong: int
    waited: int | None
    left: int
    raised: str | None = None


def run_stress(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """Every scenario and filter, many times, with few and with all but one sessions mapped."""
    names = [session.name for session in bench.plan.sessions]
    orders = permutations(names, min(_MAPS, scale.permutations), seed)
    sizes = mapped_sizes(len(names))[1:]
    found = {size: _at_size(bench, [_split(order, size) for order in orders], seed, scale) for size in sizes}
    tables = tuple(
        Table(f"{size} mapped, {name}, {scale.runs} runs each", _COLUMNS, _rows(by_filter[name]))
        for size, by_filter in found.items()
        for name in TRACKERS
    )
    figures = {
        str(size): {name: {one: summary(runs) for one, runs in ran.items()} for name, ran in by_filter.items()}
        for size, by_filter in found.items()
    }
    return Outcome(tables, (), {"by_sessions": figures}, (ANDANTE,), _NOTES)


def summary(runs: Sequence[Ran]) -> dict[str, Any]:
    """What the table says of some runs, shares from 0 to 1."""
    waits = [run.left if run.waited is None else run.waited for run in runs]
    frames = sum(run.frames for run in runs)
    return {
        "runs": len(runs),
        "recovery_median_frames": float(np.median(waits)),
        "recovery_p95_frames": float(np.quantile(waits, 0.95)),
        "recovery_worst_frames": max(waits),
        "never_recovered": sum(run.waited is None for run in runs),
        "confident_wrong_share": sum(run.wrong for run in runs) / max(1, frames),
        "ok_share": sum(run.ok for run in runs) / max(1, frames),
        "raised": sum(run.raised is not None for run in runs),
        "errors": sorted({run.raised for run in runs if run.raised is not None}),
    }


def spoiled(slowmap: SlowMap, rng: np.random.Generator, share: float = _SPOILED_SHARE) -> SlowMap:
    """The same map with some of its references at places of others; raises ``ConfigError`` for one without any."""
    readout = slowmap.readout
    if not isinstance(readout, LocalReadout):
        raise ConfigError("only a map with a local readout has references to spoil; use the default readout")
    chosen = rng.permutation(len(readout.xy))[: round(share * len(readout.xy))]
    xy = readout.xy.copy()
    xy[chosen] = readout.xy[rng.permutation(len(xy))[: len(chosen)]]
    return replace(slowmap, readout=replace(readout, xy=xy))


def with_moved_objects(plan: Plan, name: str) -> Plan:
    """One session of a plan once more, with one object of every kind that no other session has there."""
    session = plan.session(name)
    values = session.model_dump() | {
        "name": f"{name}-moved",
        "objects": MOVABLE_KINDS,
        "objects_seed": session.seed + 50,
    }
    return plan.model_copy(update={"sessions": (Session.model_validate(values),)})


def staged(scenario: str, ground: Ground, rng: np.random.Generator) -> tuple[SlowMap, Staged]:
    """A scenario by name, and the map to be used in it."""
    if scenario == WRONG_REFERENCES:
        return ground.spoiled, unknown_start(rng, ground.lap_on_spoiled)
    if scenario == MOVED_OBJECTS:
        return ground.slowmap, unknown_start(rng, ground.moved)
    change: Scenario = SCENARIOS[scenario]
    return ground.slowmap, change(rng, ground.lap)


def ran(follow: Follow, slowmap: SlowMap, what: Staged, seed: int) -> Ran:
    """One run; an exception, which must never happen, is written down and ends it."""
    frames, left = len(what.ride), len(what.ride) - what.since
    try:
        told = Told.of(follow(slowmap, what.ride, seed), what.ride.infos)
    except Exception as error:  # the finding is which, and how often
        return Ran(frames, 0, 0, None, left, f"{type(error).__name__}: {error}")
    ok = int((told.status == "ok").sum())
    return Ran(frames, ok, int(told.confident_and_wrong.sum()), frames_to_settle(told.settled, what.since), left)


def _split(order: tuple[str, ...], size: int) -> _Split:
    return order[:size], order[size], order[min(size + 1, len(order) - 1)]


def _at_size(bench: Bench, splits: Sequence[_Split], seed: int, scale: Scale) -> dict[str, dict[str, list[Ran]]]:
    """By filter and scenario, one for each run; runs take the splits in turn."""
    grounds: dict[int, Ground] = {}

    def ground(number: int) -> Ground:
        if number not in grounds:
            grounds[number] = _ground(bench, splits[number], seed)
        return grounds[number]

    found: dict[str, dict[str, list[Ran]]] = {name: {} for name in TRACKERS}
    scenarios = (*SCENARIOS, MOVED_OBJECTS, WRONG_REFERENCES)
    parts = [(scenario, name) for scenario in scenarios for name in TRACKERS]
    for done, (scenario, name) in enumerate(parts):
        bench.progress(f"stress, {len(splits[0][0])} mapped", done, len(parts))
        key = _key(bench, splits, seed, scale, scenario=scenario, name=name)
        stored = bench.store.load(key)
        if stored is None:
            runs = []
            for run in range(scale.runs):
                rng = np.random.default_rng([seed, _STRESS, scenarios.index(scenario), run])
                slowmap, what = staged(scenario, ground(run % len(splits)), rng)
                runs.append(ran(TRACKERS[name], slowmap, what, run))
            stored = {"runs": [[one.frames, one.ok, one.wrong, one.waited, one.left, one.raised] for one in runs]}
            bench.store.save(key, stored)
        found[name][scenario] = [Ran(*values) for values in stored["runs"]]
    bench.progress(f"stress, {len(splits[0][0])} mapped", len(parts), len(parts))
    return found


def _ground(bench: Bench, split: _Split, seed: int) -> Ground:
    train, test, other = split
    slowmap, recording = learned(bench, train), bench.recording(test)
    worse = spoiled(slowmap, np.random.default_rng([seed, _STRESS]))
    changed = bench.beside(with_moved_objects(bench.plan, test))
    moved = changed.recording(changed.plan.sessions[0].name)
    elsewhere = sensed(slowmap, bench.recording(other))
    return Ground(
        slowmap,
        lap=_lap(slowmap, recording, elsewhere),
        moved=_lap(slowmap, moved, elsewhere),
        spoiled=worse,
        lap_on_spoiled=_lap(worse, recording, elsewhere),
    )


def _lap(slowmap: SlowMap, recording: Recording, other: Ride) -> Lap:
    dark = evidence_of(slowmap.for_recording(recording), covered(recording.load(recording.infos[0])))
    burnt = sensed(slowmap, recording, through=overexposed)
    return Lap(sensed(slowmap, recording), burnt.evidence, dark, other)


def _key(
    bench: Bench, splits: Sequence[_Split], seed: int, scale: Scale, *, scenario: str, name: str
) -> Mapping[str, Any]:
    return {
        "stress": scenario,
        "filter": name,
        "runs": scale.runs,
        "seed": seed,
        "splits": [list(map(bench.plan.fingerprint, (*train, test, other))) for train, test, other in splits],
        "contender": ANDANTE.key,
        "code": code_hash(tracking=True),
    }


def _rows(by_scenario: Mapping[str, Sequence[Ran]]) -> tuple[tuple[Cell, ...], ...]:
    every = [run for runs in by_scenario.values() for run in runs]
    return tuple(_row(name, summary(runs)) for name, runs in {**by_scenario, "all": every}.items())


def _row(name: str, of: Mapping[str, Any]) -> tuple[Cell, ...]:
    waits = (of[f"recovery_{which}_frames"] for which in ("median", "p95", "worst"))
    shares = (100 * of["confident_wrong_share"], 100 * of["ok_share"])
    return (name, *waits, of["never_recovered"], *shares, of["raised"])
