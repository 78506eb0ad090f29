"""Images to slow features to steer by, learnt from one long drive of which only the order of images is known."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import Estimate, FloatArray, ImageArray, Status
from andante.mapping import FrontEnd, Progress
from andante.mapping.config import FeatureConfig, PanoramaConfig
from andante.mapping.frontend import camera_and_size
from andante.protocols import Observation, Recording
from andante.recordings import map_frames
from andante.sfa import KernelModel, KernelSFA, QuadraticSFA, SlowModel, one_thread

PANORAMA = PanoramaConfig(width_px=300, height_px=30, min_deg=5.0, max_deg=50.0)

Learner = Callable[[NDArray[np.float32]], SlowModel]
"""Features (n, d) in the order of time -> a slow model."""


@dataclass(frozen=True)
class SightRecipe:
    """Which features of a panorama, and what is learnt of them."""

    features: FeatureConfig
    learner: Learner


def _thesis_learner(features: NDArray[np.float32]) -> SlowModel:
    return QuadraticSFA(8, reduced_dim=20).fit(features).model_


def _kernel_learner(features: NDArray[np.float32]) -> SlowModel:
    return KernelSFA(30).fit(features).model_


THESIS_SIGHT = SightRecipe(
    FeatureConfig(kind="fourier", n_frequencies=15, normalise=False, orientations=0, unit=False), _thesis_learner
)
"""Thesis 9.2: 30 grey rows of 15 magnitudes, 450 -> 20 -> 230 -> 8."""
KERNEL_SIGHT = SightRecipe(FeatureConfig(kind="fourier", n_frequencies=15), _kernel_learner)
"""Normalised against light as in maps, 1350 numbers; 30 slow features of a sparse kernel expansion."""

_STRANGE = 3.0
"""In kernel widths: of 467 places on a lawn 99 % were nearer than 1.7, of those just outside 95 % farther than 3.2."""


@dataclass(frozen=True, eq=False)
class SlowSight:
    """What turns an image into the slow features that a ``SlowCost`` compares."""

    front_end: FrontEnd
    model: SlowModel

    @property
    def deltas(self) -> FloatArray:
        """(k,) how fast each slow feature changed from one training image to the next."""
        return self.model.deltas

    def localize(self, observation: Observation) -> tuple[Estimate, FloatArray]:
        """What ``drive`` asks for: no position, as nothing here knows any, but whether this was mapped, and slow
        features.

        Status off_map is for what looks like nothing in the training drive, which only kernel models can tell.
        """
        features = self.front_end.features(observation.image)[None]
        slow: FloatArray = self.model.transform(features)[0]
        if not isinstance(self.model, KernelModel):
            return Estimate(Status.LOST, "slow features alone tell no position"), slow
        novelty = float(self.model.novelty(features)[0])
        likeness = 1.0 / (1.0 + novelty / _STRANGE)
        if novelty > _STRANGE:
            reason = f"{novelty:.1f} kernel widths from all that was seen, at most {_STRANGE:g} are familiar"
            return Estimate(Status.OFF_MAP, reason, likeness=likeness), slow
        return Estimate(Status.LOST, "slow features alone tell no position", likeness=likeness), slow

    def slow(self, image: ImageArray) -> FloatArray:
        """(height, width[, 3]) uint8 -> (k,) slow features, slowest first; raises as ``FrontEnd.features`` does."""
        slow: FloatArray = self.model.transform(self.front_end.features(image)[None])[0]
        return slow


def learn_sight(
    recording: Recording, recipe: SightRecipe = KERNEL_SIGHT, *, progress: Progress | None = None
) -> SlowSight:
    """Learn from a drive that went everywhere; edges join each image with the next and nothing else.

    So none crosses an obstacle, however much both sides look alike. Raises as ``map_frames`` does, ``LearningError``
    for too little data.
    """
    front_end = FrontEnd(*camera_and_size(recording), PANORAMA, recipe.features)
    rows: list[NDArray[np.float32]] = []
    for _, vector in map_frames(recording, lambda frame: front_end.features(frame.image)):
        rows.append(vector)
        if progress is not None:
            progress(recording.name, len(rows), len(recording.infos))
    with one_thread():
        return SlowSight(front_end, recipe.learner(np.stack(rows)))
