"""What the experiments of thesis chapter 6 record: drives through one simulated garden."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Literal, get_args

import numpy as np
from pydantic import Field

from andante.simulator import BorderRun, Conditions, GardenSpec, Plan, Session, SimulatedCamera, make_garden
from andante.simulator.conditions import Season
from andante.simulator.movables import MOVABLE_KINDS, MovableKind
from andante.simulator.settings import Settings

SEASONS: tuple[Season, ...] = ("summer", "autumn", "winter", "spring")
STATIC, UNSEEN, GROWING, COW = "static", "static-again", "growing-light", "cow"

_SPEED_M_S = 0.67
_GOLDEN = 0.618  # multiples of it are spread evenly, however many there are
_MAX_OBJECTS = 3


class Scale(Settings):
    """How large an experiment is.

    ``frames`` of a session, ``image_px`` is the side of its square fisheye images; ``sessions`` and
    ``permutations`` of them are for the experiments with many sessions, ``runs`` of every scenario for stress. With
    fewer frames the thesis' regression, of 45 terms, could not be learnt from 70 % of them. ``errands`` (random pairs
    of places) and ``repeats`` (of four fixed pairs) are for navigation, whose images are panoramas ``image_px`` wide.
    ``detector`` is for landmarks: boxes of the simulator, or of a detector that learns from them on the mapped drive.
    """

    frames: Annotated[int, Field(ge=70, le=20_000)]
    image_px: Annotated[int, Field(ge=48, le=2048)]
    sessions: Annotated[int, Field(ge=2, le=100)] = 2
    permutations: Annotated[int, Field(ge=1, le=1000)] = 1
    runs: Annotated[int, Field(ge=1, le=10_000)] = 1
    errands: Annotated[int, Field(ge=1, le=10_000)] = 1
    repeats: Annotated[int, Field(ge=1, le=100)] = 1
    detector: Literal["simulator", "learnt"] = "simulator"


def long_term_plan(seed: int, scale: Scale) -> Plan:
    """Sessions of one garden, all seasons in turn, under random light and weather, with up to three movable objects.

    The ranges of the light are those of thesis 4.1. Every session begins elsewhere on its lap of the border.
    """
    lap = _Lap.of(seed, scale)
    sessions = []
    for number in range(scale.sessions):
        rng = np.random.default_rng([seed, number])
        conditions = Conditions(
            season=SEASONS[number % len(SEASONS)],
            hour=round(rng.uniform(8, 16), 1),
            sun_energy=round(rng.uniform(3, 8), 2),
            sun_y_m=round(rng.uniform(-10, 10), 2),
            sun_red=round(rng.uniform(0.5, 1), 2),
            clouds=round(rng.uniform(0.1, 0.9), 2),
            overcast=bool(rng.random() < 0.25),
        )
        objects = _objects(rng)
        name = f"{number:02d}-{conditions.season}"
        sessions.append(lap.session(name, number, conditions, objects))
    return lap.plan(sessions)


def single_plan(seed: int, scale: Scale, names: Sequence[str]) -> Plan:
    """Some of the four drives of the experiments with few recordings, in one garden in summer.

    ``static`` is mapped; in ``growing-light`` the sun grows to two and a half times its strength while the robot
    drives; ``static-again`` is as ``static``, begins elsewhere and has its own noise; ``cow`` is ``static-again``
    picture by picture, but for the cow.
    """
    lap = _Lap.of(seed, scale)
    # No clouds: every drive would have others, and nothing but the light and the cow may change.
    static, growing = Conditions(clouds=0.0), Conditions(clouds=0.0, sun_energy=3.0, drift_energy=1.5)
    sessions = (
        lap.session(STATIC, 0, static),
        lap.session(GROWING, 1, growing),
        lap.session(UNSEEN, 2, static),
        lap.session(COW, 2, static, ("cow",)),
    )
    return lap.plan([session for session in sessions if session.name in names])


@dataclass(frozen=True)
class _Lap:
    """One lap of a garden's border in as many frames as the scale says."""

    garden: GardenSpec
    scale: Scale
    seed: int
    length_m: float

    @classmethod
    def of(cls, seed: int, scale: Scale) -> _Lap:
        garden = GardenSpec(seed=seed)
        length_m = make_garden(garden).border.inset(BorderRun().inset_m).length_m
        return cls(garden, scale, seed, length_m)

    def session(self, name: str, number: int, conditions: Conditions, objects: tuple[MovableKind, ...] = ()) -> Session:
        """Sessions of one number take the same way, with the same noise."""
        # Elsewhere each time, or all of them would take their pictures at the very same places.
        start, rate_hz = round(number * _GOLDEN % 1, 3), self.scale.frames * _SPEED_M_S / self.length_m
        return Session(
            name=name,
            seed=self.seed * 100 + number,
            drive=BorderRun(start=start, rate_hz=rate_hz),
            conditions=conditions,
            objects=objects,
        )

    def plan(self, sessions: list[Session]) -> Plan:
        side = self.scale.image_px
        camera = SimulatedCamera(width_px=side, height_px=side)
        return Plan(garden=self.garden, camera=camera, sessions=tuple(sessions))


def _objects(rng: np.random.Generator) -> tuple[MovableKind, ...]:
    chosen = rng.choice(sorted(MOVABLE_KINDS), size=int(rng.integers(0, _MAX_OBJECTS + 1)))
    kinds = {str(kind): kind for kind in get_args(MovableKind)}
    return tuple(kinds[str(name)] for name in chosen)
