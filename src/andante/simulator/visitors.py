"""Puts cars, cows and people into a garden, clear of the robot's way and of each other."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated

import numpy as np
from pydantic import Field

from andante.data import FloatArray
from andante.errors import ConfigError
from andante.simulator.garden import Garden, Thing
from andante.simulator.movables import MOVABLES, MovableKind
from andante.simulator.obstacles import Footprint, Obstacles, joined
from andante.simulator.settings import Settings

_CLEAR_OF_WAY_M = 1.2
_CLEAR_OF_THINGS_M = 0.15
_BEYOND_FENCE_M = 4.0
_TRIES = 400


class Placed(Settings):
    """One thing that somebody put down on purpose, as an anchor beside a landmark; its heading is that of its x."""

    kind: MovableKind
    x_m: float
    y_m: float
    heading_rad: Annotated[float, Field(ge=-7, le=7)] = 0.0

    @property
    def footprint(self) -> Footprint:
        """The ground that it covers."""
        along, across = MOVABLES[self.kind].size_m
        return Footprint(self.x_m, self.y_m, self.heading_rad, along / 2.0, across / 2.0)


def put_down(placed: Sequence[Placed], seed: int) -> list[Thing]:
    """Things where they are told to be, whatever is there already; looks follow from ``seed`` and the order."""
    return [
        _thing(one.kind, one.footprint, np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(21, number))))
        for number, one in enumerate(placed)
    ]


def placed_movables(
    garden: Garden, kinds: Sequence[MovableKind], seed: int, way_m: FloatArray, placed: Sequence[Placed] = ()
) -> list[Thing]:
    """One thing for each of ``kinds``, at least 1.2 m from every point of ``way_m`` (k, 2), outside of all obstacles.

    Places and looks follow from ``seed``, every thing with a generator of its own. On the lawn where there is room,
    else beyond the fence, clear of what is ``placed``. Raises ``ConfigError`` where there is no room at all.
    """
    things: list[Thing] = []
    taken = joined([garden.obstacles, Obstacles.of(one.footprint for one in placed)])
    half = np.array([garden.spec.size_x_m, garden.spec.size_y_m]) / 2.0
    for number, kind in enumerate(kinds):
        rng = np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(20, number)))
        size = np.array(MOVABLES[kind].size_m) / 2.0
        for attempt in range(_TRIES):
            reach = half - 0.8 if attempt < _TRIES // 2 else half + _BEYOND_FENCE_M
            x, y = rng.uniform(-reach, reach)
            footprint = Footprint(float(x), float(y), float(rng.uniform(-np.pi, np.pi)), float(size[0]), float(size[1]))
            if _fits(footprint, taken, way_m):
                break
        else:
            raise ConfigError(f"there is no room for a {kind} in this garden; use fewer objects or a larger garden")
        things.append(_thing(kind, footprint, rng))
        taken = joined([taken, Obstacles.of([footprint])])
    return things


def _thing(kind: MovableKind, at: Footprint, rng: np.random.Generator) -> Thing:
    return Thing(kind, MOVABLES[kind].build(rng).placed(at.x_m, at.y_m, at.heading_rad), (at,))


def _fits(footprint: Footprint, taken: Obstacles, way_m: FloatArray) -> bool:
    if len(way_m) and Obstacles.of([footprint]).clearance_m(way_m).min() < _CLEAR_OF_WAY_M:
        return False
    return bool(taken.clearance_m(_outline(footprint)).min() > _CLEAR_OF_THINGS_M)


def _outline(footprint: Footprint) -> FloatArray:
    """Points (81, 2) all over a footprint, dense enough that no fence passes between them."""
    unit = np.linspace(-1.0, 1.0, 9)
    u, v = np.meshgrid(unit * footprint.half_x_m, unit * footprint.half_y_m)
    cos, sin = np.cos(footprint.heading_rad), np.sin(footprint.heading_rad)
    return np.stack([footprint.x_m + cos * u - sin * v, footprint.y_m + sin * u + cos * v], -1).reshape(-1, 2)
