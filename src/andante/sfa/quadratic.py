"""Quadratic slow features: reduce, expand, and look for slow features again (thesis 5.1.1).

The expansion squares the number of dimensions, so linear slow feature analysis first keeps the r slowest directions:
900 -> 20 -> 230 -> 8 in the thesis.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Self

from numpy.typing import NDArray

from andante.data import Edges, FloatArray
from andante.errors import ArrayError
from andante.sfa.arrays import Matrix
from andante.sfa.eigen import RANK_TOLERANCE
from andante.sfa.estimator import SlowEstimator, moments_of_episodes
from andante.sfa.expansion import expand_quadratic, expanded_dim
from andante.sfa.model import AffineModel
from andante.sfa.pca import PCA
from andante.sfa.solver import solve_slow


@dataclass(frozen=True, slots=True, eq=False)
class QuadraticModel:
    """x -> slow(expand_quadratic(reduce(x))) with two affine models d -> r and r + r(r+1)/2 -> k."""

    reduce: AffineModel
    slow: AffineModel

    def __post_init__(self) -> None:
        terms = expanded_dim(self.reduce.output_dim)
        if self.slow.input_dim != terms:
            raise ArrayError(
                f"a quadratic model of {self.reduce.output_dim} reduced signals has {terms} terms, "
                f"but its second stage takes {self.slow.input_dim}"
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
        return self.slow.transform(expand_quadratic(self.reduce.transform(x)))

    def after(self, pca: PCA) -> QuadraticModel:
        """One model that does what ``pca`` and then this one do; exact, and not slower than this one."""
        return QuadraticModel(self.reduce.after(pca), self.slow)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """The arrays of both stages, named ``reduce.mean`` .. and ``slow.mean`` .."""
        stages = {"reduce": self.reduce, "slow": self.slow}
        return {
            f"{stage}.{name}": array for stage, model in stages.items() for name, array in model.to_arrays().items()
        }

    @classmethod
    def from_arrays(cls, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The inverse of ``to_arrays``; raises ``ArrayError`` for missing names or shapes that do not fit."""

        def stage(prefix: str) -> AffineModel:
            return AffineModel.from_arrays(
                {name.removeprefix(prefix): array for name, array in arrays.items() if name.startswith(prefix)}
            )

        return cls(stage("reduce."), stage("slow."))


class QuadraticSFA(SlowEstimator[QuadraticModel]):
    """The slowest polynomials of degree two in the ``reduced_dim`` slowest linear features (thesis 5.1.1).

    ``reduced_dim`` r and ``n_components`` k mean all that exist where ``None``; ``ridge`` and ``rank_tolerance`` hold
    for both stages, as in ``solve_slow``. After learning: ``model_`` (frozen), ``deltas_`` (k,), ``n_features_in_``.
    """

    def __init__(
        self,
        n_components: int | None = 8,
        *,
        reduced_dim: int | None = 20,
        ridge: float = 0.0,
        rank_tolerance: float = RANK_TOLERANCE,
    ) -> None:
        self.n_components = n_components
        self.reduced_dim = reduced_dim
        self.ridge = ridge
        self.rank_tolerance = rank_tolerance

    def _learn(self, episodes: Sequence[Matrix], edges: Edges | None) -> QuadraticModel:
        # Keep the slowest linear directions, so that the expansion stays small.
        reduce = self._solve(episodes, edges, self.reduced_dim)
        # All polynomials of degree two of these are linear functions of the terms.
        terms = [expand_quadratic(reduce.transform(episode)) for episode in episodes]
        return QuadraticModel(reduce, self._solve(terms, edges, self.n_components))

    def _solve(self, episodes: Sequence[Matrix], edges: Edges | None, n_components: int | None) -> AffineModel:
        moments = moments_of_episodes(episodes, edges)
        return solve_slow(moments, n_components, ridge=self.ridge, rank_tolerance=self.rank_tolerance)
