"""Everything that grows: trees, conifers, bushes, hedges and flower pots."""

from __future__ import annotations

import numpy as np

from andante.simulator.mesh import Layer, Matter, Mesh, Paint
from andante.simulator.shapes import Points, box, ellipsoid, leaves, rods

_BARK = Paint(0.16, 0.105, 0.07, Layer.BARK)
_GREENS = ((0.10, 0.21, 0.045), (0.13, 0.24, 0.05), (0.075, 0.17, 0.05), (0.17, 0.25, 0.06))
_CLAY = Paint(0.42, 0.17, 0.09, Layer.PLASTER)
_BLOSSOMS = ((0.55, 0.12, 0.32), (0.62, 0.50, 0.10), (0.42, 0.16, 0.55), (0.70, 0.66, 0.62), (0.60, 0.10, 0.06))


def broadleaf(rng: np.random.Generator, height_m: float, leaf_m: float = 0.30) -> Mesh:
    """A deciduous tree: trunk, three orders of branches and a crown of leaf cards on the twigs."""
    crown_base = height_m * rng.uniform(0.26, 0.38)
    radius = height_m * rng.uniform(0.018, 0.026)
    lean = rng.normal(0.0, 0.04, 2)
    top = np.array([lean[0] * height_m, lean[1] * height_m, height_m * 0.72])
    foot = np.array([0.0, 0.0, -0.05])
    wood = [
        rods(
            np.stack([foot, top * 0.5]),
            np.stack([top * 0.5, top]),
            [radius, radius * 0.75],
            [radius * 0.75, 0.02],
            _BARK,
            sides=8,
        )
    ]
    start, end = np.array([[0.0, 0.0, crown_base]]), top[None]
    spread = rng.uniform(0.55, 0.8) * height_m
    tips: Points = end
    for order, (children, reach) in enumerate(((8, 0.62), (5, 0.5), (3, 0.36))):
        start, end = _branches(rng, start, end, children, spread * reach * 0.62**order)
        thick = radius * 0.42 * 0.5**order
        wood.append(rods(start, end, thick, thick * 0.4, _BARK, sides=5 if order == 0 else 3))
        tips = np.concatenate([tips, end]) if order else end
    places = np.repeat(tips, 5, axis=0)
    places = places + rng.normal(0.0, height_m * 0.042, places.shape)
    green = Paint(*_GREENS[rng.integers(len(_GREENS))], Layer.LEAF, Matter.LEAF)
    return Mesh.joined([*wood, leaves(places, leaf_m, green, rng)])


def _branches(
    rng: np.random.Generator, start: Points, end: Points, children: int, length_m: float
) -> tuple[Points, Points]:
    """``children`` branches a parent, from along its outer part, bent away from it and a little upwards."""
    parent = np.repeat(np.arange(len(start)), children)
    along = rng.uniform(0.25, 1.0, (len(parent), 1))
    root = start[parent] + along * (end - start)[parent]
    direction = (end - start)[parent]
    direction = direction / np.linalg.norm(direction, axis=1, keepdims=True)
    sideways = rng.normal(size=(len(parent), 3))
    sideways -= (sideways * direction).sum(1, keepdims=True) * direction
    sideways /= np.linalg.norm(sideways, axis=1, keepdims=True)
    heading = 0.55 * direction + sideways + (0.0, 0.0, 0.22)
    heading /= np.linalg.norm(heading, axis=1, keepdims=True)
    return root, root + heading * length_m * rng.uniform(0.6, 1.1, (len(parent), 1)) * (1.15 - 0.45 * along)


def conifer(rng: np.random.Generator, height_m: float) -> Mesh:
    """A spruce: tiers of drooping fans of needles around a straight trunk."""
    width = height_m * rng.uniform(0.24, 0.34)
    needles = Paint(0.035, 0.10 + 0.03 * rng.random(), 0.065, Layer.LEAF, Matter.NEEDLE)
    tiers = int(9 + height_m * 2.2)
    level = np.repeat(np.linspace(0.08, 0.98, tiers), 18)
    turn = rng.uniform(0.0, 2.0 * np.pi, len(level))
    reach = width * (1.06 - level) * rng.uniform(0.75, 1.1, len(level))
    out = np.stack([np.cos(turn), np.sin(turn), np.zeros_like(turn)], 1)
    side = np.stack([-np.sin(turn), np.cos(turn), np.zeros_like(turn)], 1)
    root = np.stack([0 * level, 0 * level, level * height_m], 1)
    droop = np.array([0.0, 0.0, -0.38])
    middle = root + (out + droop * 0.7) * (reach * 0.62)[:, None]
    broad = side * (reach * rng.uniform(0.26, 0.44, len(level)))[:, None]
    tip = root + (out + droop) * reach[:, None]
    fans = _fans(np.stack([root, middle - broad, tip, middle + broad], 1), needles, rng)
    trunk = rods([[0, 0, 0]], [[0, 0, height_m * 0.9]], height_m * 0.02, 0.01, _BARK, sides=6)
    return Mesh.joined([trunk, fans])


def _fans(corners: Points, paint: Paint, rng: np.random.Generator) -> Mesh:
    """Kites split along their middle, each half with a shade of its own."""
    split = corners[:, [[0, 1, 2], [0, 2, 3]]].reshape(-1, 3, 3)
    mesh = Mesh.of(split, split[..., :2], paint, np.repeat(rng.random(len(corners)), 2))
    return mesh.tinted(rng.uniform(0.65, 1.3, (len(split), 1)))


def bush(rng: np.random.Generator, size_m: float, *, flowering: bool) -> Mesh:
    """A round deciduous bush with a few stems."""
    count = int(150 + 130 * size_m)
    direction = rng.normal(size=(count, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    shell = direction * rng.uniform(0.55, 1.0, (count, 1)) ** 0.5 * size_m * (0.5, 0.5, 0.42)
    centres = shell + np.array([0.0, 0.0, size_m * 0.45])
    green = Paint(*_GREENS[rng.integers(len(_GREENS))], Layer.LEAF, Matter.LEAF)
    stems = rods(np.zeros((14, 3)), centres[:14] * (0.9, 0.9, 1.0), 0.02, 0.006, _BARK, sides=3)
    parts = [stems, leaves(centres, 0.20, green, rng, shell)]
    if flowering:
        parts.append(_blossoms(rng, centres[: count // 3] * 1.03, shell[: count // 3], 0.11))
    return Mesh.joined(parts)


def _blossoms(rng: np.random.Generator, centres: Points, outward: Points, size_m: float) -> Mesh:
    paint = Paint(*_BLOSSOMS[rng.integers(len(_BLOSSOMS))], Layer.SMOOTH, Matter.BLOSSOM)
    return leaves(centres, size_m, paint, rng, outward)


def hedge(rng: np.random.Generator, length_m: float, height_m: float, depth_m: float, cards_per_m2: float) -> Mesh:
    """An evergreen hedge along x, centred: a dark core covered by leaves."""
    half = np.array([length_m / 2.0, depth_m / 2.0])
    core = box(
        (-half[0], -half[1], 0.0), (half[0], half[1], height_m), Paint(0.02, 0.045, 0.018, Layer.LEAF, Matter.NEEDLE)
    )
    areas = np.array(
        [length_m * height_m, length_m * height_m, length_m * depth_m, depth_m * height_m, depth_m * height_m]
    )
    counts = np.maximum((areas * cards_per_m2).astype(int), 4)
    normals = np.array([[0, -1, 0], [0, 1, 0], [0, 0, 1], [-1, 0, 0], [1, 0, 0]], np.float64)
    outward = np.repeat(normals, counts, axis=0)
    spot = rng.uniform(-1.0, 1.0, (len(outward), 3))
    spot = np.where(outward != 0.0, outward, spot) * (half[0], half[1], height_m / 2.0)
    spot += outward * rng.uniform(-0.02, 0.05, (len(outward), 1)) + (0.0, 0.0, height_m / 2.0)
    green = Paint(0.045, 0.125 + 0.05 * rng.random(), 0.035, Layer.LEAF, Matter.NEEDLE)
    return Mesh.joined(
        [core, leaves(spot, 1.35 / np.sqrt(cards_per_m2), green, rng, outward + np.array([0.0, 0.0, 0.4]))]
    )


def pot(rng: np.random.Generator) -> Mesh:
    """A clay pot with a flowering plant."""
    height = rng.uniform(0.35, 0.6)
    width = height * rng.uniform(0.38, 0.5)
    wall = rods(
        [(0.0, 0.0, 0.0), (0.0, 0.0, height * 0.85)],
        [(0.0, 0.0, height * 0.85), (0.0, 0.0, height)],
        [width * 0.7, width * 1.1],
        [width, width * 1.1],
        _CLAY,
        sides=12,
    )
    soil = ellipsoid((0, 0, height * 0.88), (width, width, 0.02), Paint(0.06, 0.04, 0.03))
    direction = rng.normal(size=(170, 3))
    direction /= np.linalg.norm(direction, axis=1, keepdims=True)
    crown = np.array([0.0, 0.0, height + width * 0.9])
    green = Paint(*_GREENS[rng.integers(len(_GREENS))], Layer.LEAF, Matter.NEEDLE)
    foliage = leaves(crown + direction * width * 1.15, 0.15, green, rng, direction)
    flowers = _blossoms(rng, crown + direction[::2] * width * 1.3, direction[::2], 0.12)
    return Mesh.joined([wall, soil, foliage, flowers])
