"""Which mapped point a key point shows: all points vote for pictures, then those of the best pictures compete.

Foliage resembles foliage: over a whole garden the second-best point is nearly as good as the best, and Lowe's test
drops nearly all. Among what a few overlapping pictures saw, it tells right from wrong (as the visibility graph of
Sattler et al. 2012 does).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Self

import numpy as np
from numpy.typing import NDArray

from andante.baselines.structure.cloud import Cloud
from andante.data import ImageArray, IndexArray

Matches = tuple[IndexArray, IndexArray]


@dataclass(frozen=True, slots=True)
class MatchRule:
    """A point is taken where it is nearer than a ratio times the second (Lowe 2004).

    ``vote_ratio`` is that of all points, which decides about the ``images`` whose points compete with ``ratio``.
    """

    images: int = 20
    vote_ratio: float = 0.95
    ratio: float = 0.9


@dataclass(frozen=True, slots=True, eq=False)
class Matcher:
    """Descriptors of the mapped points as unit vectors (m, 128) float32, and who saw them."""

    cloud: Cloud = field(repr=False)
    units: NDArray[np.float32] = field(repr=False)
    rule: MatchRule

    @classmethod
    def of(cls, cloud: Cloud, rule: MatchRule) -> Self:
        """Ready to match."""
        return cls(cloud, _units(cloud.descriptors), rule)

    def match(self, descriptors: ImageArray) -> Matches:
        """Descriptors (k, 128) uint8 -> numbers of key points and of the points (j,) that they show."""
        likeness = _units(descriptors) @ self.units.T
        competing = self._competing(likeness)
        key, column = _distinct(likeness[:, competing], self.rule.ratio)
        return key, competing[column]

    def _competing(self, likeness: NDArray[np.float32]) -> IndexArray:
        """The points of the pictures with most votes; a point has one vote however many key points look like it."""
        cloud = self.cloud
        _, voting = _distinct(likeness, self.rule.vote_ratio)
        seen = np.isin(cloud.point, voting)
        votes = np.bincount(cloud.image[seen], minlength=1)
        best = np.argsort(-votes, kind="stable")[: self.rule.images]
        competing: IndexArray = np.unique(cloud.point[np.isin(cloud.image, best)]).astype(np.int64)
        return competing


def _units(descriptors: ImageArray) -> NDArray[np.float32]:
    values = descriptors.astype(np.float32)
    return np.asarray(values / np.maximum(np.linalg.norm(values, axis=1, keepdims=True), 1.0), np.float32)


def _distinct(likeness: NDArray[np.float32], ratio: float) -> Matches:
    """Rows of cosines (k, m) whose largest stands out, and its column: (j,), (j,)."""
    if likeness.shape[0] == 0 or likeness.shape[1] < 2:
        return np.empty(0, np.int64), np.empty(0, np.int64)
    best = likeness.argmax(axis=1)
    first = likeness[np.arange(len(likeness)), best]
    second = np.partition(likeness, -2, axis=1)[:, -2]
    # Unit vectors are |a - b|^2 = 2 - 2 cos apart.
    rows = np.flatnonzero(np.maximum(1.0 - first, 0.0) < ratio**2 * np.maximum(1.0 - second, 0.0))
    return rows, best[rows]
