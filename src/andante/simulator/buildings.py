"""Everything that was built: houses, sheds, fences, tables, rocks, paths and the V-shaped obstacle."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from andante.simulator.mesh import Layer, Matter, Mesh, Paint
from andante.simulator.shapes import box, boxes, chain, ellipsoid, quads, rods

_WALLS = (
    Paint(0.40, 0.16, 0.10, Layer.BRICK),
    Paint(0.47, 0.30, 0.20, Layer.BRICK),
    Paint(0.66, 0.62, 0.52, Layer.PLASTER),
    Paint(0.60, 0.54, 0.36, Layer.PLASTER),
    Paint(0.45, 0.50, 0.52, Layer.PLASTER),
    Paint(0.68, 0.66, 0.64, Layer.PLASTER),
)
_ROOFS = ((0.46, 0.15, 0.08), (0.36, 0.13, 0.09), (0.17, 0.17, 0.19), (0.30, 0.20, 0.14))
_WOODS = ((0.36, 0.22, 0.11), (0.46, 0.33, 0.19), (0.24, 0.15, 0.08), (0.42, 0.38, 0.33), (0.55, 0.53, 0.48))
_DOORS = ((0.10, 0.16, 0.08), (0.25, 0.09, 0.05), (0.12, 0.16, 0.26), (0.42, 0.40, 0.36))
_GLASS = Paint(0.035, 0.055, 0.085, Layer.SMOOTH, Matter.INDOOR)
_FRAME = Paint(0.72, 0.71, 0.68, Layer.SMOOTH, Matter.INDOOR)
_METAL = Paint(0.25, 0.26, 0.27)
_BOARD = Paint(0.62, 0.55, 0.40, Layer.WOOD)


@dataclass(frozen=True, slots=True)
class _Body:
    """The size of a building: its ridge is along its length, ``rise_m`` above its walls."""

    length_m: float
    depth_m: float
    wall_m: float
    rise_m: float


def house(rng: np.random.Generator, length_m: float, depth_m: float, wall_m: float) -> Mesh:
    """A house with its ridge along x, windows on all sides, a door at -y and a chimney."""
    wall = _WALLS[rng.integers(len(_WALLS))]
    roof = Paint(*_ROOFS[rng.integers(len(_ROOFS))], Layer.TILES, Matter.ROOF)
    rise = depth_m * rng.uniform(0.3, 0.5)
    body = _Body(length_m, depth_m, wall_m, rise)
    door = Paint(*_DOORS[rng.integers(len(_DOORS))], Layer.WOOD, Matter.INDOOR)
    parts = [_shell(body, wall), _gable_roof(body, 0.45, roof)]
    door_x = rng.uniform(-0.3, 0.3) * length_m
    size = (rng.uniform(0.9, 1.25), rng.uniform(1.0, 1.3))
    for facing, width, distance in (
        (0, length_m, depth_m),
        (1, depth_m, length_m),
        (2, length_m, depth_m),
        (3, depth_m, length_m),
    ):
        row = _window_row(width, wall_m, size, rng, door_x if facing == 0 else None)
        parts.append(row.placed(0.0, -distance / 2.0).placed(0.0, 0.0, facing * np.pi / 2.0))
    parts.append(box((door_x - 0.5, -depth_m / 2 - 0.04, 0.0), (door_x + 0.5, -depth_m / 2 + 0.1, 2.05), door))
    stack = rng.uniform(-0.35, 0.35) * length_m
    chimney = Paint(0.36, 0.15, 0.1, Layer.BRICK)
    parts.append(box((stack - 0.3, 0.1, wall_m), (stack + 0.3, 0.7, wall_m + rise + rng.uniform(0.4, 0.9)), chimney))
    return Mesh.joined(parts)


def _shell(body: _Body, paint: Paint) -> Mesh:
    """Walls with gables at both ends."""
    x, y, wall_m, rise_m = body.length_m / 2.0, body.depth_m / 2.0, body.wall_m, body.rise_m
    sides = quads(
        [
            [(-x, -y, 0), (x, -y, 0), (x, -y, wall_m), (-x, -y, wall_m)],
            [(x, -y, 0), (x, y, 0), (x, y, wall_m), (x, -y, wall_m)],
            [(x, y, 0), (-x, y, 0), (-x, y, wall_m), (x, y, wall_m)],
            [(-x, y, 0), (-x, -y, 0), (-x, -y, wall_m), (-x, y, wall_m)],
        ],
        paint,
    )
    gables = np.array(
        [[[e, -y * s, wall_m], [e, y * s, wall_m], [e, 0.0, wall_m + rise_m]] for e, s in ((x, 1), (-x, -1))]
    )
    return Mesh.joined([sides, Mesh.of(gables, gables[..., 1:], paint)])


def _gable_roof(body: _Body, eaves_m: float, paint: Paint) -> Mesh:
    """Two slabs that overhang the walls."""
    slope = body.rise_m / (body.depth_m / 2.0)
    x, y = body.length_m / 2.0 + eaves_m * 0.7, body.depth_m / 2.0 + eaves_m
    low, ridge, thick = body.wall_m - eaves_m * slope + 0.03, body.wall_m + body.rise_m + 0.03, 0.14
    outline = [(-y, low), (0.0, ridge), (y, low), (y, low + thick), (0.0, ridge + thick), (-y, low + thick)]
    ring = np.array([[(e, py, pz) for py, pz in outline] for e in (-x, x)])
    order = np.arange(6)
    patches = np.stack([ring[0, order], ring[0, (order + 1) % 6], ring[1, (order + 1) % 6], ring[1, order]], 1)
    ends = ring[:, [[0, 1, 4, 5], [1, 2, 3, 4]]].reshape(-1, 4, 3)
    return quads(np.concatenate([patches[:, [0, 3, 2, 1]], ends]), paint)


def _window_row(
    width_m: float, wall_m: float, size: tuple[float, float], rng: np.random.Generator, door_x: float | None
) -> Mesh:
    """Windows on the wall y = 0 that faces -y; none where the door is."""
    storeys = max(1, int(wall_m // 2.5))
    count = max(1, int(width_m / rng.uniform(1.9, 2.7)))
    parts = [box((0.0, 0.0, 0.1), (0.01, 0.01, 0.11), _FRAME)]
    for storey in range(storeys):
        for x in (np.arange(count) + 0.5) / count * width_m - width_m / 2.0:
            if storey == 0 and door_x is not None and abs(x - door_x) < 0.65 + size[0] / 2.0:
                continue
            parts.append(window(x, 0.9 + 2.5 * storey, *size))
    return Mesh.joined(parts)


def window(x_m: float, sill_m: float, width_m: float, height_m: float) -> Mesh:
    """A window on the wall y = 0, seen from -y: frame, two panes and a sill."""
    left, right, top = x_m - width_m / 2.0, x_m + width_m / 2.0, sill_m + height_m
    frame = box((left, -0.05, sill_m), (right, 0.02, top), _FRAME)
    edge, middle = 0.08, x_m
    panes = [(left + edge, middle - edge / 3.0), (middle + edge / 3.0, right - edge)]
    glass = [box((a, -0.07, sill_m + edge), (b, 0.0, top - edge), _GLASS) for a, b in panes]
    return Mesh.joined([frame, *glass, box((left - 0.06, -0.12, sill_m - 0.06), (right + 0.06, 0.02, sill_m), _METAL)])


def shed(rng: np.random.Generator, length_m: float, depth_m: float) -> Mesh:
    """A wooden shed with a door and a window at -y."""
    wood = Paint(*_WOODS[rng.integers(len(_WOODS))], Layer.WOOD)
    roof = Paint(*_ROOFS[rng.integers(len(_ROOFS))], Layer.TILES, Matter.ROOF)
    body = _Body(length_m, depth_m, rng.uniform(1.8, 2.2), rng.uniform(0.4, 0.9))
    door = Paint(*_DOORS[rng.integers(len(_DOORS))], Layer.WOOD, Matter.INDOOR)
    y = -depth_m / 2.0
    return Mesh.joined(
        [
            _shell(body, wood),
            _gable_roof(body, 0.2, roof),
            box((-length_m * 0.38, y - 0.04, 0.0), (-length_m * 0.38 + 0.8, y + 0.02, 1.7), door),
            window(length_m * 0.22, 0.9, 0.6, 0.55).placed(0.0, y),
        ]
    )


def fence(rng: np.random.Generator, length_m: float, height_m: float) -> Mesh:
    """A picket fence along x, centred."""
    wood = Paint(*_WOODS[rng.integers(len(_WOODS))], Layer.WOOD)
    count = max(2, int(length_m / 0.16))
    x = (np.arange(count) + 0.5) / count * length_m - length_m / 2.0
    tops = height_m * rng.uniform(0.96, 1.03, count)
    front = [
        [(a - 0.05, 0, 0), (a + 0.05, 0, 0), (a + 0.05, 0, t - 0.08), (a - 0.05, 0, t - 0.08)]
        for a, t in zip(x, tops, strict=True)
    ]
    points = np.array(
        [[(a - 0.05, 0, t - 0.08), (a + 0.05, 0, t - 0.08), (a, 0, t)] for a, t in zip(x, tops, strict=True)]
    )
    pickets = Mesh.joined([quads(front, wood), Mesh.of(points, points[..., [0, 2]], wood)])
    pickets = pickets.tinted(np.concatenate([np.repeat(s := rng.uniform(0.8, 1.15, (count, 1)), 2, 0), s]))
    rails = [
        box((-length_m / 2, 0.01, z), (length_m / 2, 0.05, z + 0.08), wood) for z in (height_m * 0.2, height_m * 0.72)
    ]
    posts = np.linspace(-length_m / 2, length_m / 2, max(2, int(length_m / 2.2)))
    stakes = boxes(np.stack([posts, 0 * posts + 0.06, 0 * posts], 1), (0.1, 0.1, height_m), wood)
    return Mesh.joined([pickets, *rails, stakes])


def table(rng: np.random.Generator) -> Mesh:
    """A garden table with two benches."""
    wood = Paint(*_WOODS[rng.integers(len(_WOODS))], Layer.WOOD)
    length = rng.uniform(1.3, 2.0)
    tops = [box((-length / 2, -0.4, 0.7), (length / 2, 0.4, 0.76), wood)]
    tops += [box((-length / 2, y - 0.15, 0.42), (length / 2, y + 0.15, 0.46), wood) for y in (-0.75, 0.75)]
    x = length / 2 - 0.15
    feet = [(a * x, b) for a in (-1, 1) for b in (-0.3, 0.3, -0.75, 0.75)]
    heights = [0.7 if abs(y) < 0.5 else 0.42 for _, y in feet]
    legs = boxes([(a, b, 0.0) for a, b in feet], [(0.08, 0.08, h) for h in heights], wood)
    return Mesh.joined([*tops, legs])


def rocks(rng: np.random.Generator) -> Mesh:
    """A heap of boulders."""
    parts = []
    for _ in range(int(rng.integers(5, 11))):
        size = rng.uniform(0.14, 0.5)
        grey = rng.uniform(0.2, 0.45)
        rock = ellipsoid(
            (0, 0, size * 0.4), size * rng.uniform(0.7, 1.1, 3), Paint(grey, grey * 0.98, grey * 0.93, Layer.STONE), 10
        )
        parts.append(rock.placed(rng.normal(0, 0.6), rng.normal(0, 0.35), rng.uniform(0, np.pi)))
    return Mesh.joined(parts)


def barrel(rng: np.random.Generator) -> Mesh:
    """A rain barrel."""
    paint = Paint(*_DOORS[rng.integers(len(_DOORS))], Layer.WOOD)
    z, radius = np.array([0.0, 0.3, 0.6, 0.9]), np.array([0.26, 0.32, 0.32, 0.26])
    lid = ellipsoid((0, 0, 0.9), (0.26, 0.26, 0.03), paint)
    return Mesh.joined([chain(np.stack([0 * z, 0 * z, z], 1), radius, paint, 14), lid])


def lamp(rng: np.random.Generator) -> Mesh:
    """A garden lamp on a post."""
    height = rng.uniform(1.5, 2.6)
    post = rods([[0, 0, 0]], [[0, 0, height]], 0.04, 0.03, _METAL, sides=6)
    return Mesh.joined(
        [post, ellipsoid((0, 0, height + 0.14), 0.16, Paint(0.8, 0.78, 0.7, Layer.SMOOTH, Matter.INDOOR))]
    )


def path(points: Sequence[tuple[float, float]], width_m: float) -> Mesh:
    """A gravel path along ``points``, just above the lawn."""
    line = np.asarray(points, np.float64)
    ahead = np.gradient(line, axis=0)
    side = np.stack([-ahead[:, 1], ahead[:, 0]], 1) / np.linalg.norm(ahead, axis=1, keepdims=True) * width_m / 2.0
    left, right = np.insert(line + side, 2, 0.003, 1), np.insert(line - side, 2, 0.003, 1)
    patches = np.stack([right[:-1], right[1:], left[1:], left[:-1]], 1)
    return quads(patches, Paint(0.42, 0.37, 0.30, Layer.GRAVEL, Matter.GROUND))


def v_obstacle(arm_m: float, height_m: float) -> Mesh:
    """Two walls that meet at the origin and open towards +x (thesis chapter 9)."""
    arm = box((0.0, -0.04, 0.0), (arm_m, 0.04, height_m), _BOARD)
    return Mesh.joined([arm.placed(0.0, 0.0, turn) for turn in (np.pi / 4.0, -np.pi / 4.0)])


def board_wall(length_m: float, height_m: float, thickness_m: float) -> Mesh:
    """A wall along x, centred."""
    half, deep = length_m / 2.0, thickness_m / 2.0
    return box((-half, -deep, 0.0), (half, deep, height_m), _BOARD)
