"""A garden from a seed: what stands where. Seasons, light and visitors come later and change nothing here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, SerializerFunctionWrapHandler, model_serializer

from andante.simulator.border import Border
from andante.simulator.mesh import Mesh
from andante.simulator.obstacles import Footprint, Obstacles
from andante.simulator.settings import Settings

NO_OBJECT = -1
"""The object id of the sky."""

_Side = Annotated[float, Field(ge=8.0, le=120.0)]


class Wall(Settings):
    """A wall of boards that stands free on the lawn, along a line of two points or more, in metres."""

    points_m: Annotated[tuple[tuple[float, float], ...], Field(min_length=2, max_length=100)]
    height_m: Annotated[float, Field(gt=0, le=5)] = 1.0
    thickness_m: Annotated[float, Field(gt=0, le=1)] = 0.08


class GardenSpec(Settings):
    """Which garden: another seed is another layout. The thesis has 15 x 15 m and about 57 x 44 m.

    ``walls`` are put up last, wherever they are told to stand: the rest of the garden is the same with and without.
    """

    seed: Annotated[int, Field(ge=0)] = 0
    size_x_m: _Side = 15.0
    size_y_m: _Side = 15.0
    v_obstacle: bool = False
    walls: tuple[Wall, ...] = ()

    @model_serializer(mode="wrap")
    def _without_no_walls(self, handler: SerializerFunctionWrapHandler) -> dict[str, Any]:
        """A garden without walls is told as ever, so that recordings of it keep their fingerprints."""
        values: dict[str, Any] = handler(self)
        if not self.walls:
            del values["walls"]
        return values


@dataclass(frozen=True, slots=True)
class Thing:
    """One object of a garden with its triangles, in place, and what it covers of the ground."""

    kind: str
    mesh: Mesh
    footprints: tuple[Footprint, ...] = ()


@dataclass(frozen=True, slots=True)
class Garden:
    """What a ``GardenSpec`` stands for; object ids are positions in ``things``, 0 is the ground."""

    spec: GardenSpec
    border: Border
    things: tuple[Thing, ...]

    @property
    def obstacles(self) -> Obstacles:
        """The footprints of everything that stands here."""
        return Obstacles.of(footprint for thing in self.things for footprint in thing.footprints)


@dataclass(frozen=True, slots=True)
class Scene:
    """Everything there is to see: n triangles, their object ids (n,) and a name for every id."""

    mesh: Mesh
    object_id: NDArray[np.int32]
    names: tuple[str, ...]
    obstacles: Obstacles

    @classmethod
    def of(cls, things: Sequence[Thing]) -> Scene:
        """Join things; the second oak is called ``oak2``."""
        counts: dict[str, int] = {}
        names = []
        for thing in things:
            counts[thing.kind] = counts.get(thing.kind, 0) + 1
            names.append(f"{thing.kind}{counts[thing.kind]}")
        sizes = [len(thing.mesh) for thing in things]
        return cls(
            Mesh.joined([thing.mesh for thing in things]),
            np.repeat(np.arange(len(things), dtype=np.int32), sizes),
            tuple(names),
            Obstacles.of(footprint for thing in things for footprint in thing.footprints),
        )
