"""How much sky and sun every surface sees: baked once for a dressed scene, because it does not move."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from andante.simulator.mesh import LEAFY, FloatArray32, Mesh, f32
from andante.simulator.raycaster import RayCaster

_DIRECTIONS = 10
_LIFT_M = 0.02
_SUN_LIFT_M = 0.004
_SMALL_M = 0.4


def baked_openness(mesh: Mesh, caster: RayCaster) -> FloatArray32:
    """(n, 3) share of the sky, 0..1, that the corners of each triangle see; one value for leaves and small ones."""
    card = small_triangles(mesh)
    open_ = np.empty((len(mesh), 3), np.float32)
    normals = mesh.normals()
    open_[card] = _openness(mesh.corners[card].mean(axis=1), normals[card], caster)[:, None]
    solid = mesh.corners[~card]
    # A little inside of the triangle, or a corner would be hidden by the wall that it touches.
    points = solid * np.float32(0.94) + solid.mean(axis=1, keepdims=True) * np.float32(0.06)
    open_[~card] = _openness(points.reshape(-1, 3), np.repeat(normals[~card], 3, axis=0), caster).reshape(-1, 3)
    return open_


def baked_sunlight(mesh: Mesh, caster: RayCaster, to_sun: FloatArray32) -> FloatArray32:
    """(n,) 1 for small triangles whose middle the sun reaches, 0 for small ones in the shade, NaN for large ones."""
    sunlight = np.full(len(mesh), np.nan, np.float32)
    small = small_triangles(mesh)
    normals = mesh.normals()[small]
    side = np.where((normals @ to_sun)[:, None] < 0.0, -normals, normals)
    middle = mesh.corners[small].mean(axis=1)
    sunlight[small] = ~caster.occluded(f32(middle + (side + to_sun) * _SUN_LIFT_M), to_sun)
    return sunlight


def small_triangles(mesh: Mesh) -> NDArray[np.bool_]:
    """(n,) leaves and whatever else is so small that one value lights all of it."""
    edges = np.linalg.norm(mesh.corners - np.roll(mesh.corners, 1, axis=1), axis=2)
    return np.asarray(np.isin(mesh.matter, LEAFY) | (edges.max(axis=1) < _SMALL_M), np.bool_)


def _openness(points: FloatArray32, normals: FloatArray32, caster: RayCaster) -> FloatArray32:
    """The share of a cosine-weighted dome that is not hidden; both sides of a surface count."""
    seen, total = np.zeros(len(points), np.float32), np.zeros(len(points), np.float32)
    for direction in _dome():
        weight = f32(np.abs(normals @ direction) + 0.15)
        side = np.where((normals @ direction)[:, None] < 0.0, -normals, normals)
        hidden = caster.occluded(f32(points + side * np.float32(_LIFT_M)), direction)
        seen += np.where(hidden, 0.0, weight)
        total += weight
    return seen / total


def _dome() -> FloatArray32:
    """Directions spread over the upper half sphere, denser towards the zenith (a golden spiral)."""
    step = np.arange(_DIRECTIONS) + 0.5
    up = np.sqrt(1.0 - step / _DIRECTIONS * 0.97)
    turn = step * np.pi * (3.0 - np.sqrt(5.0))
    flat = np.sqrt(1.0 - up**2)
    return f32(np.stack([flat * np.cos(turn), flat * np.sin(turn), up], axis=1))
