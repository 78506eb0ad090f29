"""How a robot drives through a garden: along the border, at random inside, over a grid, or as told.

Every kind is part of a plan; ``drive`` gives the true poses, the same for the same garden and seed.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field
from scipy.ndimage import gaussian_filter1d

from andante.angles import wrapped
from andante.data import FloatArray, Trajectory
from andante.errors import ConfigError
from andante.simulator.garden import Garden
from andante.simulator.settings import Settings

_Positive = Annotated[float, Field(gt=0)]
_Frames = Annotated[int, Field(ge=1, le=1_000_000)]


class _Drive(Settings):
    """What all drives share: 0.67 m/s at 5 pictures a second are 0.134 m from picture to picture."""

    speed_m_s: Annotated[float, Field(gt=0, le=5)] = 0.67
    rate_hz: Annotated[float, Field(gt=0, le=60)] = 5.0

    @property
    def step_m(self) -> float:
        """Way from picture to picture."""
        return self.speed_m_s / self.rate_hz

    def _trajectory(self, xy_m: ArrayLike, heading_rad: ArrayLike) -> Trajectory:
        points = np.asarray(xy_m, np.float64).reshape(-1, 2)
        return Trajectory(np.arange(len(points)) / self.rate_hz, points, wrapped(np.asarray(heading_rad, np.float64)))


class BorderRun(_Drive):
    """Once or more around the lawn, ``inset_m`` inside of the border, never twice exactly on the same line.

    ``wobble_m`` is the deviation from that line; ``start`` the share of a lap where the run begins. Parts of laps are
    allowed.
    """

    kind: Literal["border"] = "border"
    laps: Annotated[float, Field(gt=0, le=100)] = 1.0
    clockwise: bool = False
    inset_m: Annotated[float, Field(ge=0, le=20)] = 0.1
    wobble_m: Annotated[float, Field(ge=0, le=0.3)] = 0.02
    start: Annotated[float, Field(ge=0, lt=1)] = 0.0

    def drive(self, garden: Garden, rng: np.random.Generator) -> Trajectory:
        """The poses in a garden; raises ``ConfigError`` where the inset leaves nothing of the border."""
        line = garden.border.inset(self.inset_m)
        length, steps = line.length_m, max(round(self.laps * line.length_m / self.step_m), 1)
        along = (self.start * length + np.arange(-1, steps + 1) * self.step_m * (-1 if self.clockwise else 1)) % length
        loop = np.concatenate([line.points_m, line.points_m[:1]])
        arc = np.linspace(0.0, length, len(loop))
        points = np.stack([np.interp(along, arc, loop[:, axis]) for axis in (0, 1)], 1)
        points += _wobble(rng, len(points), self.wobble_m)
        ahead = points[2:] - points[:-2]
        return self._trajectory(points[1:-1], np.arctan2(ahead[:, 1], ahead[:, 0]))


class InfieldRun(_Drive):
    """Straight on until the border or an obstacle, then a turn on the spot in a random direction (thesis 9.4)."""

    kind: Literal["infield"] = "infield"
    frames: _Frames = 500
    clearance_m: Annotated[float, Field(ge=0.05, le=5)] = 0.3
    turn_rad_s: Annotated[float, Field(gt=0, le=6)] = 1.2

    def drive(self, garden: Garden, rng: np.random.Generator) -> Trajectory:
        """The poses in a garden; raises ``ConfigError`` where there is no room to begin."""
        x, y = _free_spot(garden, rng, self.clearance_m)
        heading, turning = rng.uniform(-np.pi, np.pi), 0.0
        rows = np.empty((self.frames, 3))
        for row in rows:
            row[:] = x, y, heading
            if turning:
                turn = np.clip(turning, -self.turn_rad_s / self.rate_hz, self.turn_rad_s / self.rate_hz)
                heading, turning = heading + turn, turning - turn
                continue
            ahead = x + self.step_m * np.cos(heading), y + self.step_m * np.sin(heading)
            if room_m(garden, [ahead])[0] >= self.clearance_m:
                x, y = ahead
                heading += rng.normal(0.0, 0.008)
            else:
                turning = self._new_direction(garden, rng, (x, y), heading)
        return self._trajectory(rows[:, :2], rows[:, 2])

    def _new_direction(
        self, garden: Garden, rng: np.random.Generator, at: tuple[float, float], heading: float
    ) -> float:
        """A random turn after which there is room for a metre, or the best of fifty."""
        turns = rng.uniform(0.3, 1.0, 50) * rng.choice([-1.0, 1.0], 50) * np.pi
        reach = np.linspace(self.step_m, 1.0, 6)
        ways = (
            np.asarray(at)
            + reach[None, :, None] * np.stack([np.cos(heading + turns), np.sin(heading + turns)], 1)[:, None]
        )
        room = room_m(garden, ways.reshape(-1, 2)).reshape(50, -1).min(axis=1)
        free = np.flatnonzero(room >= self.clearance_m)
        return float(turns[free[0] if len(free) else int(np.argmax(room))])


class GridRun(_Drive):
    """Row by row over every free place of a square grid, for maps of slow features."""

    kind: Literal["grid"] = "grid"
    spacing_m: Annotated[float, Field(ge=0.02, le=20)] = 0.5
    clearance_m: Annotated[float, Field(ge=0, le=5)] = 0.2
    headings: Literal["along", "random", "zero"] = "zero"

    def drive(self, garden: Garden, rng: np.random.Generator) -> Trajectory:
        """The poses in a garden, one picture each; raises ``ConfigError`` where no place is free."""
        low, high = garden.border.points_m.min(axis=0), garden.border.points_m.max(axis=0)
        columns, rows = (np.arange(a + self.spacing_m / 2.0, b, self.spacing_m) for a, b in zip(low, high, strict=True))
        lines = [[(x, y) for x in (columns if number % 2 == 0 else columns[::-1])] for number, y in enumerate(rows)]
        points = np.array([point for line in lines for point in line]).reshape(-1, 2)
        along = np.concatenate(
            [np.full(len(columns), 0.0 if number % 2 == 0 else np.pi) for number in range(len(rows))]
        )
        free = room_m(garden, points) >= self.clearance_m
        if not free.any():
            raise ConfigError(
                f"a grid of {self.spacing_m:g} m finds no free place; use a smaller spacing_m or clearance_m"
            )
        headings = {"along": along, "random": rng.uniform(-np.pi, np.pi, len(along)), "zero": 0.0 * along}
        return self._trajectory(points[free], headings[self.headings][free])


class GivenPoses(_Drive):
    """Any poses, each [x_m, y_m, heading_rad]."""

    kind: Literal["poses"] = "poses"
    poses: Annotated[tuple[tuple[float, float, float], ...], Field(min_length=1)]

    def drive(self, garden: Garden, rng: np.random.Generator) -> Trajectory:
        """These poses, whatever the garden."""
        rows = np.array(self.poses, np.float64)
        return self._trajectory(rows[:, :2], rows[:, 2])


Drive = Annotated[BorderRun | InfieldRun | GridRun | GivenPoses, Field(discriminator="kind")]


def room_m(garden: Garden, xy_m: ArrayLike) -> FloatArray:
    """(k, 2) points -> (k,) distance to the border or the nearest obstacle, negative outside or inside one."""
    return np.minimum(garden.border.inside_m(xy_m), garden.obstacles.clearance_m(xy_m))


def _free_spot(garden: Garden, rng: np.random.Generator, clearance_m: float) -> tuple[float, float]:
    low, high = garden.border.points_m.min(axis=0), garden.border.points_m.max(axis=0)
    spots = rng.uniform(low, high, (400, 2))
    free = np.flatnonzero(room_m(garden, spots) >= clearance_m)
    if not len(free):
        raise ConfigError(
            f"no place in this garden is {clearance_m:g} m clear of all things; use a smaller clearance_m"
        )
    return float(spots[free[0], 0]), float(spots[free[0], 1])


def _wobble(rng: np.random.Generator, count: int, deviation_m: float) -> FloatArray:
    """Smooth random offsets (count, 2), as of a robot that hunts for its wire."""
    smooth = gaussian_filter1d(rng.standard_normal((count + 60, 2)), 6.0, axis=0)[30 : count + 30]
    return np.asarray(smooth / 0.217 * deviation_m, np.float64)
