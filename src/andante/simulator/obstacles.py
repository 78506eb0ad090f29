"""Where things stand: upright boxes seen from above, and how far a point is from them."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from andante.data import FloatArray

_TOUCH_M = 0.01


@dataclass(frozen=True, slots=True)
class Footprint:
    """A rectangle on the ground: centre, heading of its first side, half lengths; metres and radians."""

    x_m: float
    y_m: float
    heading_rad: float
    half_x_m: float
    half_y_m: float


@dataclass(frozen=True, slots=True)
class Obstacles:
    """Footprints (m, 5): x, y, heading, half_x, half_y."""

    rows: FloatArray

    @classmethod
    def of(cls, footprints: Iterable[Footprint]) -> Obstacles:
        """From single footprints."""
        rows = [(f.x_m, f.y_m, f.heading_rad, f.half_x_m, f.half_y_m) for f in footprints]
        return cls(np.array(rows, np.float64).reshape(-1, 5))

    def clearance_m(self, xy_m: ArrayLike) -> FloatArray:
        """(k, 2) points -> (k,) distance to the nearest footprint, negative inside one, inf without any.

        The distance to a rectangle is signed everywhere, so that a robot that has got inside of something is seen.
        """
        points = np.asarray(xy_m, np.float64).reshape(-1, 2)
        if not len(self.rows):
            return np.full(len(points), np.inf)
        offset = points[:, None] - self.rows[None, :, :2]
        cos, sin = np.cos(self.rows[:, 2]), np.sin(self.rows[:, 2])
        beyond_x = np.abs(offset[..., 0] * cos + offset[..., 1] * sin) - self.rows[:, 3]
        beyond_y = np.abs(offset[..., 1] * cos - offset[..., 0] * sin) - self.rows[:, 4]
        outside = np.hypot(np.maximum(beyond_x, 0.0), np.maximum(beyond_y, 0.0))
        inside = np.minimum(np.maximum(beyond_x, beyond_y), 0.0)
        return np.asarray((outside + inside).min(axis=1), np.float64)

    def free_way_m(self, xy_m: tuple[float, float], heading_rad: float, *, radius_m: float, reach_m: float) -> float:
        """How far a disc could go straight on before it touched something, at most ``reach_m``.

        Each stride is as long as the disc has room, so that none can jump over a thing. A disc that touches something
        already may leave it: what it touches bars only the way that leads nearer.
        """
        here = float(self.clearance_m([xy_m])[0])
        radius = min(radius_m, here - _TOUCH_M)
        way = 0.0
        while way < reach_m:
            at = (xy_m[0] + way * np.cos(heading_rad), xy_m[1] + way * np.sin(heading_rad))
            room = float(self.clearance_m([at])[0]) - radius
            if room < _TOUCH_M / 2.0:
                return way
            way += room
        return reach_m


def joined(parts: Sequence[Obstacles]) -> Obstacles:
    """All footprints of several."""
    return Obstacles(np.concatenate([part.rows for part in parts]))
