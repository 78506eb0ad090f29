"""The only module that knows which library traces rays; another backend would stand beside it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.errors import MissingExtraError
from andante.simulator.mesh import FloatArray32, f32

NO_FACE = -1


@dataclass(frozen=True, slots=True)
class Hits:
    """What k rays meet first: face (k,) or ``NO_FACE``, distance (k,) metres or inf, barycentric u and v (k,)."""

    face: NDArray[np.int32]
    distance_m: FloatArray32
    u: FloatArray32
    v: FloatArray32

    @classmethod
    def nothing(cls, count: int) -> Hits:
        """Rays that meet nothing, to be filled in."""
        zero = np.zeros(count, np.float32)
        return cls(np.full(count, NO_FACE, np.int32), np.full(count, np.inf, np.float32), zero, zero.copy())

    def taken(self, index: NDArray[np.intp]) -> Hits:
        """Only the rays ``index`` (m,)."""
        return Hits(self.face[index], self.distance_m[index], self.u[index], self.v[index])

    def fill(self, index: NDArray[np.intp], part: Hits) -> None:
        """Write what the rays ``index`` (m,) met."""
        self.face[index], self.distance_m[index] = part.face, part.distance_m
        self.u[index], self.v[index] = part.u, part.v


class RayCaster:
    """Rays against a fixed soup of triangles (n, 3, 3); holds the GIL, so many cores need many processes.

    Raises ``MissingExtraError`` without embreex.
    """

    def __init__(self, corners_m: FloatArray32) -> None:
        try:
            from embreex.mesh_construction import TriangleMesh
            from embreex.rtcore_scene import EmbreeScene
        except ImportError:
            raise MissingExtraError("embreex", "sim") from None
        self._scene = EmbreeScene()
        self._mesh = TriangleMesh(self._scene, np.ascontiguousarray(corners_m, np.float32))
        up = f32([[0.0, 0.0, 1.0]])
        self.first_hits(up, up)  # the first query builds the tree: here, not in the first of many threads

    def first_hits(self, origins_m: FloatArray32, directions: FloatArray32) -> Hits:
        """Rays from ``origins_m`` (k, 3) along unit ``directions`` (k, 3)."""
        found = self._scene.run(np.ascontiguousarray(origins_m), np.ascontiguousarray(directions), output=1)
        distance = np.where(found["primID"] == NO_FACE, np.float32(np.inf), found["tfar"])
        return Hits(found["primID"], distance, found["u"], found["v"])

    def occluded(self, origins_m: FloatArray32, direction: FloatArray32) -> NDArray[np.bool_]:
        """(k,) whether anything lies along ``direction`` (3,) from ``origins_m`` (k, 3)."""
        answer = self._scene.run(np.ascontiguousarray(origins_m), direction[None], query="OCCLUDED")
        return np.asarray(answer == 0, np.bool_)
