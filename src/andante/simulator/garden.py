"""A garden from a seed: what stands where. Seasons, light and visitors come later and change nothing here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from andante.simulator.border import Border
from andante.simulator.mesh import Mesh
from andante.simulator.obstacles import Footprint, Obstacles
from andante.simulator.settings import Settings

NO_OBJECT = -1
"""The object id of the sky."""

_Side = Annotated[float, Field(ge=8.0, le=120.0)]


class GardenSpec(Settings):
    """Which garden: another seed is another layout. The thesis has 15 x 15 m and about 57 x 44 m."""

    seed: Annotated[int, Field(ge=0)] = 0
    size_x_m: _Side = 15.0
    size_y_m: _Side = 15.0
    v_obstacle: bool = False


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
