"""Slow features from a sparse kernel expansion: any smooth function of what is seen, not polynomials alone.

Slow features of an unrestricted function space are the eigenvectors of the training graph (Sprekeler, Neural
Computation 23, 2011; theory 5). Polynomials of degree two in twenty signals are far from unrestricted: around an
obstacle they bend where they should fold. Here every sample is described by how much it looks like each of m
prototypes, samples that are spread evenly over all that was seen,

    phi_j(x) = exp(-|z - p_j|^2 / 2 s^2) / sum_l exp(-|z - p_l|^2 / 2 s^2)

where z are the slowest linear features in their commute-time metric; linear slow feature analysis of phi comes next. It
is kernel slow feature analysis on a sparse subset (Boehmer et al., ECML 2011), with shares that sum to one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial.distance import cdist

from andante.data import Edges, FloatArray, IndexArray
from andante.errors import ArrayError, ConfigError
from andante.sfa.arrays import Matrix, require_names
from andante.sfa.eigen import RANK_TOLERANCE
from andante.sfa.estimator import SlowEstimator, moments_of_episodes
from andante.sfa.model import AffineModel
from andante.sfa.moments import Moments
from andante.sfa.solver import solve_slow

_LEAST_DELTA = 1e-12
_BLOCK = 1024
_SAMPLES_EACH = 5
"""A prototype of its own for every sample could be made as slow as one likes, and would say nothing of others."""


@dataclass(frozen=True, slots=True, eq=False)
class KernelModel:
    """x -> slow(shares of the prototypes in reduce(x)): affine d -> r, ``prototypes`` (m, r), affine m -> k.

    ``width`` is that of the kernel, in the metric of the reduced signals.
    """

    reduce: AffineModel
    prototypes: FloatArray
    width: float
    slow: AffineModel

    def __post_init__(self) -> None:
        m, r = self.prototypes.shape if self.prototypes.ndim == 2 else (-1, -1)
        if (r, m) != (self.reduce.output_dim, self.slow.input_dim) or not self.width > 0:
            raise ArrayError(
                f"a kernel model needs prototypes (m, r) for {self.reduce.output_dim} reduced signals and "
                f"{self.slow.input_dim} shares and a positive width, got {self.prototypes.shape} and {self.width}"
            )

    @property
    def input_dim(self) -> int:
        """Number of signals d that come in."""
        return self.reduce.input_dim

    @property
    def output_dim(self) -> int:
        """Number of slow features k that come out."""
        return self.slow.output_dim

    @property
    def deltas(self) -> FloatArray:
        """(k,) mean squared difference of each unit-variance output along the edges it was learnt on."""
        return self.slow.deltas

    def transform(self, x: Matrix) -> FloatArray:
        """(n, d) -> (n, k) float64; raises ``ArrayError`` for another number of columns."""
        return self.slow.transform(shares(self.reduce.transform(x), self.prototypes, self.width))

    def novelty(self, x: Matrix) -> FloatArray:
        """(n, d) -> (n,) distance to the nearest prototype in widths of the kernel: what was seen is near."""
        reduced = self.reduce.transform(x)
        nearest: FloatArray = cdist(reduced, self.prototypes).min(axis=1)
        return nearest / self.width

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Both affine stages, named ``reduce.mean`` .. and ``slow.mean`` .., ``prototypes`` and ``width`` (1,)."""
        stages = {"reduce": self.reduce, "slow": self.slow}
        arrays = {
            f"{stage}.{name}": array for stage, model in stages.items() for name, array in model.to_arrays().items()
        }
        return arrays | {"prototypes": self.prototypes, "width": np.array([self.width])}

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The inverse of ``to_arrays``; raises ``ArrayError`` for missing names or shapes that do not fit."""

        def stage(prefix: str) -> AffineModel:
            return AffineModel.from_arrays(
                {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
            )

        require_names(arrays, ("prototypes", "width"), "KernelModel")
        prototypes = np.asarray(arrays["prototypes"], dtype=np.float64)
        return cls(stage("reduce."), prototypes, float(arrays["width"].item()), stage("slow."))


class KernelSFA(SlowEstimator[KernelModel]):
    """The slowest functions in the span of a sparse kernel expansion.

    ``reduced_dim`` r linear slow features, each divided by the square root of its delta, are what is compared;
    ``prototypes`` m of them, at most one for every five samples, are chosen farthest point first, and ``width`` is
    that of the kernel in units of the median distance of a prototype to the next one. ``ridge`` holds for the last
    stage. ``density_corrected`` lets all prototypes count alike, however many samples look like them: where the robot
    dwelt does not distort the map (theory 4), and no positions are needed. After learning: ``model_`` (frozen),
    ``deltas_`` (k,), ``n_features_in_``.
    """

    def __init__(
        self,
        n_components: int | None = 8,
        *,
        reduced_dim: int = 30,
        prototypes: int = 1000,
        width: float = 0.6,
        ridge: float = 1e-3,
        density_corrected: bool = False,
    ) -> None:
        self.n_components = n_components
        self.reduced_dim = reduced_dim
        self.prototypes = prototypes
        self.width = width
        self.ridge = ridge
        self.density_corrected = density_corrected

    def _learn(self, episodes: Sequence[Matrix], edges: Edges | None) -> KernelModel:
        if not (self.width > 0 and self.prototypes >= 2):
            raise ConfigError(
                f"width={self.width}, prototypes={self.prototypes}: a kernel needs a positive width and two prototypes"
            )
        reduce = _scaled(solve_slow(moments_of_episodes(episodes, edges), self.reduced_dim, ridge=RIDGE_OF_REDUCTION))
        reduced = [reduce.transform(episode) for episode in episodes]
        joined = np.concatenate(reduced)
        chosen = joined[farthest_points(joined, min(self.prototypes, max(len(joined) // _SAMPLES_EACH, 2)))]
        width = self.width * _spacing(chosen)
        expanded = [shares(one, chosen, width) for one in reduced]
        moments = moments_of_episodes(expanded, edges)
        if self.density_corrected:
            moments = _evenly_weighted(np.concatenate(expanded), moments)
        slow = solve_slow(moments, self.n_components, ridge=self.ridge, rank_tolerance=RANK_TOLERANCE)
        return KernelModel(reduce, chosen, width, slow)


RIDGE_OF_REDUCTION = 1e-4
"""Enough to keep linear features from listening to directions in which nothing but noise varies."""


def shares(z: Matrix, prototypes: FloatArray, width: float) -> FloatArray:
    """How much of each row of ``z`` (n, r) belongs to each of ``prototypes`` (m, r): (n, m), rows sum to one."""
    result = np.empty((len(z), len(prototypes)))
    for start in range(0, len(z), _BLOCK):
        squared = cdist(z[start : start + _BLOCK], prototypes, "sqeuclidean")
        # Relative to the nearest prototype nothing underflows, however little a sample looks like any.
        weight = np.exp((squared.min(axis=1, keepdims=True) - squared) / (2.0 * width**2))
        result[start : start + _BLOCK] = weight / weight.sum(axis=1, keepdims=True)
    return result


def farthest_points(z: Matrix, count: int) -> IndexArray:
    """Indices of ``count`` rows, or of all that differ: each the farthest from those before it (Gonzalez 1985).

    The first is the one that is farthest from the mean, so that nothing is left to chance.
    """
    chosen = [int(((z - z.mean(axis=0)) ** 2).sum(axis=1).argmax())]
    squared = ((z - z[chosen[0]]) ** 2).sum(axis=1)
    while len(chosen) < min(count, len(z)):
        farthest = int(squared.argmax())
        if not squared[farthest] > 0:
            break
        chosen.append(farthest)
        squared = np.minimum(squared, ((z - z[farthest]) ** 2).sum(axis=1))
    return np.array(chosen, np.int64)


def _scaled(model: AffineModel) -> AffineModel:
    """The same features in their commute-time metric: one step along an edge changes each by one."""
    scale = 1.0 / np.sqrt(np.maximum(model.deltas, _LEAST_DELTA))
    return AffineModel(model.mean, model.weights * scale, np.ones_like(model.deltas), model.rank, model.rank_tolerance)


def _spacing(prototypes: FloatArray) -> float:
    """The median distance of a prototype to the next one."""
    distance = cdist(prototypes, prototypes)
    np.fill_diagonal(distance, np.inf)
    return float(np.median(distance.min(axis=1)))


def _evenly_weighted(expanded: FloatArray, moments: Moments) -> Moments:
    """The same edges, and samples that count one over how many look like the same prototype."""
    nearest = expanded.argmax(axis=1)
    count = np.bincount(nearest, minlength=expanded.shape[1])
    even = Moments.of(expanded, sample_weight=1.0 / count[nearest])
    even.edge_scatter, even.edge_count, even.n_edges = moments.edge_scatter, moments.edge_count, moments.n_edges
    return even
