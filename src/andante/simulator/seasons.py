"""Dresses a scene for a season: which leaves are there, in which colour, and where snow lies.

Nothing here is random: every triangle carries the rank that decides about it.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from andante.simulator.conditions import Season
from andante.simulator.garden import Scene
from andante.simulator.mesh import FloatArray32, Layer, Matter, Mesh, f32

_SNOW = f32([0.80, 0.83, 0.88])
_FACES_UP = 0.55


@dataclass(frozen=True, slots=True)
class Wardrobe:
    """What a season wears: shares of leaves and blossoms, tints of leaves and grass, how much turned leaves differ."""

    leaf_share: float
    leaf_tint: tuple[float, float, float]
    autumn_share: float
    blossom_share: float
    grass_tint: tuple[float, float, float]
    snow: bool
    sun_height_m: float


SEASONS: Mapping[Season, Wardrobe] = {
    "spring": Wardrobe(0.55, (1.45, 1.45, 1.2), 0.0, 1.0, (1.05, 1.15, 0.95), False, 9.0),
    "summer": Wardrobe(1.0, (1.0, 1.0, 1.0), 0.0, 0.8, (1.0, 1.0, 1.0), False, 14.0),
    "autumn": Wardrobe(0.72, (1.0, 1.0, 1.0), 1.0, 0.0, (1.5, 0.98, 0.85), False, 8.0),
    "winter": Wardrobe(0.0, (1.0, 1.0, 1.0), 0.0, 0.0, (1.0, 1.0, 1.0), True, 4.5),
}


def dressed(scene: Scene, season: Season) -> Scene:
    """The scene in a season: fewer triangles where leaves are gone, other colours, snow on what faces up."""
    wear = SEASONS[season]
    mesh = scene.mesh
    there = _present(mesh, wear)
    mesh = replace(mesh, colour=_coloured(mesh, wear))
    if wear.snow:
        mesh = _snowed(mesh)
    return replace(scene, mesh=mesh.kept(there), object_id=scene.object_id[there])


def _present(mesh: Mesh, wear: Wardrobe) -> NDArray[np.bool_]:
    there = np.ones(len(mesh), np.bool_)
    for matter, share in ((Matter.LEAF, wear.leaf_share), (Matter.BLOSSOM, wear.blossom_share)):
        there &= (mesh.matter != matter) | (mesh.rank < share)
    return there


def _coloured(mesh: Mesh, wear: Wardrobe) -> FloatArray32:
    colour = mesh.colour.copy()
    leaf = mesh.matter == Matter.LEAF
    colour[leaf] *= f32(wear.leaf_tint)
    if wear.autumn_share:
        # From yellow over orange to brown, by rank; the green below keeps trees apart.
        rank = mesh.rank[leaf][:, None]
        turned = f32([0.46, 0.27, 0.04]) * (1.0 - rank) + f32([0.30, 0.085, 0.02]) * rank
        shade = colour[leaf].sum(1, keepdims=True) / np.float32(0.36)
        colour[leaf] = turned * shade
    grass = (mesh.matter == Matter.GROUND) & (mesh.layer == Layer.GRASS)
    colour[grass] *= f32(wear.grass_tint)
    return np.clip(colour, 0.0, 1.0)


def _snowed(mesh: Mesh) -> Mesh:
    up = np.abs(mesh.normals()[:, 2])
    matter = mesh.matter
    covered = (
        (matter == Matter.GROUND)
        | ((matter == Matter.ROOF) & (up > 0.3))
        | ((matter == Matter.PLAIN) & (up > _FACES_UP))
    )
    covered |= (matter == Matter.NEEDLE) & (up > 0.25) & (mesh.rank < 0.65)
    colour, layer = mesh.colour.copy(), mesh.layer.copy()
    colour[covered] = _SNOW
    layer[covered & (matter == Matter.GROUND)] = Layer.PLASTER
    layer[covered & (matter != Matter.GROUND)] = Layer.SMOOTH
    return replace(mesh, colour=colour, layer=layer)
