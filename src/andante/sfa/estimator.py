"""The common part of the estimators: scikit-learn's conventions without importing scikit-learn.

An estimator stores its settings, learns in ``fit``, and then holds a frozen ``model_`` that does the work.
scikit-learn takes seconds to import and is optional, so the few conventions that its pipelines need are spelt out
here; the tests run ``sklearn.utils.estimator_checks.check_estimator``.
"""

from __future__ import annotations

import inspect
import sys
from abc import ABC, abstractmethod
from collections.abc import Sequence
from functools import cache
from typing import Any, Generic, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike

from andante.data import Edges, FloatArray
from andante.errors import ArrayError, ConfigError, NotFittedError
from andante.sfa.arrays import Matrix, as_matrix, require_columns
from andante.sfa.model import SlowModel
from andante.sfa.moments import Moments

Samples = ArrayLike | Sequence[Matrix]
"""One time series (n, d), or a list of them: episodes, between which nothing is continuous."""

Model = TypeVar("Model", bound=SlowModel)


class SlowEstimator(ABC, Generic[Model]):
    """Settings in, ``fit``, and then a frozen ``model_``; ``transform`` never learns."""

    n_features_in_: int
    _model: Model | None = None
    _unfitted_because: str = "call fit first"

    @property
    def model_(self) -> Model:
        """The frozen result of learning; raises ``NotFittedError`` before."""
        if self._model is None:
            raise self._not_fitted(f"this {type(self).__name__} has not learnt yet: {self._unfitted_because}")
        return self._model

    @property
    def deltas_(self) -> FloatArray:
        """(k,) mean squared difference of each output along the edges it was learnt on, slowest first."""
        return self.model_.deltas

    def fit(self, X: Samples, y: None = None, *, edges: Edges | None = None) -> Self:
        """Learn anew from one time series (n, d) or a list of episodes.

        Without ``edges`` each sample is joined with the next one of its episode; with ``edges`` these index the rows of
        all episodes one after the other. ``y`` is ignored. Raises ``ArrayError`` for arrays that cannot be
        used, ``LearningError`` for data without enough variance or edges.
        """
        episodes = as_episodes(X)
        if sum(len(episode) for episode in episodes) < 2:
            raise ArrayError("n_samples=1: slow features need at least 2 samples, of which one follows the other")
        self._model = None
        self.n_features_in_ = episodes[0].shape[1]
        self._model = self._learn(episodes, edges)
        return self

    def transform(self, X: Samples) -> FloatArray:
        """Slow features (n, k) of samples (n, d), or of the rows of all episodes one after the other.

        Raises ``NotFittedError`` before ``fit``, ``ArrayError`` for another number of columns.
        """
        model = self.model_
        episodes = as_episodes(X)
        self._require_columns(episodes)
        return np.concatenate([model.transform(episode) for episode in episodes])

    def fit_transform(self, X: Samples, y: None = None, *, edges: Edges | None = None) -> FloatArray:
        """``fit`` and then ``transform`` of the same data."""
        return self.fit(X, edges=edges).transform(X)

    def get_feature_names_out(self, input_features: object = None) -> np.ndarray[tuple[int], np.dtype[np.object_]]:
        """Names of the outputs: the class in small letters and a number."""
        stem = type(self).__name__.lower()
        return np.array([f"{stem}{i}" for i in range(self.model_.output_dim)], dtype=object)

    def get_params(self, deep: bool = True) -> dict[str, Any]:
        """The settings by name."""
        return {name: getattr(self, name) for name in self._settings()}

    def set_params(self, **params: object) -> Self:
        """Change settings by name; they take effect with the next ``fit``."""
        allowed = self._settings()
        for name, value in params.items():
            if name not in allowed:
                raise ConfigError(f"{type(self).__name__} has no setting {name!r}; it has {', '.join(allowed)}")
            setattr(self, name, value)
        return self

    def __repr__(self) -> str:
        settings = ", ".join(f"{name}={value!r}" for name, value in self.get_params().items())
        return f"{type(self).__name__}({settings})"

    def __sklearn_is_fitted__(self) -> bool:
        return self._model is not None

    def __sklearn_tags__(self) -> Any:  # noqa: ANN401
        # Only scikit-learn calls this, so it is loaded already.
        from sklearn.utils import Tags, TargetTags, TransformerTags

        return Tags(estimator_type=None, target_tags=TargetTags(required=False), transformer_tags=TransformerTags())

    @abstractmethod
    def _learn(self, episodes: Sequence[Matrix], edges: Edges | None) -> Model:
        """The model of some episodes, with edges over their rows in order or, where ``None``, over time."""

    def _require_columns(self, episodes: Sequence[Matrix]) -> None:
        for episode in episodes:
            require_columns(episode, self.n_features_in_, type(self).__name__)

    @classmethod
    def _settings(cls) -> tuple[str, ...]:
        return tuple(name for name in inspect.signature(cls).parameters)

    @staticmethod
    def _not_fitted(message: str) -> NotFittedError:
        # scikit-learn's tools wait for their own exception; where they are in use, raise one that is both.
        theirs = sys.modules.get("sklearn.exceptions")
        return NotFittedError(message) if theirs is None else _both(theirs.NotFittedError)(message)


@cache
def _both(foreign: type[Exception]) -> type[NotFittedError]:
    return type("NotFittedError", (NotFittedError, foreign), {"__module__": NotFittedError.__module__})


def as_episodes(samples: Samples) -> list[Matrix]:
    """One checked (n, d) array per episode, all of one width; raises ``ArrayError``."""
    if isinstance(samples, list | tuple) and samples and all(np.ndim(part) == 2 for part in samples):
        episodes = [as_matrix(part) for part in samples]
        for episode in episodes[1:]:
            require_columns(episode, episodes[0].shape[1], "a fit on several episodes")
        return episodes
    return [as_matrix(samples)]


def moments_of_episodes(episodes: Sequence[Matrix], edges: Edges | None) -> Moments:
    """Moments with edges over consecutive samples of each episode, or with ``edges`` over all rows in order."""
    moments = Moments.empty(episodes[0].shape[1])
    if edges is None:
        for episode in episodes:
            moments.add_series(episode)
        return moments
    rows = np.concatenate(episodes) if len(episodes) > 1 else episodes[0]
    moments.add_samples(rows)
    moments.add_edges(rows, edges)
    return moments
