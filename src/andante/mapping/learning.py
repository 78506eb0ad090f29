"""Features and an order -> slow features and the metric in which they are compared.

An order says which frames belong together, and there are three behind one function, ``training_moments``: ``places``
(all frames of a place, whatever the session, in closed form), ``restructured`` (the thesis' interleaved sequence, 6.2)
and ``temporal`` (each frame with the next).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from andante.data import Edges, FloatArray, IndexArray
from andante.errors import LearningError
from andante.mapping.config import Order
from andante.sequences import restructured_edges, temporal_edges
from andante.sfa import AffineModel, Moments, PlaceMoments, QuadraticModel, expand_quadratic, solve_slow

_CELLS_PER_RADIUS = 2.5
"""A place is as large as a typical step of the robot, of which a place radius has 2.5."""
_LEAST_STRENGTH = 1e-5
"""Of a direction, relative to the strongest: below it, squared, ``solve_slow`` takes it for none."""


@dataclass(frozen=True, slots=True)
class Recipe:
    """How to learn, nothing left open; the fields of ``LearningConfig`` with the same names say what they mean."""

    order: Order
    expansion: Literal["linear", "quadratic"]
    reduced_dim: int
    slow_features: int
    ridge: float
    edge_ridge: float
    invariance: float
    density_corrected: bool = False


@dataclass(frozen=True, eq=False)
class Learnt:
    """A slow model and its ``metric`` (k,): factors that give every output unit noise along edges.

    Distances between outputs times the metric are the commute-time distance of the training graph, cut off after
    k features (theory 6): slow features count more the slower they are.
    """

    model: AffineModel | QuadraticModel
    metric: FloatArray

    def slowest(self, count: int) -> Learnt:
        """The first features alone; as each is solved for given those before it, these do not change."""
        model = self.model
        if isinstance(model, AffineModel):
            return Learnt(_first(model, count), self.metric[:count])
        return Learnt(QuadraticModel(model.reduce, _first(model.slow, count)), self.metric[:count])


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

    def __len__(self) -> int:
        return len(self.xy)

    def subset(self, chosen: IndexArray | NDArray[np.bool_]) -> Ground:
        """Some of the frames."""
        return Ground(self.xy[chosen], self.session[chosen], self.number[chosen], self.radius)

    @property
    def cells(self) -> IndexArray:
        """(n, 2) the place of every frame: cells of a grid that all sessions share."""
        return np.floor(self.xy * (_CELLS_PER_RADIUS / self.radius)).astype(np.int64)


def typical_radius(xy: FloatArray, session: IndexArray, least: float) -> float:
    """2.5 typical steps between consecutive frames, at least ``least``."""
    steps = np.linalg.norm(np.diff(xy, axis=0), axis=1)[np.diff(session) == 0]
    return max(least, 2.5 * float(np.median(steps))) if len(steps) else least


def training_moments(x: NDArray[np.floating[Any]], ground: Ground, recipe: Recipe, seed: int) -> Moments:
    """What the configured order makes of samples ``x`` (n, d); raises ``LearningError`` where it joins nothing."""
    if recipe.order == "places":
        if not np.ptp(x, axis=0).any():
            raise LearningError(f"none of the {x.shape[1]} signals varies over the {len(x)} samples: all are the same")
        return place_moments(x, ground).moments(recipe.invariance, density_corrected=recipe.density_corrected)
    return Moments.of(x, edges_in_order(ground, recipe.order, seed))


def place_moments(x: NDArray[np.floating[Any]], ground: Ground) -> PlaceMoments:
    """Samples ``x`` (n, d) grouped by the cells of the ground."""
    return PlaceMoments.of(x, ground.cells)


def learn_slow(x: NDArray[np.float32], ground: Ground, recipe: Recipe, seed: int) -> Learnt:
    """Slow features of ``x`` (n, d) in the order asked for; raises ``LearningError`` for too little data."""
    require_frames(len(x), recipe)
    if recipe.expansion == "linear":
        return linear_slow(training_moments(x, ground, recipe, seed), most_features(x), recipe)
    reduce = _solved(training_moments(x, ground, recipe, seed), recipe.reduced_dim, recipe)
    moments = training_moments(expand_quadratic(reduce.transform(x)), ground, recipe, seed)
    slow = _solved(moments, recipe.slow_features, recipe)
    return Learnt(QuadraticModel(reduce, slow), _metric(slow, moments, recipe))


def linear_slow(moments: Moments, most: int, recipe: Recipe) -> Learnt:
    """The linear case from moments alone, at most ``most`` features."""
    model = _solved(moments, min(recipe.slow_features, most), recipe)
    return Learnt(model, _metric(model, moments, recipe))


def most_features(x: NDArray[np.float32]) -> int:
    """How many slow features ``x`` (n, d) has: with few frames, as in a fold, fewer than the configured number."""
    if len(x) > x.shape[1]:
        return int(x.shape[1])
    # Each picture but the first adds one direction; a camera that hangs repeats pictures, up to rounding.
    centred = x - x.mean(axis=0, dtype=np.float64)
    scale = np.sqrt((centred**2).sum(axis=0))
    strength = np.linalg.svd(centred / np.where(scale > 0, scale, 1.0), compute_uv=False)
    return max(1, int((strength > _LEAST_STRENGTH * strength.max(initial=0.0)).sum()))


def require_frames(n: int, recipe: Recipe) -> None:
    """Raise ``LearningError`` for fewer frames than can be learnt from."""
    needed = 10 if recipe.expansion == "linear" else recipe.slow_features + recipe.reduced_dim
    if n < needed:
        raise LearningError(
            f"{n} usable frames are too few to learn from, at least {needed} are needed; record a longer drive"
        )


def edges_in_order(ground: Ground, order: Order, seed: int) -> Edges:
    """The thesis' orders, one edge after the other; raises ``LearningError`` where they join nothing."""
    if order == "restructured" and len(np.unique(ground.session)) > 1:
        edges = restructured_edges(ground.xy, ground.session, ground.radius, np.random.default_rng(seed))
    else:
        # Numbers stand for times: frames on both sides of a held-out block are no neighbours.
        edges = temporal_edges(ground.session, timestamp_s=ground.number, max_gap_s=1)
    if len(edges) == 0:
        raise LearningError(
            f"no two of the {len(ground)} frames belong together ({order} order, place radius "
            f"{ground.radius:.2f}); record more frames or raise learning.place_radius_m"
        )
    return edges


def _solved(moments: Moments, count: int, recipe: Recipe) -> AffineModel:
    return solve_slow(moments, count, ridge=recipe.ridge, edge_ridge=recipe.edge_ridge)


def _metric(model: AffineModel, moments: Moments, recipe: Recipe) -> FloatArray:
    """1 / sqrt(delta), with the noise of ``edge_ridge`` in delta."""
    noise = recipe.edge_ridge * float(np.trace(moments.edge_covariance)) / moments.dim
    noisy = model.deltas + noise * (model.weights**2).sum(axis=0)
    metric: FloatArray = 1 / np.sqrt(np.maximum(noisy, 1e-12))
    return metric


def _first(model: AffineModel, count: int) -> AffineModel:
    weights = np.ascontiguousarray(model.weights[:, :count])
    return AffineModel(model.mean, weights, model.deltas[:count], model.rank, model.rank_tolerance)
