"""Rooms with windows and furniture, for a robot that was carried into the house."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from andante.data import ImageArray, Pose2D
from andante.simulator import Conditions, Renderer, Scene, SimulatedCamera, Thing
from andante.simulator.mesh import Layer, Matter, Mesh, Paint
from andante.simulator.shapes import box

_WALL_M = 0.05
_SILL_M, _LINTEL_M = 0.9, 2.0
_FREE_M = 1.0  # around the middle, where the robot stands
_EXPOSURE = 4.0
_FURNITURE = (Layer.WOOD, Layer.SMOOTH, Layer.STONE)


def indoor_pictures(rng: np.random.Generator, camera: SimulatedCamera, count: int) -> Iterator[ImageArray]:
    """``count`` grey fisheye pictures, each from a room of its own. Raises ``MissingExtraError`` without embreex."""
    for number in range(count):
        light = Conditions(exposure=_EXPOSURE, hour=round(rng.uniform(8, 16), 1), clouds=round(rng.random(), 2))
        x, y, heading = rng.uniform((-0.8, -0.8, -np.pi), (0.8, 0.8, np.pi)).tolist()
        image = Renderer(furnished_room(rng), light, camera, number).render(Pose2D(x, y, heading)).image
        yield np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)


def furnished_room(rng: np.random.Generator) -> Scene:
    """Four walls, one or two windows, a floor, a ceiling with a lamp, and some furniture along the walls."""
    (width, depth), height = rng.uniform(3.5, 7.0, 2), float(rng.uniform(2.3, 2.9))
    x, y = width / 2, depth / 2
    wall = _paint(rng, Layer.PLASTER, 0.3, 0.8)
    parts = [
        box((-x, -y, -0.1), (x, y, 0.0), _paint(rng, Layer.WOOD, 0.1, 0.4)),
        box((-x, -y, height), (x, y, height + 0.1), _paint(rng, Layer.PLASTER, 0.6, 0.9)),
        box((-0.2, -0.2, height - 0.5), (0.2, 0.2, height - 0.3), _paint(rng, Layer.SMOOTH, 0.8, 0.95)),
        *(box((side - _WALL_M, -y, 0.0), (side + _WALL_M, y, height), wall) for side in (-x, x)),
        *_wall(rng, -y, x, height, wall, window=True),
        *_wall(rng, y, x, height, wall, window=bool(rng.random() < 0.5)),
        *_furniture(rng, x, y),
    ]
    return Scene.of([Thing("room", Mesh.joined(parts))])


def _wall(
    rng: np.random.Generator, at_y: float, half_x: float, height: float, paint: Paint, *, window: bool
) -> list[Mesh]:
    """A wall along x, of four parts where it has a window."""
    low, high = at_y - _WALL_M, at_y + _WALL_M
    if not window:
        return [box((-half_x, low, 0.0), (half_x, high, height), paint)]
    left = float(rng.uniform(-half_x + 0.3, half_x - 1.8))
    right = left + float(rng.uniform(0.9, 1.4))
    return [
        box((-half_x, low, 0.0), (left, high, height), paint),
        box((right, low, 0.0), (half_x, high, height), paint),
        box((left, low, 0.0), (right, high, _SILL_M), paint),
        box((left, low, _LINTEL_M), (right, high, height), paint),
    ]


def _furniture(rng: np.random.Generator, half_x: float, half_y: float) -> list[Mesh]:
    parts = []
    for _ in range(int(rng.integers(5, 12))):
        middle = rng.uniform((0.4 - half_x, 0.4 - half_y), (half_x - 0.4, half_y - 0.4))
        half, height = rng.uniform((0.15, 0.15), (0.6, 0.4)), float(rng.uniform(0.4, 2.0))
        paint = _paint(rng, _FURNITURE[int(rng.integers(len(_FURNITURE)))], 0.05, 0.7)
        if np.abs(middle).max() > _FREE_M + 0.6:
            parts.append(box((*(middle - half), 0.0), (*(middle + half), height), paint))
    return parts


def _paint(rng: np.random.Generator, layer: Layer, low: float, high: float) -> Paint:
    red, green, blue = np.clip(rng.uniform(low, high) * rng.uniform(0.8, 1.2, 3), 0.02, 0.95).tolist()
    return Paint(red, green, blue, layer, Matter.INDOOR)
