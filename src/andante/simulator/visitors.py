"""Puts cars, cows and people into a garden, clear of the robot's way and of each other."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from andante.data import FloatArray
from andante.errors import ConfigError
from andante.simulator.garden import Garden, Thing
from andante.simulator.movables import MOVABLES, MovableKind
from andante.simulator.obstacles import Footprint, Obstacles

_CLEAR_OF_WAY_M = 1.2
_CLEAR_OF_THINGS_M = 0.15
_BEYOND_FENCE_M = 4.0
_TRIES = 400


def placed_movables(garden: Garden, kinds: Sequence[MovableKind], seed: int, way_m: FloatArray) -> list[Thing]:
    """One thing for each of ``kinds``, at least 1.2 m from every point of ``way_m`` (k, 2), outside of all obstacles.

    Places and looks follow from ``seed``, every thing with a generator of its own. On the lawn where there is room,
    else beyond the fence. Raises ``ConfigError`` where there is no room at all.
    """
    things: list[Thing] = []
    taken = garden.obstacles
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
        mesh = MOVABLES[kind].build(rng).placed(footprint.x_m, footprint.y_m, footprint.heading_rad)
        things.append(Thing(kind, mesh, (footprint,)))
        taken = Obstacles(np.concatenate([taken.rows, Obstacles.of([footprint]).rows]))
    return things


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
