"""Things that people leave in a garden: there today, elsewhere tomorrow."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, get_args

import numpy as np

from andante.simulator.luggage import trolley
from andante.simulator.mesh import Layer, Matter, Mesh, Paint
from andante.simulator.shapes import box, boxes, chain, ellipsoid, prism, ring, rods
from andante.simulator.vehicles import hatchback

MovableKind = Literal["car", "bicycle", "chair", "umbrella", "suitcase", "cow", "person"]
MOVABLE_KINDS: tuple[MovableKind, ...] = get_args(MovableKind)
"""What visitors bring along by themselves; more would change what sessions with all of them look like."""
PlacedKind = Literal[MovableKind, "hatchback", "trolley"]
"""What can be put down on purpose: also things made so that detectors of everyday things know them."""

_VIVID = (
    (0.50, 0.05, 0.04),
    (0.05, 0.14, 0.45),
    (0.28, 0.06, 0.40),
    (0.30, 0.45, 0.06),
    (0.60, 0.42, 0.05),
    (0.55, 0.56, 0.58),
)
_BLACK = Paint(0.02, 0.02, 0.022, Layer.SMOOTH, Matter.INDOOR)
_STEEL = Paint(0.45, 0.46, 0.48, Layer.SMOOTH, Matter.INDOOR)
_PALE = Paint(0.80, 0.78, 0.70, Layer.SMOOTH, Matter.INDOOR)


def _vivid(rng: np.random.Generator) -> Paint:
    return Paint(*_VIVID[rng.integers(len(_VIVID))], Layer.SMOOTH, Matter.INDOOR)


def car(rng: np.random.Generator) -> Mesh:
    """A saloon along x."""
    body = _vivid(rng)
    hull = prism([(-2.1, 0.28), (2.1, 0.28), (2.15, 0.62), (1.95, 0.8), (-2.05, 0.88), (-2.15, 0.6)], -0.85, 0.85, body)
    cabin = prism([(-1.75, 0.82), (1.05, 0.8), (0.4, 1.38), (-1.2, 1.4)], -0.74, 0.74, _BLACK)
    roof = box((-1.2, -0.72, 1.38), (0.42, 0.72, 1.43), body)
    pillars = rods(
        [[-0.4, y, 0.8] for y in (-0.75, 0.75)], [[-0.4, y, 1.4] for y in (-0.75, 0.75)], 0.05, 0.05, body, sides=4
    )
    parts = [hull, cabin, roof, pillars]
    for x in (-1.35, 1.3):
        for y in (-0.8, 0.8):
            parts += [
                ellipsoid((x, y, 0.33), (0.33, 0.11, 0.33), _BLACK),
                ellipsoid((x, y * 1.1, 0.33), (0.17, 0.06, 0.17), _STEEL),
            ]
    lights = boxes([(2.1, -0.6, 0.55), (2.1, 0.6, 0.55)], (0.12, 0.3, 0.12), _PALE)
    return Mesh.joined([*parts, lights])


def bicycle(rng: np.random.Generator) -> Mesh:
    """A bicycle along x, standing."""
    frame = _vivid(rng)
    wheels = [ring((x, 0, 0.34), (0, 1, 0), 0.32, 0.022, _BLACK, sides=18) for x in (-0.52, 0.52)]
    turn = np.arange(8) * np.pi / 4
    spokes = []
    for x in (-0.52, 0.52):
        hub = np.tile([x, 0.0, 0.34], (8, 1))
        spokes.append(
            rods(hub, hub + 0.32 * np.stack([np.cos(turn), 0 * turn, np.sin(turn)], 1), 0.005, 0.005, _STEEL, sides=3)
        )
    pedal, saddle, head, rear, front = (
        (-0.08, 0, 0.3),
        (-0.2, 0, 0.82),
        (0.38, 0, 0.84),
        (-0.52, 0, 0.34),
        (0.52, 0, 0.34),
    )
    tubes = rods(
        [pedal, pedal, saddle, rear, rear, head], [saddle, head, head, pedal, saddle, front], 0.02, 0.02, frame, sides=5
    )
    bar = chain([(0.3, -0.28, 1.0), (0.4, 0, 0.98), (0.3, 0.28, 1.0)], 0.014, _BLACK, 5)
    stem = rods([head], [(0.4, 0, 0.98)], 0.018, 0.018, _STEEL, sides=5)
    return Mesh.joined([*wheels, *spokes, tubes, bar, stem, ellipsoid((-0.23, 0, 0.87), (0.14, 0.08, 0.035), _BLACK)])


def chair(rng: np.random.Generator) -> Mesh:
    """A garden chair that looks along x."""
    paint = _vivid(rng) if rng.random() < 0.5 else _PALE
    legs = boxes([(x, y, 0.0) for x in (-0.22, 0.22) for y in (-0.22, 0.22)], (0.05, 0.05, 0.44), paint)
    slats = [box((-0.27, y, 0.5), (-0.23, y + 0.08, 0.98), paint) for y in (-0.24, -0.1, 0.03, 0.16)]
    return Mesh.joined(
        [
            legs,
            box((-0.25, -0.26, 0.42), (0.27, 0.26, 0.47), paint),
            box((-0.28, -0.26, 0.94), (-0.22, 0.26, 1.02), paint),
            *slats,
        ]
    )


def umbrella(rng: np.random.Generator) -> Mesh:
    """A sunshade of alternating sectors on a pole."""
    colours = (_vivid(rng), _PALE)
    turn = np.arange(9) * np.pi / 4
    rim = np.stack([1.35 * np.cos(turn), 1.35 * np.sin(turn), np.full(9, 1.95)], 1)
    top = np.array([0.0, 0.0, 2.5])
    parts = [rods([[0, 0, 0]], [top], 0.03, 0.03, _STEEL, sides=6), ellipsoid((0, 0, 0.05), (0.3, 0.3, 0.07), _STEEL)]
    for sector in range(8):
        cloth = np.array([[rim[sector], rim[sector + 1], top]])
        parts.append(Mesh.of(cloth, cloth[..., :2], colours[sector % 2]))
    return Mesh.joined(parts)


def suitcase(rng: np.random.Generator) -> Mesh:
    """An upright suitcase with a handle."""
    body = box((-0.24, -0.14, 0.06), (0.24, 0.14, 0.76), _vivid(rng))
    handle = chain([(-0.12, 0, 0.76), (-0.12, 0, 1.0), (0.12, 0, 1.0), (0.12, 0, 0.76)], 0.012, _BLACK, 4)
    ribs = [box((x, -0.15, 0.08), (x + 0.02, 0.15, 0.765), _BLACK) for x in (-0.15, 0.13)]
    return Mesh.joined([body, handle, *ribs, boxes([(x, 0, 0) for x in (-0.2, 0.2)], (0.06, 0.2, 0.07), _BLACK)])


def cow(rng: np.random.Generator) -> Mesh:
    """A spotted cow along x."""
    hide, spot = (
        Paint(0.72, 0.70, 0.66, Layer.PLASTER, Matter.INDOOR),
        Paint(0.10, 0.06, 0.04, Layer.PLASTER, Matter.INDOOR),
    )
    body = ellipsoid((0, 0, 1.05), (0.95, 0.40, 0.42), hide, 16)
    pick = np.repeat(rng.random(len(body) // 2) < 0.35, 2)
    body = body.tinted(np.where(pick[:, None], 0.12, 1.0))
    feet = np.array([(x, y, 0.0) for x in (-0.65, 0.6) for y in (-0.22, 0.22)])
    legs = rods(feet, feet + np.array([0, 0, 0.95]), 0.06, 0.11, hide, sides=7)
    head = [
        ellipsoid((1.15, 0, 1.4), (0.3, 0.16, 0.18), spot),
        rods([[0.75, 0, 1.15]], [[1.1, 0, 1.42]], 0.24, 0.14, hide, sides=8),
    ]
    horns = rods(
        [(1.0, -0.1, 1.52), (1.0, 0.1, 1.52)], [(1.02, -0.24, 1.68), (1.02, 0.24, 1.68)], 0.03, 0.008, _PALE, sides=5
    )
    tail = chain([(-0.92, 0, 1.2), (-1.05, 0, 0.9), (-1.02, 0, 0.5)], 0.025, spot, 4)
    return Mesh.joined([body, legs, *head, horns, tail])


def person(rng: np.random.Generator) -> Mesh:
    """A standing person who looks along x."""
    skin = Paint(0.55, 0.34, 0.24, Layer.SMOOTH, Matter.INDOOR)
    shirt, trousers = _vivid(rng), Paint(0.06, 0.07, 0.12, Layer.SMOOTH, Matter.INDOOR)
    legs = rods([(0, -0.1, 0), (0, 0.1, 0)], [(0, -0.09, 0.85), (0, 0.09, 0.85)], 0.07, 0.1, trousers, sides=8)
    trunk = ellipsoid((0, 0, 1.15), (0.15, 0.23, 0.36), shirt)
    arms = rods(
        [(0, -0.24, 1.42), (0, 0.24, 1.42)], [(0.08, -0.33, 0.85), (0.08, 0.33, 0.85)], 0.06, 0.045, shirt, sides=7
    )
    hair = Paint(0.07, 0.045, 0.03, Layer.SMOOTH, Matter.INDOOR)
    return Mesh.joined(
        [
            legs,
            trunk,
            arms,
            ellipsoid((0, 0, 1.64), (0.1, 0.09, 0.13), skin),
            ellipsoid((-0.02, 0, 1.7), (0.1, 0.1, 0.1), hair),
        ]
    )


@dataclass(frozen=True, slots=True)
class MovableShape:
    """How to build a movable and how much room it takes, (along x, along y) in metres."""

    build: Callable[[np.random.Generator], Mesh]
    size_m: tuple[float, float]


MOVABLES: Mapping[PlacedKind, MovableShape] = {
    "car": MovableShape(car, (4.3, 1.8)),
    "bicycle": MovableShape(bicycle, (1.8, 0.6)),
    "chair": MovableShape(chair, (0.6, 0.6)),
    "umbrella": MovableShape(umbrella, (0.6, 0.6)),
    "suitcase": MovableShape(suitcase, (0.5, 0.3)),
    "cow": MovableShape(cow, (2.5, 0.9)),
    "person": MovableShape(person, (0.5, 0.7)),
    "hatchback": MovableShape(hatchback, (4.1, 1.8)),
    "trolley": MovableShape(trolley, (0.5, 0.3)),
}
