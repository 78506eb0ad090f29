"""Pictures of a scene: one ray a pixel, one shadow ray, baked sky light, more rays where objects end."""

from __future__ import annotations

from dataclasses import dataclass

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.data import ImageArray, Pose2D
from andante.simulator.ambient import baked_openness
from andante.simulator.camera import SimulatedCamera, pixel_rays
from andante.simulator.conditions import Conditions
from andante.simulator.garden import NO_OBJECT, Scene
from andante.simulator.light import Light, Sky, light_at
from andante.simulator.mesh import LEAFY, FloatArray32, Mesh, f32
from andante.simulator.raycaster import NO_FACE, Hits, RayCaster
from andante.simulator.seasons import dressed
from andante.simulator.sensor import developed
from andante.simulator.textures import texture_atlas

_OVERSAMPLING = 2
_SUB_RAYS = [0, 3]  # two opposite quarters of a pixel, besides its centre
_CONTRAST = 0.12
_SKY_STRIDE = 2
_SKY_MARGIN_PX = 5
_LIFT_M = 0.004
_THROUGH_LEAF = 0.45
_HAZE_M = 700.0
_BOUNCE = f32([0.16, 0.17, 0.12])


@dataclass(frozen=True, slots=True)
class Rendering:
    """A picture BGR (height, width, 3) uint8, object ids (height, width), range (height, width) metres, inf for sky."""

    image: ImageArray
    object_id: NDArray[np.int32]
    range_m: FloatArray32


class Renderer:
    """Renders one scene under one set of conditions; safe to call from many threads, faster from many processes.

    ``seed`` decides about clouds and sensor noise, the latter for every frame anew. Raises ``MissingExtraError``
    without embreex.
    """

    def __init__(self, scene: Scene, conditions: Conditions, camera: SimulatedCamera, seed: int = 0) -> None:
        self.camera, self.conditions, self.seed = camera, conditions, seed
        self.scene = dressed(scene, conditions.season)
        self._caster = RayCaster(self.scene.mesh.corners)
        self._surfaces = _packed(self.scene.mesh, baked_openness(self.scene.mesh, self._caster))
        self._sky = Sky(conditions, np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(10,))))
        whole = pixel_rays(camera)
        self._valid = whole.valid
        self._directions = np.ascontiguousarray(whole.directions[whole.valid])
        self._pixel_rad = float(np.sqrt(2.0 * np.pi / max(whole.valid.sum(), 1)))
        if camera.antialias:
            parts = pixel_rays(camera, _OVERSAMPLING).directions
            height, width = self._valid.shape
            split = parts.reshape(height, _OVERSAMPLING, width, _OVERSAMPLING, 3).transpose(0, 2, 1, 3, 4)
            self._sub_directions = np.ascontiguousarray(split.reshape(height, width, -1, 3)[self._valid][:, _SUB_RAYS])

    def render(self, pose: Pose2D, index: int = 0, share: float = 0.0) -> Rendering:
        """The view from ``pose``; ``index`` chooses the sensor noise, ``share`` (0..1) the moment of drifting light."""
        light = light_at(self.conditions, share)
        directions = _turned(self._directions, pose.heading_rad or 0.0)
        hits = self._first_hits(pose, directions)
        colours = self._shaded(pose, directions, hits, light)
        ids = np.full(self._valid.shape, NO_OBJECT, np.int32)
        ids[self._valid] = self._ids(hits.face)
        if self.camera.antialias:
            self._smooth_edges(colours, ids, pose, light)
        range_m = np.full(self._valid.shape, np.inf, np.float32)
        range_m[self._valid] = hits.distance_m
        image = np.zeros((*self._valid.shape, 3), np.uint8)
        rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(11, index)))
        image[self._valid] = developed(colours, self.conditions.exposure, self.conditions.noise, rng)
        return Rendering(image, ids, range_m)

    def _first_hits(self, pose: Pose2D, directions: FloatArray32) -> Hits:
        """What every pixel sees; open sky is found on every second row and column and taken for granted between."""
        coarse = np.zeros(self._valid.shape, np.bool_)
        coarse[::_SKY_STRIDE, ::_SKY_STRIDE] = True
        first = np.flatnonzero(coarse[self._valid])
        hits = Hits.nothing(len(directions))
        hits.fill(first, self._cast(pose, directions[first]))
        struck = np.zeros(self._valid.shape, np.uint8)
        struck[self._valid] = hits.face != NO_FACE
        near = cv2.dilate(struck, np.ones((_SKY_MARGIN_PX, _SKY_MARGIN_PX), np.uint8)).astype(np.bool_)
        rest = np.flatnonzero((near & ~coarse)[self._valid])
        hits.fill(rest, self._cast(pose, directions[rest]))
        return hits

    def _cast(self, pose: Pose2D, directions: FloatArray32) -> Hits:
        eye = f32([pose.x_m, pose.y_m, self.camera.mount_height_m])
        return self._caster.first_hits(np.broadcast_to(eye, directions.shape), directions)

    def _ids(self, face: NDArray[np.int32]) -> NDArray[np.int32]:
        return np.where(face == NO_FACE, NO_OBJECT, self.scene.object_id[face]).astype(np.int32)

    def _smooth_edges(self, colours: FloatArray32, ids: NDArray[np.int32], pose: Pose2D, light: Light) -> None:
        """Average several rays in the pixels where one object ends before another of visibly different colour."""
        grey = np.zeros(ids.shape, np.float32)
        grey[self._valid] = np.sqrt(np.minimum(colours[:, 1], 1.0))
        edge = np.zeros(ids.shape, np.bool_)
        across = (ids[:, 1:] != ids[:, :-1]) & (np.abs(grey[:, 1:] - grey[:, :-1]) > _CONTRAST)
        down = (ids[1:] != ids[:-1]) & (np.abs(grey[1:] - grey[:-1]) > _CONTRAST)
        edge[:, 1:] |= across
        edge[:, :-1] |= across
        edge[1:] |= down
        edge[:-1] |= down
        chosen = np.flatnonzero(edge[self._valid])
        directions = _turned(self._sub_directions[chosen].reshape(-1, 3), pose.heading_rad or 0.0)
        fine = np.minimum(self._shaded(pose, directions, self._cast(pose, directions), light), 1.6)
        total = np.minimum(colours[chosen], 1.6) + fine.reshape(-1, len(_SUB_RAYS), 3).sum(axis=1)
        colours[chosen] = total / np.float32(len(_SUB_RAYS) + 1)

    def _shaded(self, pose: Pose2D, directions: FloatArray32, hits: Hits, light: Light) -> FloatArray32:
        """Linear RGB (k, 3) along the rays."""
        colours = np.empty_like(directions)
        sky = np.flatnonzero(hits.face == NO_FACE)
        colours[sky] = self._sky.look(directions.take(sky, axis=0)) * np.float32(light.brightness)
        struck = np.flatnonzero(hits.face != NO_FACE)
        colours[struck] = self._surface(pose, directions.take(struck, axis=0), hits.taken(struck), light)
        return colours

    def _surface(self, pose: Pose2D, ways: FloatArray32, hits: Hits, light: Light) -> FloatArray32:
        """Linear RGB (k, 3) of what the rays ``ways`` (k, 3) hit."""
        surface = self._surfaces.take(hits.face, axis=0)
        v, w = hits.u[:, None], hits.v[:, None]
        first, second, third = surface[:, 0:3], surface[:, 3:6], surface[:, 6:9]
        mixed = first + (second - first) * v + (third - first) * w  # u, v and openness inside of the triangle
        normal = surface[:, 9:12]
        normal = normal * np.where(_dot(normal, ways) > 0.0, np.float32(-1.0), np.float32(1.0))[:, None]
        distance = hits.distance_m
        layer = surface[:, 15].astype(np.int32)
        texture = texture_atlas().sample(layer, mixed[:, :2], distance * np.float32(self._pixel_rad))
        eye = f32([pose.x_m, pose.y_m, self.camera.mount_height_m])
        sunlit = self._sunlit(eye + ways * distance[:, None], normal, surface[:, 16] > 0.0, light)
        openness, up = mixed[:, 2], normal[:, 2] * np.float32(0.5) + np.float32(0.5)
        from_sky = openness * (np.float32(0.35) + np.float32(0.65) * up)
        bounced = (1.0 - up) * (np.float32(0.3) + np.float32(0.7) * openness)
        sources = np.stack([sunlit, from_sky, bounced], axis=1)
        lit = surface[:, 12:15] * texture * (sources @ np.stack([light.sun, light.sky, light.sun * _BOUNCE]))
        haze = np.float32(1.0) - np.exp(distance * np.float32(-1.0 / _HAZE_M))[:, None]
        return np.asarray(lit + (self._sky.horizon * np.float32(light.brightness) - lit) * haze, np.float32)

    def _sunlit(self, point: FloatArray32, normal: FloatArray32, card: NDArray[np.bool_], light: Light) -> FloatArray32:
        """(k,) how squarely and whether the sun shines there; leaves let some light through from behind."""
        slant = _dot(normal, light.to_sun)
        slant = np.where(card & (slant < 0.0), slant * np.float32(-_THROUGH_LEAF), np.maximum(slant, 0.0))
        towards = np.flatnonzero(slant > 0.0)
        origin = point[towards] + (light.to_sun + normal[towards]) * np.float32(_LIFT_M)
        slant[towards[self._caster.occluded(origin, light.to_sun)]] = 0.0
        return np.asarray(slant, np.float32)


def _packed(mesh: Mesh, openness: FloatArray32) -> FloatArray32:
    """All that shading asks of a triangle in one row (n, 17), because fetching rows is what costs time.

    Three times (u, v, openness), normal, colour, layer, whether it is a leaf.
    """
    corners = np.concatenate([mesh.uv, openness[:, :, None]], axis=2).reshape(-1, 9)
    leaf = np.isin(mesh.matter, LEAFY)
    return np.concatenate(
        [corners, mesh.normals(), mesh.colour, mesh.layer[:, None], leaf[:, None]], axis=1, dtype=np.float32
    )


def _dot(first: FloatArray32, second: FloatArray32) -> FloatArray32:
    """Row-wise products (k,) of (k, 3) with (k, 3) or (3,)."""
    total = first[:, 0] * second[..., 0] + first[:, 1] * second[..., 1] + first[:, 2] * second[..., 2]
    return np.asarray(total, np.float32)


def _turned(directions: FloatArray32, heading_rad: float) -> FloatArray32:
    """Directions of the robot's frame in that of the map."""
    cos, sin = np.float32(np.cos(heading_rad)), np.float32(np.sin(heading_rad))
    turned = np.empty_like(directions)
    turned[:, 0] = cos * directions[:, 0] - sin * directions[:, 1]
    turned[:, 1] = sin * directions[:, 0] + cos * directions[:, 1]
    turned[:, 2] = directions[:, 2]
    return turned
