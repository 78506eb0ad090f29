"""Everything slow feature analysis needs of frames grouped by place, in a form that adds up and can be taken apart.

The training graph joins all frames of one place with each other, whatever the session, and neighbouring places through
their means. The sums over all its edges have a closed form (theory 2): with n_p frames and mean mu_p in place p,

    E = sum_pq w_pq (mu_q - mu_p)(mu_q - mu_p)^T / sum_pq w_pq
      + beta sum_p sum_(i in p) (x_i - mu_p)(x_i - mu_p)^T / N

is the slowness of the mean path plus ``beta`` times the scatter inside of places, which is what light, season and
heading do to the features. In the words of Escalante-B. and Wiskott (JMLR 14, 2013) it is a serial training graph whose
groups are places, and a clustered graph inside of them. Nothing of it needs the frames again: parts merge exactly
(another session) and come out again exactly (a session held out), which makes leaving sessions out cheap.

>>> x = np.random.default_rng(0).normal(size=(60, 3))
>>> places = np.arange(60)[:, None] // 3 % 10
>>> whole, monday = PlaceMoments.of(x, places), PlaceMoments.of(x[:30], places[:30])
>>> bool(np.allclose(whole.without(monday).within, PlaceMoments.of(x[30:], places[30:]).within))
True
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import reduce
from typing import Self

import numpy as np
from scipy.spatial import KDTree

from andante.data import FloatArray, IndexArray
from andante.errors import ArrayError, ConfigError, LearningError
from andante.sfa.arrays import Matrix, require_finite
from andante.sfa.moments import Moments

_REACH = 1.5
"""Cells apart up to which places are neighbours: those that touch, corners included."""


@dataclass(frozen=True, slots=True, eq=False)
class PlaceMoments:
    """Frames in P places, d signals.

    ``place`` (P, c) int64 are cells of a grid in c dimensions, sorted; ``count`` (P,) the frames there and ``mean``
    (P, d) their means. ``within`` (d, d) is the scatter around the mean of the own place, summed over all frames.
    """

    place: IndexArray
    count: FloatArray
    mean: FloatArray
    within: FloatArray

    @classmethod
    def of(cls, x: Matrix, place: IndexArray) -> Self:
        """From samples ``x`` (n, d) and the cell (n, c) of each; raises ``ArrayError`` for other shapes or NaN."""
        place = np.asarray(place)
        if x.ndim != 2 or place.ndim != 2 or len(place) != len(x) or not np.issubdtype(place.dtype, np.integer):
            raise ArrayError(
                f"samples (n, d) need one whole-numbered cell each (n, c), got shapes {x.shape} and {place.shape} "
                f"of {place.dtype}"
            )
        require_finite(x)
        cells, index = np.unique(place.astype(np.int64), axis=0, return_inverse=True)
        order = np.argsort(index.ravel(), kind="stable")
        inside = x[order].astype(np.float64)
        count = np.bincount(index.ravel(), minlength=len(cells)).astype(np.float64)
        starts = np.concatenate([[0], np.cumsum(count)[:-1]]).astype(np.int64)
        # Relative to the first sample no signal far from zero loses digits.
        origin = inside[:1].copy() if len(x) else np.zeros((1, x.shape[1]))
        inside -= origin
        mean = np.add.reduceat(inside, starts, axis=0) / count[:, None] if len(x) else np.empty((0, x.shape[1]))
        inside -= np.repeat(mean, count.astype(np.int64), axis=0)
        return cls(cells, count, mean + origin, inside.T @ inside)

    @classmethod
    def joined(cls, parts: Sequence[PlaceMoments]) -> PlaceMoments:
        """All of at least one part together."""
        return reduce(PlaceMoments.merge, parts)

    @property
    def dim(self) -> int:
        """Number of signals d."""
        return len(self.within)

    @property
    def n_samples(self) -> int:
        """Number of frames in all places."""
        return int(self.count.sum())

    def merge(self, other: PlaceMoments) -> PlaceMoments:
        """Both together; exact up to rounding (Chan, Golub and LeVeque 1979, place by place)."""
        mine, theirs, cells = self._aligned(other)
        (n1, mu1), (n2, mu2) = mine, theirs
        total = n1 + n2
        gap = mu2 - mu1
        between = gap * np.sqrt(n1 * n2 / total)[:, None]
        mean = mu1 + gap * (n2 / total)[:, None]
        return PlaceMoments(cells, total, mean, self.within + other.within + between.T @ between)

    def without(self, part: PlaceMoments) -> PlaceMoments:
        """What is left when ``part``, which was merged in before, is taken out again: ``merge`` undone.

        Raises ``LearningError`` where ``part`` has frames in places that hold fewer.
        """
        (total, mean), (n2, mu2), cells = self._aligned(part)
        n1 = total - n2
        if (n1 < 0).any():
            raise LearningError("moments can only be taken out of a whole that they are part of")
        kept = n1 > 0
        safe = np.where(kept, n1, 1.0)
        mu1 = np.where(kept[:, None], (total[:, None] * mean - n2[:, None] * mu2) / safe[:, None], mu2)
        gap = (mu2 - mu1) * np.sqrt(n1 * n2 / total)[:, None]
        return PlaceMoments(cells[kept], n1[kept], mu1[kept], self.within - part.within - gap.T @ gap)

    def moments(self, beta: float = 1.0, *, reach: float = _REACH, density_corrected: bool = False) -> Moments:
        """What ``solve_slow`` takes: the covariance of all frames, and E as above as the edge covariance.

        ``beta`` >= 0 is the weight of what must be ignored against what must change slowly. Places are neighbours up
        to ``reach`` cells apart, and weigh exp(-distance^2 / 2). ``density_corrected`` lets all places count alike in
        the covariance, however long the robot dwelt there: the covariance of their means plus the pooled scatter.
        Raises ``ConfigError`` for a beta out of range, ``LearningError`` where there are no edges at all.
        """
        if not 0 <= beta < np.inf:
            raise ConfigError(f"beta={beta}: has to be a finite number >= 0")
        between, pairs = self._between(reach)
        n = self.count.sum()
        edge = between + beta * self.within / max(n, 1.0)
        if not np.trace(edge) > 0:
            raise LearningError(
                f"no two of the {self.n_samples} frames belong together: each is alone in its place, far from the "
                "others; record more frames or make the places larger"
            )
        weight = np.ones(len(self.count)) if density_corrected else self.count
        mean = weight @ self.mean / weight.sum()
        offset = (self.mean - mean) * np.sqrt(weight / weight.sum())[:, None]
        scatter = n * (offset.T @ offset) + self.within
        return Moments(float(n), mean, scatter, 1.0, edge, self.n_samples, pairs + self.n_samples)

    def _between(self, reach: float) -> tuple[FloatArray, int]:
        """The mean outer product of differences between neighbouring places, and how many pairs there are."""
        pairs = np.asarray(KDTree(self.place).query_pairs(reach, output_type="ndarray")) if len(self.place) else ()
        if len(pairs) == 0:
            return np.zeros((self.dim, self.dim)), 0
        first, second = np.asarray(pairs).T
        apart = ((self.place[second] - self.place[first]) ** 2).sum(axis=1)
        weight = np.exp(-apart / 2)
        step = (self.mean[second] - self.mean[first]) * np.sqrt(weight / weight.sum())[:, None]
        return step.T @ step, len(first)

    def _aligned(
        self, other: PlaceMoments
    ) -> tuple[tuple[FloatArray, FloatArray], tuple[FloatArray, FloatArray], IndexArray]:
        """Counts and means of both over the places of either; where one has no frames, the mean of the other."""
        if self.dim != other.dim or self.place.shape[1] != other.place.shape[1]:
            raise ArrayError(
                f"moments of {self.dim} signals in {self.place.shape[1]}-dimensional cells do not fit those of "
                f"{other.dim} in {other.place.shape[1]}-dimensional ones"
            )
        cells, index = np.unique(np.concatenate([self.place, other.place]), axis=0, return_inverse=True)
        mine, theirs = np.split(index.ravel(), [len(self.place)])
        sides = []
        for one, at in ((self, mine), (other, theirs)):
            count, mean = np.zeros(len(cells)), np.zeros((len(cells), self.dim))
            count[at], mean[at] = one.count, one.mean
            sides.append((count, mean))
        (n1, mu1), (n2, mu2) = sides
        mu1[n1 == 0], mu2[n2 == 0] = mu2[n1 == 0], mu1[n2 == 0]
        return (n1, mu1), (n2, mu2), cells
