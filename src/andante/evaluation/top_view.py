"""A garden seen from straight above, as a background for maps."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from andante.data import ImageArray
from andante.simulator import Scene
from andante.simulator.raycaster import NO_FACE, RayCaster

_HEIGHT_M = 100.0
_LIGHT = np.array([0.35, 0.25, 0.9]) / np.linalg.norm([0.35, 0.25, 0.9])
_GAMMA = 1 / 2.2


@dataclass(frozen=True, slots=True)
class TopView:
    """A picture RGB (height, width, 3), x to the right, y up, and its extent left, right, bottom, top in metres."""

    image: ImageArray
    extent_m: tuple[float, float, float, float]


def top_view(scene: Scene, width_m: float, depth_m: float, *, pixels_per_m: float = 30.0) -> TopView:
    """The rectangle around the origin, without perspective; raises ``MissingExtraError`` without embreex."""
    x = np.arange(-width_m / 2, width_m / 2, 1 / pixels_per_m) + 0.5 / pixels_per_m
    y = np.arange(depth_m / 2, -depth_m / 2, -1 / pixels_per_m) - 0.5 / pixels_per_m
    across, down = np.meshgrid(x, y)
    origins = np.stack([across, down, np.full_like(across, _HEIGHT_M)], axis=-1).reshape(-1, 3).astype(np.float32)
    directions = np.broadcast_to(np.array([0.0, 0.0, -1.0], np.float32), origins.shape)
    face = RayCaster(scene.mesh.corners).first_hits(origins, directions).face
    normal = scene.mesh.normals()[face]
    lit = 0.45 + 0.55 * np.abs(normal @ _LIGHT)
    colour = np.where((face == NO_FACE)[:, None], 1.0, scene.mesh.colour[face] * lit[:, None])
    image = (255 * np.clip(1.6 * colour, 0.0, 1.0) ** _GAMMA).astype(np.uint8)
    return TopView(image.reshape(len(y), len(x), 3), (-width_m / 2, width_m / 2, -depth_m / 2, depth_m / 2))
