"""Triangles with everything a renderer asks of them, and nothing that names a renderer."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import IntEnum

import numpy as np
from numpy.typing import ArrayLike, NDArray

FloatArray32 = NDArray[np.float32]


def f32(values: ArrayLike) -> FloatArray32:
    """Single precision, which halves the memory and time of shading."""
    return np.array(values, np.float32)


class Layer(IntEnum):
    """Which tileable texture covers a triangle."""

    SMOOTH = 0
    GRASS = 1
    BRICK = 2
    PLASTER = 3
    TILES = 4
    WOOD = 5
    BARK = 6
    LEAF = 7
    STONE = 8
    GRAVEL = 9


class Matter(IntEnum):
    """What a triangle is made of, as far as the seasons are concerned."""

    PLAIN = 0  # snow lies on it where it faces up
    INDOOR = 1  # keeps its look: glass, things that were put there today
    GROUND = 2
    ROOF = 3
    LEAF = 4  # deciduous: changes colour, falls
    NEEDLE = 5  # evergreen
    BLOSSOM = 6  # spring and summer only


LEAFY = (Matter.LEAF, Matter.NEEDLE, Matter.BLOSSOM)
"""Thin cards that the sun shines through."""


@dataclass(frozen=True, slots=True)
class Paint:
    """How a surface looks: linear albedo (red, green, blue) in 0..1, texture and matter."""

    red: float
    green: float
    blue: float
    layer: Layer = Layer.SMOOTH
    matter: Matter = Matter.PLAIN


@dataclass(frozen=True, slots=True)
class Mesh:
    """A soup of n triangles.

    ``corners`` (n, 3, 3) metres, ``uv`` (n, 3, 2) metres on the surface, ``colour`` (n, 3) linear albedo,
    ``layer`` and ``matter`` (n,) of ``Layer`` and ``Matter``; ``rank`` (n,) in [0, 1) is when a leaf falls and
    whether snow stays on a needle: part of the geometry, so that a season never draws random numbers.
    """

    corners: FloatArray32
    uv: FloatArray32
    colour: FloatArray32
    layer: NDArray[np.uint8]
    matter: NDArray[np.uint8]
    rank: FloatArray32

    def __len__(self) -> int:
        return len(self.corners)

    @classmethod
    def of(cls, corners: ArrayLike, uv: ArrayLike, paint: Paint, rank: ArrayLike = 0.0) -> Mesh:
        """Triangles (n, 3, 3) and their texture coordinates (n, 3, 2) in one paint."""
        corners = np.asarray(corners, np.float32).reshape(-1, 3, 3)
        count = len(corners)
        return cls(
            corners,
            np.asarray(uv, np.float32).reshape(-1, 3, 2),
            np.tile(f32([paint.red, paint.green, paint.blue]), (count, 1)),
            np.full(count, paint.layer, np.uint8),
            np.full(count, paint.matter, np.uint8),
            np.broadcast_to(np.asarray(rank, np.float32), (count,)).copy(),
        )

    @classmethod
    def joined(cls, parts: Iterable[Mesh]) -> Mesh:
        """All triangles of several meshes, in order."""
        meshes = list(parts)
        return cls(
            np.concatenate([mesh.corners for mesh in meshes]),
            np.concatenate([mesh.uv for mesh in meshes]),
            np.concatenate([mesh.colour for mesh in meshes]),
            np.concatenate([mesh.layer for mesh in meshes]),
            np.concatenate([mesh.matter for mesh in meshes]),
            np.concatenate([mesh.rank for mesh in meshes]),
        )

    def placed(self, x_m: float, y_m: float, heading_rad: float = 0.0, scale: float = 1.0) -> Mesh:
        """Scaled, turned about the vertical, then moved."""
        cos, sin = np.cos(heading_rad) * scale, np.sin(heading_rad) * scale
        turn = np.array([[cos, sin, 0.0], [-sin, cos, 0.0], [0.0, 0.0, scale]])
        corners = self.corners.astype(np.float64) @ turn + (x_m, y_m, 0.0)
        return replace(self, corners=corners.astype(np.float32))

    def tinted(self, factors: ArrayLike) -> Mesh:
        """With every triangle's colour multiplied by factors that broadcast to (n, 3)."""
        colour = np.clip(self.colour * np.asarray(factors, np.float32), 0.0, 1.0)
        return replace(self, colour=np.asarray(colour, np.float32))

    def kept(self, mask: NDArray[np.bool_]) -> Mesh:
        """Only the triangles where ``mask`` (n,) is true."""
        return Mesh(
            self.corners[mask], self.uv[mask], self.colour[mask], self.layer[mask], self.matter[mask], self.rank[mask]
        )

    def normals(self) -> FloatArray32:
        """(n, 3) unit normals; zero for a triangle without area."""
        first, second, third = self.corners[:, 0], self.corners[:, 1], self.corners[:, 2]
        normal = np.cross(second - first, third - first)
        length = np.linalg.norm(normal, axis=1, keepdims=True)
        return np.asarray(normal / np.maximum(length, 1e-12), np.float32)
