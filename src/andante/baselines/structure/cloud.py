"""The points that a query is matched with, in the frame of the map."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Self

import numpy as np
from numpy.typing import NDArray

from andante.baselines.structure.alignment import Similarity
from andante.baselines.structure.keypoints import Keypoints
from andante.data import FloatArray, ImageArray

if TYPE_CHECKING:
    import pycolmap


@dataclass(frozen=True, slots=True, eq=False)
class Cloud:
    """Points ``xyz`` (m, 3) float32 in metres and the mean ``descriptors`` (m, 128) uint8 of what was seen of each.

    ``image`` and ``point`` (s,) int32 list which mapped image saw which point.
    """

    xyz: NDArray[np.float32]
    descriptors: ImageArray
    image: NDArray[np.int32]
    point: NDArray[np.int32]

    def __len__(self) -> int:
        return len(self.xyz)

    @property
    def nbytes(self) -> int:
        """What has to be kept."""
        return sum(array.nbytes for array in (self.xyz, self.descriptors, self.image, self.point))

    @classmethod
    def of(cls, model: pycolmap.Reconstruction, keypoints: Sequence[Keypoints], similarity: Similarity) -> Self:
        """The points of a ``pycolmap.Reconstruction``, whose image n has the key points n - 1."""
        xyz, descriptors, image, point = [], [], [], []
        for number, one in enumerate(model.points3D.values()):
            seen = [(element.image_id - 1, element.point2D_idx) for element in one.track.elements]
            xyz.append(one.xyz)
            descriptors.append(_mean(np.stack([keypoints[i].descriptors[k] for i, k in seen])))
            image += [i for i, _ in seen]
            point += [number] * len(seen)
        places = np.array(xyz, np.float64).reshape(-1, 3)
        return cls(
            similarity.points(places).astype(np.float32),
            np.array(descriptors, np.uint8).reshape(-1, 128),
            np.array(image, np.int32),
            np.array(point, np.int32),
        )

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """All points of parts in one frame; none of no parts."""
        if not parts:
            return cls(*_NOTHING)
        offsets = np.cumsum([0, *(len(part) for part in parts)])
        return cls(
            np.concatenate([part.xyz for part in parts]),
            np.concatenate([part.descriptors for part in parts]),
            np.concatenate([part.image for part in parts]),
            np.concatenate([part.point + np.int32(at) for part, at in zip(parts, offsets, strict=False)]),
        )


_NOTHING = (
    np.empty((0, 3), np.float32),
    np.empty((0, 128), np.uint8),
    np.empty(0, np.int32),
    np.empty(0, np.int32),
)


def _mean(descriptors: ImageArray) -> FloatArray:
    """The mean (128,) of (k, 128) with their common norm of 512."""
    mean: FloatArray = descriptors.astype(np.float64).mean(axis=0)
    scaled: FloatArray = np.round(mean * 512.0 / np.maximum(np.linalg.norm(mean), 1.0))
    return np.clip(scaled, 0.0, 255.0)
