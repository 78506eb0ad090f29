"""What can go wrong on a robot's way: each scenario changes what was sensed, and nothing else."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from andante.data import Trajectory
from andante.evaluation.experiments.rides import Ride, around, composed
from andante.localization import Evidence

BLIND_S, CARRIED_S, DOCKED_S = 30.0, 10.0, 60.0
_SETTLED, _AFTER = 80, 150  # frames before something happens, and after it is over
_AWAY_M = 2.0
_SLIP, _SLIPPING = 0.3, (10, 40)  # how much too far or too short, for how many frames in a row
_DROPPED, _SHUFFLED, _REPEATED = 0.10, 0.05, 0.02
_JUMPS, _JUMP_M = 5, 5.0


@dataclass(frozen=True, eq=False)
class Lap:
    """One closed lap of an unseen session as a map sees it: clear, dazzled, and what a covered lens says.

    ``other`` is another unseen session, or the same where there is none.
    """

    clear: Ride
    dazzled: tuple[Evidence | None, ...]
    dark: Evidence
    other: Ride


@dataclass(frozen=True, eq=False)
class Staged:
    """A ride, and the frame ``since`` which a tracker could know again where it is."""

    ride: Ride
    since: int


Scenario = Callable[[np.random.Generator, Lap], Staged]


def unknown_start(rng: np.random.Generator, lap: Lap) -> Staged:
    """The robot is switched on anywhere."""
    return Staged(_anywhere(rng, lap.clear, _AFTER), 0)


def kidnapped(rng: np.random.Generator, lap: Lap) -> Staged:
    """It is carried to another place, maybe on another day, and its odometry goes on as if nothing had happened."""
    goal = lap.other if rng.random() < 0.5 else lap.clear
    return Staged(_carried(rng, lap.clear, goal), _SETTLED)


def carried_in_the_dark(rng: np.random.Generator, lap: Lap) -> Staged:
    """Its lens is covered for ten seconds, and in the middle of them it is carried away."""
    half = _frames(lap.clear, CARRIED_S / 2)
    ride = _carried(rng, lap.clear, lap.clear, _SETTLED + half)
    return _veiled(ride, CARRIED_S, [lap.dark] * len(ride))


def blind(rng: np.random.Generator, lap: Lap) -> Staged:
    """The lens is covered for 30 s while it drives on."""
    whole = _anywhere(rng, lap.clear, _SETTLED + _frames(lap.clear, BLIND_S) + _AFTER)
    return _veiled(whole, BLIND_S, [lap.dark] * len(whole))


def dazzled(rng: np.random.Generator, lap: Lap) -> Staged:
    """The camera is dazzled for 30 s: burnt-out pictures that still show something."""
    frames, start = _SETTLED + _frames(lap.clear, BLIND_S) + _AFTER, int(rng.integers(len(lap.clear)))
    whole = around(lap.clear, start, frames)
    return _veiled(whole, BLIND_S, around(replace(lap.clear, evidence=lap.dazzled), start, frames).evidence)


def wheel_slip(rng: np.random.Generator, lap: Lap) -> Staged:
    """Wheels slip or spin: for stretches of the way odometry tells up to 30 % too much or too little."""
    ride = _anywhere(rng, lap.clear, _SETTLED + 2 * _AFTER)
    factors, at = np.ones(len(ride)), _SETTLED
    while at < len(ride):
        length = int(rng.integers(*_SLIPPING))
        factors[at : at + length] = rng.uniform(1 - _SLIP, 1 + _SLIP)
        at += length
    steps = ride.steps() * np.stack([factors, factors, np.ones(len(ride))], axis=1)
    return Staged(ride.with_odometry(composed(steps)), _SETTLED)


def odometry_reset(rng: np.random.Generator, lap: Lap) -> Staged:
    """Odometry begins again from zero on the way."""
    ride = _anywhere(rng, lap.clear, _SETTLED + _AFTER)
    steps = ride.steps()
    return Staged(ride.with_odometry(composed(steps[:_SETTLED]) + composed(steps[_SETTLED:])), _SETTLED)


def odometry_jumps(rng: np.random.Generator, lap: Lap) -> Staged:
    """Odometry jumps by metres and turns, and stays there."""
    ride = _anywhere(rng, lap.clear, _SETTLED + 2 * _AFTER)
    steps = ride.steps()
    for at in rng.choice(np.arange(_SETTLED, len(ride)), _JUMPS, replace=False):
        steps[at] += np.append(rng.uniform(-_JUMP_M, _JUMP_M, 2), rng.uniform(-np.pi, np.pi))
    return Staged(ride.with_odometry(composed(steps)), _SETTLED)


def unreliable_frames(rng: np.random.Generator, lap: Lap) -> Staged:
    """10 % of the frames never come, 5 % come later than the one after them, 2 % come twice."""
    ride = _anywhere(rng, lap.clear, _SETTLED + 2 * _AFTER)
    order = np.flatnonzero(rng.random(len(ride)) >= _DROPPED).tolist()
    order = [at for frame in order for at in [frame] * (1 + int(rng.random() < _REPEATED))]
    for at in np.flatnonzero(rng.random(len(order) - 1) < _SHUFFLED).tolist():
        order[at], order[at + 1] = order[at + 1], order[at]
    return Staged(ride.taken(order), 0)


def docked(rng: np.random.Generator, lap: Lap) -> Staged:
    """It stands still for a minute, then drives on."""
    ride, standing = _anywhere(rng, lap.clear, _SETTLED + _AFTER), _frames(lap.clear, DOCKED_S)
    order = [*range(_SETTLED), *[_SETTLED] * standing, *range(_SETTLED, len(ride))]
    still, wait_s = ride.taken(order), _wait_s(ride)
    times = [info.timestamp_s + wait_s * min(max(at - _SETTLED, 0), standing) for at, info in enumerate(still.infos)]
    infos = tuple(
        replace(info, index=at, timestamp_s=time)
        for at, (info, time) in enumerate(zip(still.infos, times, strict=True))
    )
    return Staged(replace(still, infos=infos), 0)


SCENARIOS: dict[str, Scenario] = {
    "unknown start": unknown_start,
    "kidnapped": kidnapped,
    "carried in the dark": carried_in_the_dark,
    "blind for 30 s": blind,
    "dazzled for 30 s": dazzled,
    "wheel slip 30 %": wheel_slip,
    "odometry reset": odometry_reset,
    "odometry jumps": odometry_jumps,
    "frames dropped, late, twice": unreliable_frames,
    "docked for 60 s": docked,
}


def _anywhere(rng: np.random.Generator, ride: Ride, frames: int) -> Ride:
    return around(ride, int(rng.integers(len(ride))), frames)


def _carried(rng: np.random.Generator, ride: Ride, goal: Ride, after: int = _SETTLED) -> Ride:
    """Two parts of laps that are apart, with an odometry that knows nothing of the way between."""
    start = int(rng.integers(len(ride)))
    first = around(ride, start, after)
    left = Trajectory.of(first.infos[-1:], "reference").xy_m
    away = np.linalg.norm(Trajectory.of(goal.infos, "reference").xy_m - left, axis=1) > _AWAY_M
    then = around(goal, int(rng.choice(np.flatnonzero(away))) if away.any() else 0, _AFTER)
    steps = np.concatenate([first.steps(), np.zeros((1, 3)), then.steps()[1:]])
    later_s = first.infos[-1].timestamp_s + _wait_s(ride) - then.infos[0].timestamp_s
    moved = (replace(one, index=one.index + after, timestamp_s=one.timestamp_s + later_s) for one in then.infos)
    joined = Ride((*first.infos, *moved), first.evidence + then.evidence)
    return joined.with_odometry(composed(steps))


def _veiled(ride: Ride, seconds: float, instead: Sequence[Evidence | None]) -> Staged:
    """Other evidence (n of them) from when the tracker has settled, for some seconds."""
    end = min(_SETTLED + _frames(ride, seconds), len(ride))
    evidence = (*ride.evidence[:_SETTLED], *instead[_SETTLED:end], *ride.evidence[end:])
    return Staged(replace(ride, evidence=evidence), end)


def _frames(ride: Ride, seconds: float) -> int:
    return max(1, round(seconds / _wait_s(ride)))


def _wait_s(ride: Ride) -> float:
    """Seconds from frame to frame."""
    return float(np.median(np.diff([info.timestamp_s for info in ride.infos])))
