"""Lays out a garden: hedges and fences around a lawn, houses and trees beyond, things along the border.

Every object draws from a random generator of its own (a spawn key of the garden's seed), so that no object's
shape depends on another, on the season or on visitors.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise

import numpy as np

from andante.data import FloatArray
from andante.simulator import buildings, plants
from andante.simulator.border import Border
from andante.simulator.garden import Garden, GardenSpec, Thing
from andante.simulator.mesh import Layer, Matter, Mesh, Paint
from andante.simulator.obstacles import Footprint
from andante.simulator.shapes import quads

_WIRE_INSET_M = 1.35
_HORIZON_M = 140.0

Build = Callable[[np.random.Generator], Mesh]
_Place = tuple[float, float, float]  # x, y in metres, heading in radians


@lru_cache(maxsize=4)
def make_garden(spec: GardenSpec) -> Garden:
    """The garden that ``spec`` stands for: the same for the same spec, in any process. Treat it as read-only."""
    planner = _Planner(spec)
    planner.add_ground()
    planner.add_boundary()
    if spec.v_obstacle:
        planner.add_v_obstacle()
    planner.add_houses()
    planner.add_corners()
    planner.add_inner_landmarks()
    planner.add_trees()
    planner.add_small_things()
    planner.add_walls()
    return Garden(spec, planner.border, tuple(planner.things))


class _Planner:
    """Holds what is placed already; ``_rng`` decides about places only, never about shapes."""

    def __init__(self, spec: GardenSpec) -> None:
        self.spec = spec
        self.half = np.array([spec.size_x_m, spec.size_y_m]) / 2.0
        self.things: list[Thing] = []
        self._rng = np.random.default_rng(np.random.SeedSequence(spec.seed, spawn_key=(0,)))
        self._taken: list[tuple[float, float, float]] = []
        self._corner_inset = self._rng.uniform(0.0, 0.6, (4, 2)) + np.where(self._rng.random((4, 1)) < 0.4, 1.6, 0.0)
        corners = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (self.half - _WIRE_INSET_M - self._corner_inset)
        self.border = Border.rounded(corners, min(self.half) * self._rng.uniform(0.12, 0.2))

    def _generator(self) -> np.random.Generator:
        """The generator of the next object."""
        return np.random.default_rng(np.random.SeedSequence(self.spec.seed, spawn_key=(1, len(self.things))))

    def _put(self, kind: str, mesh: Mesh, at: _Place, half_m: tuple[float, float] | None = None) -> None:
        """Place a mesh that was built at the origin; ``half_m`` are the half sides of its footprint."""
        x, y, heading = at
        footprints = (Footprint(x, y, heading, *half_m),) if half_m else ()
        self.things.append(Thing(kind, mesh.placed(x, y, heading), footprints))
        self._taken.append((x, y, max(float(np.hypot(*(half_m or (0.0, 0.0)))), 0.3)))

    def _free(self, x: float, y: float, radius: float) -> bool:
        return all(np.hypot(x - a, y - b) > radius + r for a, b, r in self._taken)

    def add_ground(self) -> None:
        """Lawn in cells that are fine near the garden, and wooded hills all around."""
        near = [np.arange(-h - 6.0, h + 6.5, 1.0) for h in self.half]
        x, y = (
            np.concatenate([[-_HORIZON_M, -h - 30.0], axis, [h + 30.0, _HORIZON_M]])
            for axis, h in zip(near, self.half, strict=True)
        )
        grid = np.stack(np.broadcast_arrays(x[:, None], y[None, :], 0.0), -1)
        patches = np.stack([grid[:-1, :-1], grid[1:, :-1], grid[1:, 1:], grid[:-1, 1:]], 2).reshape(-1, 4, 3)
        lawn = quads(patches, Paint(0.13, 0.21, 0.05, Layer.GRASS, Matter.GROUND))
        lawn.uv[...] = lawn.corners[..., :2]
        self.things.append(Thing("ground", lawn))
        rng = self._generator()
        turn = np.linspace(0.0, 2.0 * np.pi, 181)
        waves = [
            rng.uniform(0.4, 1.0) / k**0.6 * np.sin(k * turn + rng.uniform(0, 2 * np.pi))
            for k in (1, 2, 3, 5, 9, 17, 40)
        ]
        height = 4.5 + 1.7 * np.sum(waves, axis=0)
        height[-1] = height[0]
        radius = _HORIZON_M * 0.93
        foot = np.stack([radius * np.cos(turn), radius * np.sin(turn), 0.0 * turn], 1)
        crest = foot * (1.04, 1.04, 1.0) + np.stack([0 * turn, 0 * turn, np.maximum(height, 1.5)], 1)
        wood = Paint(0.06, 0.12, 0.05, Layer.LEAF, Matter.NEEDLE)
        hills = quads(np.stack([foot[:-1], foot[1:], crest[1:], crest[:-1]], 1), wood, rng.random(180))
        self.things.append(Thing("hills", hills))

    def add_boundary(self) -> None:
        """Hedges and fences along the four sides, each side in one to three pieces."""
        density = 64.0 if self.half.max() < 12.0 else 14.0
        for side in range(4):
            along, across = (self.half[0], self.half[1]) if side % 2 == 0 else (self.half[1], self.half[0])
            pieces = int(self._rng.integers(1, 4))
            cuts = np.sort(np.concatenate([[-1.0, 1.0], self._rng.uniform(-0.6, 0.6, pieces - 1)])) * along
            for low, high in pairwise(cuts):
                hedge = self._rng.random() < 0.55
                height = self._rng.uniform(1.0, 1.7) if hedge else self._rng.uniform(0.8, 1.4)
                rng, length, depth = self._generator(), high - low, 0.6 if hedge else 0.1
                mesh = (
                    plants.hedge(rng, length, height, depth, density) if hedge else buildings.fence(rng, length, height)
                )
                turn = side * np.pi / 2.0
                middle = np.array([(low + high) / 2.0, -across])
                x, y = middle @ [[np.cos(turn), np.sin(turn)], [-np.sin(turn), np.cos(turn)]]
                footprint = Footprint(float(x), float(y), turn, length / 2.0, depth / 2.0)
                kind = "hedge" if hedge else "fence"
                self.things.append(Thing(kind, mesh.placed(float(x), float(y), turn), (footprint,)))

    def add_v_obstacle(self) -> None:
        """The obstacle of thesis chapter 9 in the middle of the lawn."""
        arm = float(min(self.half)) * 0.32
        turn = self._rng.uniform(-np.pi, np.pi)
        mesh = buildings.v_obstacle(arm, 1.0).placed(0.0, 0.0, turn)
        arms = [turn + np.pi / 4.0, turn - np.pi / 4.0]
        footprints = tuple(Footprint(np.cos(a) * arm / 2, np.sin(a) * arm / 2, a, arm / 2, 0.04) for a in arms)
        self.things.append(Thing("obstacle", mesh, footprints))
        self._taken.append((0.0, 0.0, arm))

    def add_houses(self) -> None:
        """One large house close by, others further off, each on its own side."""
        sides = self._rng.permutation(4)[: int(self._rng.integers(2, 5))]
        for rank, side in enumerate(sides):
            length, depth = self._rng.uniform(7.0, 13.0), self._rng.uniform(5.0, 8.0)
            storeys = 2.5 * self._rng.integers(1, 3) + self._rng.uniform(0.2, 0.6)
            away = self._rng.uniform(0.7, 2.0) if rank == 0 else self._rng.uniform(3.0, 11.0)
            along, across = (self.half[0], self.half[1]) if side % 2 == 0 else (self.half[1], self.half[0])
            shift = self._rng.uniform(-0.7, 0.7) * along
            out = across + away + depth / 2.0
            outward = (side - 1) * np.pi / 2.0
            x, y = np.array([out, shift]) @ [[np.cos(outward), np.sin(outward)], [-np.sin(outward), np.cos(outward)]]
            mesh = buildings.house(self._generator(), length, depth, storeys)
            # The wall with the door looks at the garden: -y of the house towards the middle.
            self._put("house", mesh, (float(x), float(y), outward - np.pi / 2.0), (length / 2.0, depth / 2.0))

    def add_corners(self) -> None:
        """A shed, a table or a bush where the wire leaves a corner free."""
        for corner, (sx, sy) in enumerate(((-1, -1), (1, -1), (1, 1), (-1, 1))):
            if self._corner_inset[corner].min() < 1.5:
                continue
            x, y = (sx, sy) * (self.half - 1.55)
            facing = float(np.arctan2(-y, -x)) + np.pi / 2.0
            choice = self._rng.choice(["shed", "shed", "table", "bush"])
            rng = self._generator()
            if choice == "shed":
                length, depth = self._rng.uniform(1.6, 2.2), self._rng.uniform(1.3, 1.8)
                self._put("shed", buildings.shed(rng, length, depth), (x, y, facing), (length / 2, depth / 2))
            elif choice == "table":
                self._put("table", buildings.table(rng), (x, y, facing), (0.9, 0.9))
            else:
                self._put("bush", plants.bush(rng, 1.5, flowering=True), (x, y, facing), (0.6, 0.6))

    def add_inner_landmarks(self) -> None:
        """In a large garden things stand on the lawn too, so that each landmark is seen from a part of it only."""
        wanted = int(max(0.0, self.half[0] * self.half[1] * 4.0 - 260.0) / 110.0)
        for _ in range(wanted):
            spot = self._spot_inside(2.6, 1.6)
            if spot is None:
                continue
            choice = self._rng.choice(["tree", "tree", "conifer", "hedge", "bush", "rocks", "shed"])
            self._put_landmark(str(choice), *spot, self._rng.uniform(-np.pi, np.pi))

    def _put_landmark(self, kind: str, x: float, y: float, heading: float) -> None:
        rng = self._generator()
        size = self._rng.uniform(0.0, 1.0)
        if kind == "tree":
            self._put(kind, plants.broadleaf(rng, 3.5 + 3.0 * size), (x, y, heading), (0.15, 0.15))
        elif kind == "conifer":
            self._put(kind, plants.conifer(rng, 3.0 + 3.0 * size), (x, y, heading), (0.6, 0.6))
        elif kind == "hedge":
            self._put(kind, plants.hedge(rng, 2.5 + 2.0 * size, 1.6, 0.7, 20.0), (x, y, heading), (1.25 + size, 0.35))
        elif kind == "bush":
            self._put(kind, plants.bush(rng, 1.2 + size, flowering=size < 0.5), (x, y, heading), (0.5, 0.5))
        elif kind == "rocks":
            self._put(kind, buildings.rocks(rng), (x, y, heading), (1.2, 0.8))
        else:
            self._put(kind, buildings.shed(rng, 2.0 + size, 1.8), (x, y, heading), (1.0 + size / 2.0, 0.9))

    def _spot_inside(self, from_wire_m: float, radius: float) -> tuple[float, float] | None:
        for _ in range(40):
            x, y = self._rng.uniform(-self.half, self.half)
            if self.border.inside_m([(x, y)])[0] > from_wire_m and self._free(x, y, radius):
                return float(x), float(y)
        return None

    def add_trees(self) -> None:
        """Trees beyond the fence, near and far, and a few on the strip inside."""
        perimeter = 4.0 * float(self.half.sum())
        for number in range(int(perimeter / 2.0)):
            strip = number % 6 == 5
            away = -0.8 if strip else self._rng.uniform(1.2, 4.0 + 9.0 * self._rng.random())
            x, y = self._along_fence(away)
            conifer = self._rng.random() < 0.3
            height = self._rng.uniform(2.8, 5.0) if strip else self._rng.uniform(3.2, 7.5)
            if not self._free(x, y, 1.1 + 0.12 * height):
                continue
            rng, turn = self._generator(), self._rng.uniform(-np.pi, np.pi)
            mesh = plants.conifer(rng, height) if conifer and not strip else plants.broadleaf(rng, height)
            self._put("conifer" if conifer and not strip else "tree", mesh, (x, y, turn), (0.12, 0.12))

    def add_small_things(self) -> None:
        """Pots, bushes, rocks, barrels and lamps on the strip between wire and fence."""
        builders: dict[str, tuple[Build, float, float]] = {
            "pot": (plants.pot, 0.3, 0.3),
            "bush": (lambda rng: plants.bush(rng, rng.uniform(0.7, 1.2), flowering=rng.random() < 0.6), 0.3, 0.3),
            "rocks": (buildings.rocks, 1.0, 0.4),
            "barrel": (buildings.barrel, 0.3, 0.3),
            "lamp": (buildings.lamp, 0.06, 0.06),
        }
        for _ in range(int(self.half.sum() * 1.1)):
            kind = str(self._rng.choice([*builders, "pot", "bush"]))
            build, half_x, half_y = builders[kind]
            x, y = self._along_fence(-0.75)
            turn = (0.0 if abs(abs(y) - self.half[1]) < 1.0 else np.pi / 2.0) + self._rng.normal(0.0, 0.1)
            if self._free(x, y, 0.5):
                self._put(kind, build(self._generator()), (x, y, turn), (half_x, half_y))
        self._put("path", buildings.path(self._path_points(), 0.8), (0.0, 0.0, 0.0))

    def add_walls(self) -> None:
        """What the garden is told to have besides; draws no random numbers."""
        for wall in self.spec.walls:
            parts, footprints = [], []
            for (x0, y0), (x1, y1) in pairwise(wall.points_m):
                length, turn = float(np.hypot(x1 - x0, y1 - y0)), float(np.arctan2(y1 - y0, x1 - x0))
                x, y = (x0 + x1) / 2.0, (y0 + y1) / 2.0
                parts.append(buildings.board_wall(length, wall.height_m, wall.thickness_m).placed(x, y, turn))
                footprints.append(Footprint(x, y, turn, length / 2.0, wall.thickness_m / 2.0))
            self.things.append(Thing("wall", Mesh.joined(parts), tuple(footprints)))

    def _along_fence(self, away_m: float) -> tuple[float, float]:
        """A random place ``away_m`` outside of the rectangle of the garden."""
        half: FloatArray = self.half + away_m
        side, along = int(self._rng.integers(4)), self._rng.uniform(-1.0, 1.0)
        sign = 1.0 if side < 2 else -1.0
        x, y = (along * half[0], sign * half[1]) if side % 2 == 0 else (sign * half[0], along * half[1])
        return float(x), float(y)

    def _path_points(self) -> list[tuple[float, float]]:
        """A winding way from one side to the opposite one."""
        along = np.linspace(-1.0, 1.0, 16) * (self.half[0] + 1.0)
        bend, phase = self._rng.uniform(0.1, 0.35) * self.half[1], self._rng.uniform(0.0, 2.0 * np.pi)
        across = bend * np.sin(along / self.half[0] * self._rng.uniform(1.0, 2.5) + phase)
        return [(float(a), float(b)) for a, b in zip(along, across, strict=True)]
