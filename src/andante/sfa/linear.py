"""Linear slow feature analysis as an estimator for any time series.

>>> t = np.linspace(0, 20, 2000)
>>> slow, fast = np.sin(t), np.sin(9 * t)
>>> mixed = np.column_stack([slow + fast, slow - 2 * fast])
>>> outputs = LinearSFA(n_components=1).fit_transform(mixed)
>>> bool(abs(np.corrcoef(outputs[:, 0], slow)[0, 1]) > 0.999)
True
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Self

import numpy as np
from numpy.typing import ArrayLike

from andante.data import Edges, FloatArray
from andante.errors import LearningError
from andante.sfa.arrays import Matrix, as_matrix
from andante.sfa.eigen import RANK_TOLERANCE
from andante.sfa.estimator import SlowEstimator, moments_of_episodes
from andante.sfa.model import AffineModel
from andante.sfa.moments import Moments
from andante.sfa.solver import solve_slow


class LinearSFA(SlowEstimator[AffineModel]):
    """The slowest linear combinations of signals (thesis 3.2, 3.3).

    ``n_components`` outputs, all that exist where ``None``; ``ridge`` and ``rank_tolerance`` as in ``solve_slow``.
    After learning: ``model_`` (frozen), ``deltas_`` (k,), ``weights_`` (d, k), ``mean_`` (d,), ``rank_``,
    ``n_features_in_``.
    """

    _moments: Moments | None = None
    _last_row: Matrix | None = None

    def __init__(
        self, n_components: int | None = None, *, ridge: float = 0.0, rank_tolerance: float = RANK_TOLERANCE
    ) -> None:
        self.n_components = n_components
        self.ridge = ridge
        self.rank_tolerance = rank_tolerance

    @property
    def weights_(self) -> FloatArray:
        """(d, k) weights of the signals in the outputs."""
        return self.model_.weights

    @property
    def mean_(self) -> FloatArray:
        """(d,) mean of the samples."""
        return self.model_.mean

    @property
    def rank_(self) -> int:
        """Number of dimensions in which the samples varied."""
        return self.model_.rank

    def partial_fit(self, X: ArrayLike, y: None = None, *, new_episode: bool = False) -> Self:
        """Learn from the next rows (n, d) of one time series: any chunking gives the same features.

        The first row continues the last row of the call before, unless ``new_episode``. After ``fit`` learning goes on
        with a new episode. Features are solved anew with each call; as long as the data does not suffice for
        them, the estimator stays unfitted and ``transform`` says why. For streams of single rows keep a
        ``Moments`` and call ``solve_slow`` when features are needed.
        """
        chunk = as_matrix(X)
        if self._moments is None:
            self.n_features_in_ = chunk.shape[1]
            self._moments = Moments.empty(chunk.shape[1])
        self._require_columns([chunk])
        if self._last_row is not None and not new_episode:
            self._moments.add_differences(chunk[:1].astype(np.float64) - self._last_row)
        self._moments.add_series(chunk)
        self._last_row = chunk[-1:].copy()
        self._model = None
        try:
            self._model = self._solve(self._moments)
        except LearningError as error:
            self._unfitted_because = str(error)
        return self

    def _learn(self, episodes: Sequence[Matrix], edges: Edges | None) -> AffineModel:
        self._moments = moments_of_episodes(episodes, edges)
        self._last_row = None
        return self._solve(self._moments)

    def _solve(self, moments: Moments) -> AffineModel:
        return solve_slow(moments, self.n_components, ridge=self.ridge, rank_tolerance=self.rank_tolerance)
