"""The solids that all things in a garden are built of; metres, z up, texture coordinates in metres too."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from andante.simulator.mesh import Mesh, Paint

Points = NDArray[np.float64]


def quads(corners: ArrayLike, paint: Paint, rank: ArrayLike = 0.0) -> Mesh:
    """Four-cornered patches (m, 4, 3), each as two triangles; u along the first edge, v along the last.

    ``rank`` (m,) or one for all.
    """
    points = np.asarray(corners, np.float64).reshape(-1, 4, 3)
    along, across = points[:, 1] - points[:, 0], points[:, 3] - points[:, 0]
    width = np.linalg.norm(along, axis=1, keepdims=True)
    direction = along / np.maximum(width, 1e-9)
    # Texture coordinates from projections: a trapezoid (gable, cone) keeps straight rows of bricks.
    offsets = points - points[:, :1]
    u = (offsets * direction[:, None]).sum(-1)
    upright = across - (across * direction).sum(-1, keepdims=True) * direction
    upright /= np.maximum(np.linalg.norm(upright, axis=1, keepdims=True), 1e-9)
    v = (offsets * upright[:, None]).sum(-1)
    uv = np.stack([u, v], axis=-1)
    split = np.array([[0, 1, 2], [0, 2, 3]])
    ranks = np.repeat(np.broadcast_to(np.asarray(rank, np.float64), (len(points),)), 2)
    return Mesh.of(points[:, split].reshape(-1, 3, 3), uv[:, split].reshape(-1, 3, 2), paint, ranks)


def box(low: ArrayLike, high: ArrayLike, paint: Paint) -> Mesh:
    """A box between two corners, without its bottom."""
    (x0, y0, z0), (x1, y1, z1) = np.asarray(low, np.float64), np.asarray(high, np.float64)
    return quads(
        [
            [(x0, y0, z0), (x1, y0, z0), (x1, y0, z1), (x0, y0, z1)],
            [(x1, y0, z0), (x1, y1, z0), (x1, y1, z1), (x1, y0, z1)],
            [(x1, y1, z0), (x0, y1, z0), (x0, y1, z1), (x1, y1, z1)],
            [(x0, y1, z0), (x0, y0, z0), (x0, y0, z1), (x0, y1, z1)],
            [(x0, y0, z1), (x1, y0, z1), (x1, y1, z1), (x0, y1, z1)],
        ],
        paint,
    )


def boxes(centres: ArrayLike, sizes: ArrayLike, paint: Paint) -> Mesh:
    """Many upright boxes: ``centres`` (m, 3) of their bottoms, ``sizes`` (m, 3) or one for all."""
    middle = np.asarray(centres, np.float64).reshape(-1, 3)
    size = np.broadcast_to(np.asarray(sizes, np.float64), middle.shape)
    low, high = middle - size * (0.5, 0.5, 0.0), middle + size * (0.5, 0.5, 1.0)
    return Mesh.joined([box(a, b, paint) for a, b in zip(low, high, strict=True)])


def rods(
    start: ArrayLike, end: ArrayLike, start_radius: ArrayLike, end_radius: ArrayLike, paint: Paint, *, sides: int = 6
) -> Mesh:
    """Straight tapering rods without caps: ``start``, ``end`` (m, 3), radii (m,) or one for all."""
    bottom = np.asarray(start, np.float64).reshape(-1, 3)
    top = np.asarray(end, np.float64).reshape(-1, 3)
    first = np.broadcast_to(np.asarray(start_radius, np.float64), (len(bottom),))
    last = np.broadcast_to(np.asarray(end_radius, np.float64), (len(bottom),))
    right, up = _frame(top - bottom)
    turn = 2.0 * np.pi * np.arange(sides + 1) / sides
    ring = np.cos(turn)[None, :, None] * right[:, None] + np.sin(turn)[None, :, None] * up[:, None]
    low = bottom[:, None] + ring * first[:, None, None]
    high = top[:, None] + ring * last[:, None, None]
    patches = np.stack([low[:, :-1], low[:, 1:], high[:, 1:], high[:, :-1]], axis=2)
    mesh = quads(patches, paint)
    # Continue the texture around the rod instead of starting anew on every side.
    step = (2.0 * np.pi / sides * np.maximum(first, last))[:, None] * np.arange(sides)[None, :]
    mesh.uv[..., 0] += np.repeat(step.reshape(-1), 2)[:, None].astype(np.float32)
    return mesh


def chain(points: ArrayLike, radii: ArrayLike, paint: Paint, sides: int = 6) -> Mesh:
    """A bent rod through ``points`` (m, 3) with ``radii`` (m,) or one for all."""
    path = np.asarray(points, np.float64)
    radius = np.broadcast_to(np.asarray(radii, np.float64), (len(path),))
    return rods(path[:-1], path[1:], radius[:-1], radius[1:], paint, sides=sides)


def ring(
    centre: ArrayLike, normal: ArrayLike, radius: float, thickness: float, paint: Paint, *, sides: int = 16
) -> Mesh:
    """A wheel's rim: a rod bent to a circle."""
    right, up = _frame(np.asarray(normal, np.float64)[None])
    turn = 2.0 * np.pi * np.arange(sides + 1)[:, None] / sides
    return chain(np.asarray(centre) + radius * (np.cos(turn) * right + np.sin(turn) * up), thickness, paint, 5)


def ellipsoid(centre: ArrayLike, radii: ArrayLike, paint: Paint, sides: int = 12) -> Mesh:
    """A sphere with three radii (or one)."""
    latitude = np.linspace(-np.pi / 2.0, np.pi / 2.0, sides // 2 + 1)
    longitude = 2.0 * np.pi * np.arange(sides + 1) / sides
    unit = np.stack(
        [
            np.cos(latitude)[:, None] * np.cos(longitude),
            np.cos(latitude)[:, None] * np.sin(longitude),
            np.broadcast_to(np.sin(latitude)[:, None], (len(latitude), len(longitude))),
        ],
        axis=-1,
    )
    points = np.asarray(centre, np.float64) + unit * np.asarray(radii, np.float64)
    return quads(np.stack([points[:-1, :-1], points[:-1, 1:], points[1:, 1:], points[1:, :-1]], axis=2), paint)


def prism(profile: ArrayLike, low_y: float, high_y: float, paint: Paint) -> Mesh:
    """A convex outline (m, 2) of x and z, counter-clockwise seen from -y, drawn out along y, both ends closed."""
    outline = np.asarray(profile, np.float64)
    front = np.insert(outline, 1, low_y, axis=1)
    back = np.insert(outline, 1, high_y, axis=1)
    around = np.stack([front, np.roll(front, -1, 0), np.roll(back, -1, 0), back], axis=1)
    fan = np.arange(1, len(outline) - 1)
    first = np.zeros_like(fan)
    caps = [
        np.stack([front[first], front[fan], front[fan + 1]], 1),
        np.stack([back[first], back[fan + 1], back[fan]], 1),
    ]
    triangles = np.concatenate(caps)
    return Mesh.joined([quads(around, paint), Mesh.of(triangles, triangles[..., [0, 2]], paint)])


def leaves(
    centres: Points, size_m: ArrayLike, paint: Paint, rng: np.random.Generator, outward: Points | None = None
) -> Mesh:
    """Small bent cards at ``centres`` (m, 3), turned at random, or facing roughly ``outward`` (m, 3).

    Their ranks and shades are random, so that a crown thins out evenly and never looks flat.
    """
    count = len(centres)
    facing = rng.normal(size=(count, 3))
    if outward is not None:
        facing = facing * 0.45 + outward / np.maximum(np.linalg.norm(outward, axis=1, keepdims=True), 1e-9)
    right, up = _frame(facing)
    turn = rng.uniform(0.0, 2.0 * np.pi, (count, 1))
    right, up = np.cos(turn) * right + np.sin(turn) * up, np.cos(turn) * up - np.sin(turn) * right
    half = (np.broadcast_to(np.asarray(size_m, np.float64), (count,)) * rng.uniform(0.35, 0.65, count))[:, None]
    corners = np.stack([-right, -0.55 * up, right, 0.55 * up], axis=1) * half[:, None] + centres[:, None]
    mesh = quads(corners, paint, rng.random(count))
    return mesh.tinted(np.repeat(rng.uniform(0.7, 1.25, (count, 1)), 2, axis=0))


def _frame(direction: Points) -> tuple[Points, Points]:
    """Two unit vectors across each direction (m, 3)."""
    unit = direction / np.maximum(np.linalg.norm(direction, axis=1, keepdims=True), 1e-12)
    helper = np.where(np.abs(unit[:, 2:]) < 0.9, [[0.0, 0.0, 1.0]], [[1.0, 0.0, 0.0]])
    right = np.cross(helper, unit)
    right /= np.linalg.norm(right, axis=1, keepdims=True)
    return right, np.cross(unit, right)
