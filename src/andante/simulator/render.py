"""Pictures of a scene: one ray a pixel, one shadow ray, baked sky light, more rays where objects end."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeVar

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.data import ImageArray, Pose2D
from andante.simulator.ambient import baked_openness, baked_sunlight
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
_CONTRAST = 0.12
_WHITE = np.float32(1.6)  # brighter light counts as this in an average, or one ray at the sun would outshine all
_SKY_STRIDE = 2
_SKY_MARGIN_PX = 5
_LIFT_M = 0.004
_THROUGH_LEAF = 0.45
_HAZE_M = 700.0
_BOUNCE = f32([0.16, 0.17, 0.12])


Scalar = TypeVar("Scalar", bound=np.generic)


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
        self._surfaces = _packed(self.scene.mesh, baked_openness(self.scene.mesh, self._caster), self._sunlight())
        self._sky = Sky(conditions, np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(10,))))
        whole = pixel_rays(camera)
        self._valid = whole.valid
        self._directions = np.ascontiguousarray(whole.directions[whole.valid])
        self._pixel_rad = float(np.sqrt(2.0 * np.pi / max(whole.valid.sum(), 1)))
        self._pixels = np.flatnonzero(whole.valid)
        rows, columns = np.divmod(self._pixels, camera.width_px)
        self._coarse = (rows % _SKY_STRIDE == 0) & (columns % _SKY_STRIDE == 0)
        if camera.antialias:
            parts = pixel_rays(camera, _OVERSAMPLING).directions
            # Which quarter of a pixel is looked at besides its centre changes from pixel to pixel: none is favoured.
            self._aside = parts[2 * rows + columns % 2, 2 * columns + (rows + columns) % 2]

    def render(self, pose: Pose2D, index: int = 0, share: float = 0.0) -> Rendering:
        """The view from ``pose``; ``index`` chooses the sensor noise, ``share`` (0..1) the moment of drifting light."""
        light = light_at(self.conditions, share)
        directions = _turned(self._directions, pose.heading_rad or 0.0)
        hits = self._first_hits(pose, directions)
        colours = self._shaded(pose, directions, hits, light)
        ids = self._picture(self._ids(hits.face), NO_OBJECT)
        if self.camera.antialias:
            self._smooth_edges(colours, ids, pose, light)
        rng = np.random.default_rng(np.random.SeedSequence(self.seed, spawn_key=(11, index)))
        image = self._picture(developed(colours, self.conditions.exposure, self.conditions.noise, rng), 0)
        return Rendering(image, ids, self._picture(hits.distance_m, np.inf))

    def _sunlight(self) -> FloatArray32:
        """What is known of sun and shade (n,) before any picture; NaN where it takes a ray of its own."""
        if self.conditions.drift_hours:
            return np.full(len(self.scene.mesh), np.nan, np.float32)
        return baked_sunlight(self.scene.mesh, self._caster, light_at(self.conditions, 0.0).to_sun)

    def _picture(self, values: NDArray[Scalar], outside: float) -> NDArray[Scalar]:
        """Values (k, ...) of the pixels that show anything -> (height, width, ...)."""
        picture = np.full((self._valid.size, *values.shape[1:]), outside, values.dtype)
        picture[self._pixels] = values
        return picture.reshape(*self._valid.shape, *values.shape[1:])

    def _first_hits(self, pose: Pose2D, directions: FloatArray32) -> Hits:
        """What every pixel sees; open sky is found on every second row and column and taken for granted between."""
        first = np.flatnonzero(self._coarse)
        hits = Hits.nothing(len(directions))
        hits.fill(first, self._cast(pose, directions.take(first, axis=0)))
        struck = self._picture((hits.face != NO_FACE).astype(np.uint8), 0)
        near = cv2.dilate(struck, np.ones((_SKY_MARGIN_PX, _SKY_MARGIN_PX), np.uint8)).reshape(-1)[self._pixels]
        rest = np.flatnonzero((near > 0) & ~self._coarse)
        hits.fill(rest, self._cast(pose, directions.take(rest, axis=0)))
        return hits

    def _cast(self, pose: Pose2D, directions: FloatArray32) -> Hits:
        eye = f32([pose.x_m, pose.y_m, self.camera.mount_height_m])
        return self._caster.first_hits(np.broadcast_to(eye, directions.shape), directions)

    def _ids(self, face: NDArray[np.int32]) -> NDArray[np.int32]:
        return np.where(face == NO_FACE, NO_OBJECT, self.scene.object_id[face]).astype(np.int32)

    def _smooth_edges(self, colours: FloatArray32, ids: NDArray[np.int32], pose: Pose2D, light: Light) -> None:
        """Average two rays in the pixels where one object ends before another of visibly different colour."""
        grey = self._picture(np.sqrt(np.minimum(colours[:, 1], 1.0)), 0.0)
        chosen = np.flatnonzero(_edges(ids, grey).reshape(-1)[self._pixels])
        directions = _turned(self._aside.take(chosen, axis=0), pose.heading_rad or 0.0)
        aside = self._shaded(pose, directions, self._cast(pose, directions), light)
        colours[chosen] = (np.minimum(colours[chosen], _WHITE) + np.minimum(aside, _WHITE)) / np.float32(2.0)

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
        sunlit = self._sunlit(eye + ways * distance[:, None], normal, surface, light)
        openness, up = mixed[:, 2], normal[:, 2] * np.float32(0.5) + np.float32(0.5)
        from_sky = openness * (np.float32(0.35) + np.float32(0.65) * up)
        bounced = (1.0 - up) * (np.float32(0.3) + np.float32(0.7) * openness)
        sources = np.stack([sunlit, from_sky, bounced], axis=1)
        lit = surface[:, 12:15] * texture * (sources @ np.stack([light.sun, light.sky, light.sun * _BOUNCE]))
        haze = np.float32(1.0) - np.exp(distance * np.float32(-1.0 / _HAZE_M))[:, None]
        return np.asarray(lit + (self._sky.horizon * np.float32(light.brightness) - lit) * haze, np.float32)

    def _sunlit(self, point: FloatArray32, normal: FloatArray32, surface: FloatArray32, light: Light) -> FloatArray32:
        """(k,) how squarely and whether the sun shines there; leaves let some light through from behind."""
        leaf, sunlight = surface[:, 16] > 0.0, surface[:, 17]
        slant = _dot(normal, light.to_sun)
        slant = np.where(leaf & (slant < 0.0), slant * np.float32(-_THROUGH_LEAF), np.maximum(slant, 0.0))
        unknown = np.isnan(sunlight)
        slant *= np.where(unknown, np.float32(1.0), sunlight)
        asked = np.flatnonzero(unknown & (slant > 0.0))
        origin = point[asked] + (light.to_sun + normal[asked]) * np.float32(_LIFT_M)
        slant[asked[self._caster.occluded(origin, light.to_sun)]] = 0.0
        return np.asarray(slant, np.float32)


def _edges(ids: NDArray[np.int32], grey: FloatArray32) -> NDArray[np.bool_]:
    """Pixels (height, width) on either side of a border between objects that can be seen as such."""
    across = (ids[:, 1:] != ids[:, :-1]) & (np.abs(grey[:, 1:] - grey[:, :-1]) > _CONTRAST)
    down = (ids[1:] != ids[:-1]) & (np.abs(grey[1:] - grey[:-1]) > _CONTRAST)
    edge = np.zeros(ids.shape, np.bool_)
    edge[:, 1:] |= across
    edge[:, :-1] |= across
    edge[1:] |= down
    edge[:-1] |= down
    return edge


def _packed(mesh: Mesh, openness: FloatArray32, sunlight: FloatArray32) -> FloatArray32:
    """All that shading asks of a triangle in one row (n, 18), because fetching rows is what costs time.

    Three times (u, v, openness), normal, colour, layer, whether it is a leaf, sunlight or NaN.
    """
    corners = np.concatenate([mesh.uv, openness[:, :, None]], axis=2).reshape(-1, 9)
    leaf = np.isin(mesh.matter, LEAFY)
    return np.concatenate(
        [corners, mesh.normals(), mesh.colour, mesh.layer[:, None], leaf[:, None], sunlight[:, None]],
        axis=1,
        dtype=np.float32,
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
