"""A car with all that makes people, and what has learnt from their pictures, say that it is one."""

from __future__ import annotations

import numpy as np

from andante.simulator.mesh import Layer, Matter, Mesh, Paint
from andante.simulator.shapes import box, prism, quads, rods

_RUBBER = Paint(0.015, 0.015, 0.017, Layer.SMOOTH, Matter.INDOOR)
_PLASTIC = Paint(0.035, 0.035, 0.04, Layer.SMOOTH, Matter.INDOOR)
_GLASS = Paint(0.07, 0.09, 0.11, Layer.SMOOTH, Matter.INDOOR)
_ALLOY = Paint(0.62, 0.63, 0.66, Layer.SMOOTH, Matter.INDOOR)
_LAMP = Paint(0.92, 0.92, 0.88, Layer.SMOOTH, Matter.INDOOR)
_TAIL = Paint(0.62, 0.02, 0.02, Layer.SMOOTH, Matter.INDOOR)
_PLATE = Paint(0.90, 0.90, 0.86, Layer.SMOOTH, Matter.INDOOR)
_LACQUERS = ((0.55, 0.03, 0.03), (0.60, 0.61, 0.64), (0.03, 0.09, 0.34), (0.82, 0.82, 0.80))

_SIDE_M, _WHEEL_M, _AXLES_M = 0.84, 0.33, (-1.28, 1.27)
_SILL, _WAIST, _ROOF = 0.24, 0.93, 1.47


def hatchback(rng: np.random.Generator) -> Mesh:
    """A small car with five doors along x, 4.1 m long."""
    lacquer = Paint(*_LACQUERS[rng.integers(len(_LACQUERS))], Layer.SMOOTH, Matter.INDOOR)
    return Mesh.joined([*_body(lacquer), *_greenhouse(lacquer), *_wheels(), *_front(), *_rear(), *_trim(lacquer)])


def _body(lacquer: Paint) -> list[Mesh]:
    outline = [(-1.96, _SILL), (1.94, _SILL), (2.04, 0.42), (2.02, 0.66), (1.82, 0.80), (1.02, 0.97), (-1.9, 1.0)]
    return [
        prism([*outline, (-2.03, 0.66), (-2.03, 0.4)], -_SIDE_M, _SIDE_M, lacquer),
        box((-1.9, -_SIDE_M - 0.01, 0.2), (1.9, _SIDE_M + 0.01, 0.31), _PLASTIC),
    ]


def _inward(z: float) -> float:
    """Half the width of the car above its waist, where the sides lean in."""
    return 0.82 - 0.36 * (z - _WAIST)


def _pane(points: list[tuple[float, float]], paint: Paint, out_m: float = 0.008) -> Mesh:
    """A four-cornered patch (x, z) on both leaning sides."""
    return quads(
        [[(x, side * (_inward(z) + out_m), z) for x, z in points] for side in (-1.0, 1.0)],
        paint,
    )


def _across(low: tuple[float, float], high: tuple[float, float], share: float, paint: Paint) -> Mesh:
    """A patch from side to side between two heights (x, z), ``share`` of the width."""
    corners = [
        (x, side * share * _inward(z), z) for (x, z), side in zip((low, low, high, high), (-1, 1, 1, -1), strict=True)
    ]
    return quads([corners], paint)


def _greenhouse(lacquer: Paint) -> list[Mesh]:
    """Roof, pillars and glass; the pillars are what is left of the painted sides between the panes."""
    side = _pane([(-1.93, 0.96), (1.05, 0.95), (0.30, _ROOF - 0.02), (-1.45, _ROOF)], lacquer, 0.0)
    front = _pane([(-0.28, 1.02), (0.74, 1.01), (0.20, 1.39), (-0.28, 1.40)], _GLASS)
    back = _pane([(-1.22, 1.03), (-0.40, 1.02), (-0.40, 1.40), (-1.16, 1.40)], _GLASS)
    corner = _pane([(-1.66, 1.06), (-1.34, 1.04), (-1.28, 1.38), (-1.40, 1.38)], _GLASS)
    return [
        side,
        front,
        back,
        corner,
        _across((1.05, 0.95), (0.30, 1.45), 1.0, lacquer),
        _across((1.02, 0.985), (0.345, 1.435), 0.9, _GLASS).placed(0.02, 0.0),
        _across((-1.93, 0.96), (-1.45, _ROOF), 1.0, lacquer),
        _across((-1.87, 1.05), (-1.50, 1.43), 0.88, _GLASS).placed(-0.02, 0.0),
        quads(
            [[(x, side * _inward(1.46), 1.455) for x, side in ((-1.46, -1), (0.31, -1), (0.31, 1), (-1.46, 1))]],
            lacquer,
        ),
    ]


def _wheels() -> list[Mesh]:
    turn = 2.0 * np.pi * np.arange(20) / 20
    circle = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    parts = []
    for x in _AXLES_M:
        middle = np.array([x, _WHEEL_M])
        parts.append(prism(middle + circle * 0.40 + (0.0, 0.03), -_SIDE_M - 0.004, _SIDE_M + 0.004, _RUBBER))
        for side in (-1.0, 1.0):
            inner, outer = sorted((side * 0.66, side * (_SIDE_M + 0.015)))
            parts.append(prism(middle + circle * _WHEEL_M, inner, outer, _RUBBER))
            parts.append(prism(middle + circle * 0.21, inner - 0.008, outer + 0.008, _ALLOY))
            parts.append(_spokes(middle, side * (_SIDE_M + 0.027)))
    return parts


def _spokes(middle: np.ndarray, y: float) -> Mesh:
    """Dark gaps between five spokes."""
    patches = []
    for turn in 2.0 * np.pi * (np.arange(5) + 0.5) / 5:
        angles = turn + np.array([-0.3, 0.3, 0.42, -0.42])
        radii = np.array([0.08, 0.08, 0.185, 0.185])
        patches.append(
            [(middle[0] + r * np.cos(a), y, middle[1] + r * np.sin(a)) for a, r in zip(angles, radii, strict=True)]
        )
    return quads(patches, _PLASTIC)


def _front() -> list[Mesh]:
    lamps = [box((1.86, y - 0.2, 0.62), (2.035, y + 0.2, 0.77), _LAMP) for y in (-0.62, 0.62)]
    grille = box((1.9, -0.4, 0.64), (2.04, 0.4, 0.74), _PLASTIC)
    intake = box((1.9, -0.65, 0.3), (2.055, 0.65, 0.46), _PLASTIC)
    return [*lamps, grille, intake, box((2.0, -0.26, 0.5), (2.06, 0.26, 0.61), _PLATE)]


def _rear() -> list[Mesh]:
    lamps = [box((-2.04, y - 0.13, 0.66), (-1.88, y + 0.13, 0.98), _TAIL) for y in (-0.72, 0.72)]
    bumper = box((-2.06, -0.8, 0.26), (-1.9, 0.8, 0.42), _PLASTIC)
    return [*lamps, bumper, box((-2.055, -0.26, 0.62), (-2.0, 0.26, 0.73), _PLATE)]


def _trim(lacquer: Paint) -> list[Mesh]:
    """Mirrors, door seams and handles."""
    parts = []
    for side in (-1.0, 1.0):
        y = side * (_SIDE_M + 0.004)
        seams = [[(x, y, 0.36), (x + 0.015, y, 0.36), (x + 0.015, y, 0.96), (x, y, 0.96)] for x in (-1.05, -0.34, 0.72)]
        parts.append(quads(seams, _PLASTIC))
        handles = [[(x, y, 0.83), (x + 0.17, y, 0.83), (x + 0.17, y, 0.865), (x, y, 0.865)] for x in (-0.95, -0.24)]
        parts.append(quads(handles, _PLASTIC))
        parts.append(
            box((0.66, min(side * 0.84, side * 1.0), 0.98), (0.80, max(side * 0.84, side * 1.0), 1.11), lacquer)
        )
    return [*parts, rods([[-1.2, 0.0, 1.46]], [[-1.4, 0.0, 1.66]], 0.008, 0.004, _PLASTIC, sides=4)]
