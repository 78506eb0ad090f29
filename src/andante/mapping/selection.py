"""How to learn, chosen by leaving sessions out: the more conditions a map has seen, the more it may trust them.

With fewer than four sessions nothing tells what the next light or season will do (of summer and autumn each is easy to
find with the other and 64 features, but snow is not), so learning expects the worst and keeps nearly all that the
pictures show. With more, each is held out in turn and located by what the others teach, for every candidate; the fewest
features win whose mean error is within a tenth of the best. The sums over edges are made once: a session is taken out
of them again (``PlaceMoments.without``), and one eigenproblem serves every number of features.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.errors import LearningError
from andante.mapping.config import LearningConfig, MapConfig, ReadoutConfig
from andante.mapping.folds import Mask
from andante.mapping.learning import (
    Ground,
    Learnt,
    Recipe,
    learn_slow,
    linear_slow,
    most_features,
    place_moments,
    require_frames,
)
from andante.mapping.lessons import Lessons
from andante.mapping.readout import PRIOR_CAUTION, fit_readout
from andante.mapping.thinning import thinned_by_place
from andante.sfa import PlaceMoments

_PRIOR_SLOW_FEATURES, _PRIOR_EDGE_RIDGE, _PRIOR_INVARIANCE = 192, 10.0, 1.0
_SLOW_FEATURES = {4: (96, 128, 192), 8: (64, 96, 128, 192)}
"""Candidates from so many sessions on."""
_EDGE_RIDGES = (0.1, 1.0, 10.0)
_INVARIANCES = (1.0, 10.0)
_CAUTIONS = (PRIOR_CAUTION, 1.0, 0.1)
_WORSE_BY = 1.1
_CAP_RADII = 10.0
_TEST_FRAMES, _REFERENCES = 150, 1500


def choose_recipe(lessons: Lessons, config: MapConfig) -> Recipe:
    """How to learn: what the configuration says, and what it leaves open by trial on held-out sessions."""
    learning = config.learning
    prior, sessions = recipe_of(learning), lessons.sessions
    if sessions < min(_SLOW_FEATURES):
        return prior
    counts = next(counts for least, counts in reversed(_SLOW_FEATURES.items()) if sessions >= least)
    # Only the order by places knows invariance.
    invariances = _INVARIANCES if learning.order == "places" else (_PRIOR_INVARIANCE,)
    open_values = product(counts, _EDGE_RIDGES, invariances)
    candidates = list(dict.fromkeys(recipe_of(learning, *values) for values in open_values))
    if len(candidates) == 1:
        return prior
    closed_form = learning.order == "places" and learning.expansion == "linear"
    whole = place_moments(lessons.x, lessons.ground) if closed_form else None
    errors = _mean_errors(lessons, candidates, config, whole)
    if not np.isfinite(errors).any():
        return prior
    # Of the smallest candidates that are good enough, the best.
    good = errors <= _WORSE_BY * errors.min()
    size = np.array([recipe.slow_features for recipe in candidates])
    rank = np.where(good & (size == size[good].min()), errors, np.inf)
    return candidates[int(rank.argmin())]


def choose_caution(lessons: Lessons, recipe: Recipe, config: MapConfig) -> float:
    """How carefully to interpolate between references, by trial on held-out sessions where that is left open."""
    if config.readout.caution is not None:
        return config.readout.caution
    if config.readout.kind != "local" or lessons.sessions < min(_SLOW_FEATURES):
        return PRIOR_CAUTION
    options = [config.with_values({"readout": {"caution": caution}}) for caution in _CAUTIONS]
    errors = [_mean_errors(lessons, [recipe], option)[0] for option in options]
    return _CAUTIONS[int(np.argmin(errors))]


def _mean_errors(
    lessons: Lessons, candidates: list[Recipe], config: MapConfig, whole: PlaceMoments | None = None
) -> FloatArray:
    """The error of every candidate, in the mean over the folds without which something can be learnt."""
    trials = [_Trial(lessons.x, lessons.ground, train, test, config.seed) for train, test in lessons.folds]
    errors = np.array([trial.errors(candidates, config.readout, whole) for trial in trials])
    worked = np.isfinite(errors).any(axis=1)
    mean: FloatArray = errors[worked].mean(axis=0) if worked.any() else errors[0]
    return mean


def recipe_of(
    learning: LearningConfig,
    slow_features: int = _PRIOR_SLOW_FEATURES,
    edge_ridge: float = _PRIOR_EDGE_RIDGE,
    invariance: float = _PRIOR_INVARIANCE,
) -> Recipe:
    """What the configuration says, and the given values where it says nothing."""
    return Recipe(
        order=learning.order,
        expansion=learning.expansion,
        reduced_dim=learning.reduced_dim,
        slow_features=slow_features if learning.slow_features is None else learning.slow_features,
        ridge=learning.ridge,
        edge_ridge=edge_ridge if learning.edge_ridge is None else learning.edge_ridge,
        invariance=invariance if learning.invariance is None else learning.invariance,
        density_corrected=learning.density_corrected,
    )


@dataclass(frozen=True, slots=True, eq=False)
class _Trial:
    """One fold: learnt from the frames of ``train`` (n,), tried on some of those of ``test`` (n,)."""

    x: NDArray[np.float32]
    ground: Ground
    train: Mask
    test: Mask
    seed: int

    def errors(self, candidates: list[Recipe], readout: ReadoutConfig, whole: PlaceMoments | None) -> FloatArray:
        """The mean error of every candidate, each error capped; infinite where one cannot be learnt."""
        inside, x = self.ground.subset(self.train), self.x[self.train]
        held_out = np.flatnonzero(self.test)
        shown = held_out[np.linspace(0, len(held_out) - 1, min(len(held_out), _TEST_FRAMES)).astype(np.int64)]
        kept = thinned_by_place(inside.xy, inside.session, min(readout.max_references, _REFERENCES))
        found = dict.fromkeys(candidates, np.inf)
        for recipe, learnt in self._learnt(candidates, x, inside, whole):
            located = fit_readout(
                learnt.model.transform(x[kept]),
                inside.xy[kept],
                inside.session[kept],
                metric=learnt.metric,
                config=readout,
                consensus_m=readout.consensus_m or 2 * inside.radius,
            ).locate(learnt.model.transform(self.x[shown]))
            error = np.linalg.norm(located.xy - self.ground.xy[shown], axis=1)
            found[recipe] = float(np.minimum(error, _CAP_RADII * inside.radius).mean())
        return np.array(list(found.values()))

    def _learnt(
        self, candidates: list[Recipe], x: NDArray[np.float32], inside: Ground, whole: PlaceMoments | None
    ) -> Iterator[tuple[Recipe, Learnt]]:
        """Every candidate that can be learnt; those that differ in size alone are solved for once."""
        families: dict[Recipe, list[Recipe]] = {}
        most = max(recipe.slow_features for recipe in candidates)
        for recipe in candidates:
            families.setdefault(replace(recipe, slow_features=most), []).append(recipe)
        part = None if whole is None else whole.without(place_moments(self.x[self.test], self.ground.subset(self.test)))
        for largest, family in families.items():
            try:
                require_frames(len(x), largest)
                if part is None:
                    learnt = learn_slow(x, inside, largest, self.seed)
                else:
                    moments = part.moments(largest.invariance, density_corrected=largest.density_corrected)
                    learnt = linear_slow(moments, most_features(x), largest)
            except LearningError:
                continue
            yield from ((recipe, learnt.slowest(recipe.slow_features)) for recipe in family)
