"""Features and edges -> slow features and the metric in which they are compared."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import Edges, FloatArray, IndexArray
from andante.errors import LearningError
from andante.mapping.config import LearningConfig
from andante.sequences import place_edges, restructured_edges, temporal_edges
from andante.sfa import AffineModel, Moments, QuadraticModel, expand_quadratic, solve_slow


@dataclass(frozen=True, eq=False)
class Learnt:
    """A slow model and its ``metric`` (k,): factors that give every output unit noise along edges.

    Distances between outputs times the metric are the commute-time distance of the training graph, cut off after
    k features (theory 6): slow features count more the slower they are.
    """

    model: AffineModel | QuadraticModel
    metric: FloatArray


@dataclass(frozen=True, eq=False)
class Ground:
    """Where and in which recording the mapped frames were taken, n frames.

    ``xy`` (n, 2) in metres, or the place number and zero; ``session`` (n,) numbers the recordings; ``number`` (n,)
    the frames, so that frames left out show as gaps; ``radius`` is how far apart frames of one place are.
    """

    xy: FloatArray
    session: IndexArray
    number: IndexArray
    radius: float

    def subset(self, chosen: NDArray[np.bool_]) -> Ground:
        """Some of the frames."""
        return Ground(self.xy[chosen], self.session[chosen], self.number[chosen], self.radius)


def typical_radius(xy: FloatArray, session: IndexArray, least: float) -> float:
    """2.5 typical steps between consecutive frames, at least ``least``."""
    steps = np.linalg.norm(np.diff(xy, axis=0), axis=1)[np.diff(session) == 0]
    return max(least, 2.5 * float(np.median(steps))) if len(steps) else least


def learning_edges(ground: Ground, config: LearningConfig, seed: int) -> Edges:
    """The edges that the configured order asks for; raises ``LearningError`` where there are none."""
    several = len(np.unique(ground.session)) > 1
    if config.order == "places":
        edges = place_edges(ground.xy, ground.radius, ground.session, across_weight=config.across_weight)
    elif config.order == "restructured" and several:
        edges = restructured_edges(ground.xy, ground.session, ground.radius, np.random.default_rng(seed))
    else:
        # Numbers stand for times: frames on both sides of a held-out block are no neighbours.
        edges = temporal_edges(ground.session, timestamp_s=ground.number, max_gap_s=1)
    if len(edges) == 0:
        raise LearningError(
            f"no two of the {len(ground.xy)} frames belong together ({config.order} order, place radius "
            f"{ground.radius:.2f}); record more frames or raise learning.place_radius_m"
        )
    return edges


def learn_slow(x: NDArray[np.float32], edges: Edges, config: LearningConfig) -> Learnt:
    """Slow features of ``x`` (n, d) along ``edges``; raises ``LearningError`` where the data does not suffice."""
    _require_frames(len(x), config)
    if config.expansion == "linear":
        moments = Moments.of(x, edges)
        model = _solved(moments, min(config.slow_features, _most_features(x)), config)
        return Learnt(model, _metric(model, moments, config))
    reduce = _solved(Moments.of(x, edges), config.reduced_dim, config)
    terms = expand_quadratic(reduce.transform(x))
    moments = Moments.of(terms, edges)
    slow = _solved(moments, config.slow_features, config)
    return Learnt(QuadraticModel(reduce, slow), _metric(slow, moments, config))


def _most_features(x: NDArray[np.float32]) -> int:
    """How many slow features ``x`` (n, d) has: with few frames, as in a fold, fewer than the configured number."""
    if len(x) > x.shape[1]:
        return int(x.shape[1])
    # Each picture but the first adds one direction; a camera that hangs repeats pictures.
    return max(1, len(np.unique(x, axis=0)) - 1)


def _solved(moments: Moments, count: int, config: LearningConfig) -> AffineModel:
    return solve_slow(moments, count, ridge=config.ridge, edge_ridge=config.edge_ridge)


def _metric(model: AffineModel, moments: Moments, config: LearningConfig) -> FloatArray:
    """1 / sqrt(delta), with the noise of ``edge_ridge`` in delta."""
    noise = config.edge_ridge * float(np.trace(moments.edge_covariance)) / moments.dim
    noisy = model.deltas + noise * (model.weights**2).sum(axis=0)
    metric: FloatArray = 1 / np.sqrt(np.maximum(noisy, 1e-12))
    return metric


def _require_frames(n: int, config: LearningConfig) -> None:
    needed = 10 if config.expansion == "linear" else config.slow_features + config.reduced_dim
    if n < needed:
        raise LearningError(
            f"{n} usable frames are too few to learn from, at least {needed} are needed; record a longer drive"
        )
