"""From the words of a command line to a plan of the simulator."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import TYPE_CHECKING, get_args

import numpy as np

from andante.errors import InputError
from andante.simulator import (
    BorderRun,
    Conditions,
    GardenSpec,
    GridRun,
    InfieldRun,
    Plan,
    Session,
    SimulatedCamera,
    make_garden,
)
from andante.simulator.conditions import Season

if TYPE_CHECKING:
    from andante.simulator.trajectories import Drive

_GOLDEN = 0.618  # multiples of it are spread evenly, however many there are


def plan_of(garden: GardenSpec, seasons: Sequence[Season], trajectory: str, frames: int | None, image_px: int) -> Plan:
    """One session for each season, named after it; light, way and noise follow from the garden's seed.

    ``frames`` are spread over one lap (border), driven (infield), or about as many places (grid); ``None`` is a
    picture every 0.134 m, 500 pictures, or a place every 0.5 m. Raises ``ConfigError`` for values outside their range.
    """
    sessions = tuple(
        Session(
            name=season,
            seed=garden.seed + number,
            drive=_drive(garden, trajectory, frames, number),
            conditions=_conditions(season, garden.seed, number),
        )
        for number, season in enumerate(seasons)
    )
    return Plan(garden=garden, camera=SimulatedCamera(width_px=image_px, height_px=image_px), sessions=sessions)


def garden_of(size: str, seed: int) -> GardenSpec:
    """A garden from "15x15"; raises ``InputError`` for other words, ``ConfigError`` for a size outside its range."""
    numbers = re.fullmatch(r"(\d+(?:\.\d+)?)x(\d+(?:\.\d+)?)", size.strip().lower())
    if numbers is None:
        raise InputError(f"--size {size!r} is no size; give width and depth in metres, such as 15x15")
    return GardenSpec(seed=seed, size_x_m=float(numbers[1]), size_y_m=float(numbers[2]))


def seasons_of(text: str) -> list[Season]:
    """Seasons from "summer,winter"; raises ``InputError`` for others."""
    known: dict[str, Season] = {season: season for season in get_args(Season)}
    words = [word.strip() for word in text.split(",") if word.strip()] or [text]
    for word in words:
        if word not in known:
            raise InputError(f"--sessions has {word!r}; seasons are {', '.join(known)}, with commas between them")
    return [known[word] for word in words]


def _drive(garden: GardenSpec, trajectory: str, frames: int | None, number: int) -> Drive:
    if trajectory == "infield":
        return InfieldRun() if frames is None else InfieldRun(frames=frames)
    border = make_garden(garden).border
    if trajectory == "border":
        # Every session begins elsewhere, or all of them would take their pictures at the very same places.
        run = BorderRun(start=round(number * _GOLDEN % 1, 3))
        lap_m = border.inset(run.inset_m).length_m
        return run if frames is None else BorderRun(start=run.start, rate_hz=frames * run.speed_m_s / lap_m)
    if frames is None:
        return GridRun()
    low, high = border.points_m.min(axis=0), border.points_m.max(axis=0)
    return GridRun(spacing_m=float(np.sqrt(np.prod(high - low) / frames)))


def _conditions(season: Season, seed: int, number: int) -> Conditions:
    """A light of its own for every session, in the ranges of thesis 4.1."""
    rng = np.random.default_rng([seed, number])
    return Conditions(
        season=season,
        hour=round(rng.uniform(9.0, 15.0), 1),
        sun_energy=round(rng.uniform(3.0, 8.0), 2),
        sun_y_m=round(rng.uniform(-10.0, 10.0), 2),
        sun_red=round(rng.uniform(0.5, 1.0), 2),
        clouds=round(rng.uniform(0.2, 0.8), 2),
    )
