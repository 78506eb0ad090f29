"""The lawn of the navigation experiment: about 5 x 10 m, in the open and with a V-shaped obstacle (thesis 9.4)."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy.sparse as sp
from scipy.sparse.csgraph import dijkstra

from andante.data import FloatArray, IndexArray
from andante.errors import ConfigError
from andante.evaluation.experiments.plans import Scale
from andante.navigation import GradientSettings
from andante.simulator import (  # fmt: skip
    Conditions,
    Garden,
    GardenSpec,
    GridRun,
    InfieldRun,
    Plan,
    Session,
    SimulatedCamera,
    Wall,
    make_garden,
)
from andante.simulator.obstacles import Obstacles
from andante.simulator.trajectories import room_m

MAPPED, GRID = "infield", "grid"
ROBOT_RADIUS_M = 0.2
ARM_M = 1.3
CLEAR_M = 0.35
"""Of starts and goals, from everything: the robot has a radius of 0.2 m."""
_CELL_M, _AT_ONCE = 0.1, 20_000
_MAP_CELL_M = 0.2
_LEAST_M = 2.0
_STEADY = Conditions(clouds=0.0)
"""No clouds: every drive would have others, and the thesis drove indoors."""


def navigation_plan(seed: int, scale: Scale, *, obstacle: bool = True) -> Plan:
    """A drive to learn from, as long as ``scale`` says, and one picture at every place of a grid, in one garden."""
    garden = GardenSpec(seed=seed, size_x_m=8.0, size_y_m=14.0)
    if obstacle:
        garden = garden.model_copy(update={"walls": (v_wall(garden),)})
    camera = SimulatedCamera(
        model="panorama",
        width_px=scale.image_px,
        height_px=max(scale.image_px // 10, 4),
        min_deg=5.0,
        max_deg=50.0,
        antialias=False,  # the lowest frequencies do not care, and a drive takes half the time
    )
    sessions = (
        Session(name=MAPPED, seed=seed * 100 + 1, drive=InfieldRun(frames=scale.frames), conditions=_STEADY),
        Session(
            name=GRID, seed=seed * 100 + 2, drive=GridRun(spacing_m=_MAP_CELL_M, headings="random"), conditions=_STEADY
        ),
    )
    return Plan(garden=garden, camera=camera, sessions=sessions)


def v_wall(garden: GardenSpec, shift_m: tuple[float, float] = (0.0, 0.0)) -> Wall:
    """Two boards at right angles in the middle of the lawn, open towards +y."""
    low, high = (np.quantile(make_garden(garden).border.points_m, share, axis=0) for share in (0.0, 1.0))
    x, y = (low + high) / 2.0 + shift_m
    reach = ARM_M / np.sqrt(2.0)
    points = ((x - reach, y + reach / 2.0), (x, y - reach / 2.0), (x + reach, y + reach / 2.0))
    return Wall(points_m=tuple((float(a), float(b)) for a, b in points))


@dataclass(frozen=True, eq=False)
class Lawn:
    """Where a robot can be in a garden, and how far it is from one place to another."""

    garden: Garden

    @cached_property
    def xy_m(self) -> FloatArray:
        """(n, 2) the places of a grid of 0.1 m at which the robot touches nothing, inside of the border."""
        low, high = self.garden.border.points_m.min(axis=0), self.garden.border.points_m.max(axis=0)
        axes = [np.arange(a + _CELL_M / 2.0, b, _CELL_M) for a, b in zip(low, high, strict=True)]
        points = np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)
        # Part by part: the distances from all places of a large lawn to all things would take gigabytes.
        parts = np.array_split(points, len(points) // _AT_ONCE + 1)
        room = np.concatenate([room_m(self.garden, part) for part in parts])
        free: FloatArray = points[room >= ROBOT_RADIUS_M]
        return free

    @cached_property
    def room_m(self) -> FloatArray:
        """(n,) the distance of every place to the border or the nearest thing."""
        return room_m(self.garden, self.xy_m)

    @cached_property
    def wall(self) -> Obstacles:
        """The obstacle alone, which may be none."""
        things = (thing for thing in self.garden.things if thing.kind == "wall")
        return Obstacles.of(footprint for thing in things for footprint in thing.footprints)

    @cached_property
    def _graph(self) -> sp.csr_array:
        """Ways between places up to two cells apart: 16 directions, so that a length is at most 3 % too long."""
        cells = np.round((self.xy_m - self.xy_m.min(axis=0)) / _CELL_M).astype(np.int64)
        number = np.full(cells.max(axis=0) + 5, -1)
        number[tuple((cells + 2).T)] = np.arange(len(cells))
        parts = []
        for step in ((1, 0), (0, 1), (1, 1), (1, -1), (1, 2), (2, 1), (1, -2), (2, -1)):
            there = number[tuple((cells + 2 + step).T)]
            known = np.flatnonzero(there >= 0)
            parts.append((known, there[known], np.full(len(known), _CELL_M * np.hypot(*step))))
        first, second, length = (np.concatenate(column) for column in zip(*parts, strict=True))
        return sp.coo_array((length, (first, second)), shape=(len(cells), len(cells))).tocsr()

    def nearest(self, xy_m: FloatArray) -> IndexArray:
        """(k, 2) points -> (k,) the number of the nearest place."""
        apart = ((np.asarray(xy_m)[:, None] - self.xy_m[None]) ** 2).sum(axis=-1)
        return np.asarray(apart.argmin(axis=1), np.int64)

    def travel_m(self, goal_m: FloatArray) -> FloatArray:
        """(n,) length of the shortest way from every place to a point (2,); inf where there is none."""
        start = int(self.nearest(np.asarray(goal_m)[None])[0])
        lengths: FloatArray = dijkstra(self._graph, directed=False, indices=np.array([start]))[0]
        return lengths

    def divided(self, start_m: FloatArray, goal_m: FloatArray) -> bool:
        """Whether the obstacle lies between two points."""
        between = start_m + np.linspace(0.0, 1.0, 100)[:, None] * (goal_m - start_m)
        return bool((self.wall.clearance_m(between) <= 0.0).any())


@dataclass(frozen=True, slots=True)
class Errand:
    """From a pose to a point, and how long the shortest way is; metres, radians."""

    start: tuple[float, float, float]
    goal: tuple[float, float]
    shortest_m: float


def fixed_errands(lawn: Lawn, repeats: int, seed: int) -> list[Errand]:
    """Four starts with their goals as in thesis 9.4, ``repeats`` times each, with headings by chance.

    In the open from corner to corner and side to side; with an obstacle to a goal inside of it, from behind it.
    """
    low, high = lawn.xy_m.min(axis=0), lawn.xy_m.max(axis=0)
    shares = [
        ((0.2, 0.15), (0.8, 0.85)),
        ((0.8, 0.15), (0.2, 0.8)),
        ((0.5, 0.85), (0.5, 0.1)),
        ((0.2, 0.5), (0.8, 0.6)),
    ]
    pairs = [(low + np.array(a) * (high - low), low + np.array(b) * (high - low)) for a, b in shares]
    if len(lawn.wall.rows):
        inside = lawn.wall.rows[:, :2].mean(axis=0) + np.array([0.0, 0.25])
        starts = [low + np.array(a) * (high - low) for a in ((0.2, 0.1), (0.4, 0.2), (0.6, 0.1), (0.8, 0.2))]
        pairs = [(start, inside) for start in starts]
    rng = np.random.default_rng([seed, 94])
    return [_errand(lawn, *pair, rng) for pair in pairs for _ in range(repeats)]


def random_errands(lawn: Lawn, count: int, seed: int) -> list[Errand]:
    """Pairs of places at least 2 m apart; with an obstacle, such that it lies between them."""
    rng = np.random.default_rng([seed, 95])
    roomy = lawn.xy_m[lawn.room_m >= CLEAR_M]
    found: list[Errand] = []
    for _ in range(1000 * count):
        start, goal = roomy[rng.integers(len(roomy), size=2)]
        if len(found) == count:
            return found
        if np.hypot(*(goal - start)) >= _LEAST_M and (not len(lawn.wall.rows) or lawn.divided(start, goal)):
            found.append(_errand(lawn, start, goal, rng))
    raise ConfigError(f"only {len(found)} of {count} pairs of places found in this garden; use another seed")


def _errand(lawn: Lawn, start: FloatArray, goal: FloatArray, rng: np.random.Generator) -> Errand:
    roomy = lawn.xy_m[lawn.room_m >= CLEAR_M]
    start, goal = (roomy[((roomy - point) ** 2).sum(axis=1).argmin()] for point in (start, goal))
    length = float(lawn.travel_m(goal)[lawn.nearest(start[None])[0]])
    pose = (float(start[0]), float(start[1]), _heading(lawn, start, rng))
    return Errand(pose, (float(goal[0]), float(goal[1])), length)


def _heading(lawn: Lawn, start: FloatArray, rng: np.random.Generator) -> float:
    """By chance among those with which the V-shaped start stays on the lawn, or the one that comes nearest to that.

    Nobody would put a robot down with its nose to the border and have it drive a metre straight on.
    """
    headings = rng.uniform(-np.pi, np.pi, 64)
    along = np.linspace(0.0, 1.0, 20)[1:, None]
    rooms = []
    for heading in headings:
        corner, leg = (
            GradientSettings().v_length_m / 2.0 * np.array([np.cos(a), np.sin(a)])
            for a in (heading, heading + GradientSettings().v_turn_rad)
        )
        way = np.concatenate([start + along * corner, start + corner + along * leg])
        rooms.append(float(room_m(lawn.garden, way).min()))
    fitting = np.flatnonzero(np.array(rooms) >= ROBOT_RADIUS_M)
    return float(headings[fitting[0] if len(fitting) else int(np.argmax(rooms))])
