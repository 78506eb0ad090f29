"""Everything that is learnt from, ready for learning: compressed features, where they belong, what is held out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.errors import LearningError
from andante.features import PhaseEncoder
from andante.mapping.codes import Codes
from andante.mapping.compass import Compass
from andante.mapping.config import MapConfig
from andante.mapping.folds import Folds, Mask
from andante.mapping.learning import Ground, Learnt, Recipe, learn_slow, typical_radius
from andante.mapping.located import Hidden, Readout
from andante.mapping.locating import Locator, Sighting
from andante.mapping.memory import MappedSession
from andante.mapping.readout import fit_readout
from andante.sfa import PCA, pca_of_samples

_PCA_SAMPLE = 800
_LEAST_RADIUS_M = 0.35
_LEAST_RADIUS_PLACES = 2.5
"""So that a cell of the ground, of which a radius has 2.5, is one place."""
_APART_RADII = 4


@dataclass(frozen=True, slots=True, eq=False)
class Lessons:
    """n frames: compressed features ``x`` (n, p), their distance ``spread`` (n,) from the average, ground and folds.

    ``pca`` is the compression, ``None`` where there is none; it knows no positions. ``phase`` and ``heading`` (n,) are
    what a compass is made of, by ``phase_encoder``.
    """

    x: NDArray[np.float32]
    spread: FloatArray
    pca: PCA | None
    ground: Ground
    folds: Folds
    phase: Codes
    heading: FloatArray
    phase_encoder: PhaseEncoder | None

    def compass(self, of: Mask) -> Compass | None:
        """The compass of some frames; ``None`` where there is none."""
        if self.phase_encoder is None:
            return None
        ground = self.ground
        return Compass.fit(
            self.phase_encoder, self.phase.subset(of), ground.xy[of], self.heading[of], cell_m=ground.radius
        )

    @property
    def sessions(self) -> int:
        """Number of sessions."""
        return len(np.unique(self.ground.session))


def lessons_of(
    sessions: Sequence[MappedSession], features: Codes, config: MapConfig, phase_encoder: PhaseEncoder | None = None
) -> Lessons:
    """From all frames of some sessions, whose ``features`` come one session after the other.

    There is no compass where headings are known of one session alone out of several.
    """
    ground = ground_of(sessions, config)
    names = [session.source.name for session in sessions]
    folds = Folds.of(ground, names, config.calibration)
    heading = np.concatenate([session.heading_rad for session in sessions])
    # A compass that some of the trials lack could not be tried, and their likeness would not be that of the map.
    every_trial_has_one = all(np.isfinite(heading[train]).any() for train, _ in folds)
    return Lessons(
        *_compressed(features, config),
        ground,
        folds,
        Codes.joined([session.phase for session in sessions]),
        heading,
        phase_encoder if every_trial_has_one else None,
    )


def locate_held_out(lessons: Lessons, recipe: Recipe, config: MapConfig, train: Mask, test: Mask) -> Sighting:
    """Learn from the frames of ``train`` (n,) alone and locate those of ``test`` (n,).

    Everything behind the compression is learnt anew. Raises ``LearningError`` where too little is left to learn from.
    """
    locator, slow = _taught(lessons, recipe, config, train, test)
    return locator.sight(slow, lessons.spread[test], lessons.phase.rows(test))


def try_held_out(
    lessons: Lessons, recipe: Recipe, config: MapConfig, train: Mask, test: Mask
) -> tuple[Sighting, FloatArray]:
    """The same, and how like strangers the located frames are."""
    locator, slow = _taught(lessons, recipe, config, train, test)
    seen = slow, lessons.spread[test], lessons.phase.rows(test)
    own = Hidden(lessons.ground.xy[test], _APART_RADII * lessons.ground.radius)
    return locator.sight(*seen), locator.strangers(*seen, own)


def _taught(lessons: Lessons, recipe: Recipe, config: MapConfig, train: Mask, test: Mask) -> tuple[Locator, FloatArray]:
    """What the frames of ``train`` alone teach, and the slow features that it takes of those of ``test``."""
    inside = lessons.ground.subset(train)
    learnt = learn_slow(lessons.x[train], inside, recipe, config.seed)
    slow = learnt.model.transform(lessons.x[train])
    readout = readout_of(slow, learnt, inside, config, lessons.spread[train])
    return Locator(readout, lessons.compass(train)), learnt.model.transform(lessons.x[test])


def readout_of(slow: FloatArray, learnt: Learnt, ground: Ground, config: MapConfig, spread: FloatArray) -> Readout:
    """The configured readout of slow features (n, k)."""
    return fit_readout(
        slow,
        ground.xy,
        ground.session,
        metric=learnt.metric,
        config=config.readout,
        consensus_m=config.readout.consensus_m or 2 * ground.radius,
        spread=spread,
    )


def ground_of(sessions: Sequence[MappedSession], config: MapConfig) -> Ground:
    """Positions of all frames, one session after the other."""
    xy = np.concatenate([session.xy for session in sessions])
    session_of = np.repeat(np.arange(len(sessions)), [len(session) for session in sessions])
    number = np.concatenate([session.number for session in sessions])
    least = _LEAST_RADIUS_PLACES if sessions[0].source.poses == "place" else _LEAST_RADIUS_M
    radius = config.learning.place_radius_m or typical_radius(xy, session_of, least)
    return Ground(xy, session_of, number, radius)


def _compressed(features: Codes, config: MapConfig) -> tuple[NDArray[np.float32], FloatArray, PCA | None]:
    """All frames in the principal components of a sample spread over all sessions (n, p), and their spread (n,)."""
    if len(features) < 2:
        raise LearningError(f"{len(features)} usable frames are too few to learn from; record a longer drive")
    if config.learning.pca_components == 0:
        rows = features.rows()
        return rows, np.linalg.norm(rows - rows.mean(axis=0), axis=1).astype(np.float64), None
    sample = np.unique(np.linspace(0, len(features) - 1, min(len(features), _PCA_SAMPLE)).astype(np.int64))
    pca = pca_of_samples(features.rows(sample), config.learning.pca_components)
    mean, components = pca.mean.astype(np.float32), pca.components.astype(np.float32)
    compressed, spread = np.empty((len(features), pca.output_dim), dtype=np.float32), np.empty(len(features))
    for covered, vectors in features.chunks():
        centred = vectors - mean
        compressed[covered], spread[covered] = centred @ components, np.linalg.norm(centred, axis=1)
    return compressed, spread, pca
