"""Learns to find landmarks from a few hundred labels, on a CPU, in minutes. Needs the extras ``torch`` and ``onnx``."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from threadpoolctl import threadpool_limits  # type: ignore[import-untyped]

from andante.camera import PanoramaGeometry
from andante.errors import ConfigError, InputError, LearningError, MissingExtraError
from andante.landmarks.detector import LandmarkDetector
from andante.landmarks.detector_file import DetectorHeader, Landmark, written
from andante.landmarks.examples import Progress, Taught, divided, gathered
from andante.landmarks.heatmaps import Grid
from andante.landmarks.layout import COARSEST, STRIDE
from andante.landmarks.scoring import NEVER, Score, fitted
from andante.protocols import Recording

if TYPE_CHECKING:
    from andante.landmarks.verdict import Places

_JUDGED = 300
"""Held-out pictures, each in light of its own, from which scores are learnt."""


@dataclass(frozen=True, slots=True)
class TrainingConfig:
    """How to learn; raises ``ConfigError`` for values that make no sense.

    The share ``held_out`` decides when to stop (after ``patience`` looks at it, one every ``check_every`` steps,
    without getting better) and what a score is worth: the share ``false_positives`` of wrong places in it may pass for
    a landmark. ``max_seconds`` may end it sooner; twelve pictures a step take about 0.3 s on one core. Two ``threads``
    are a little faster on a quiet machine, and many times slower on a busy one, where they wait for each other.
    """

    geometry: PanoramaGeometry = field(default_factory=lambda: PanoramaGeometry(640, 112, -5.0, 60.0))
    steps: int = 600
    batch: int = 12
    learning_rate: float = 4e-3
    held_out: float = 0.2
    check_every: int = 50
    patience: int = 4
    max_seconds: float = 300.0
    least_labels: int = 20
    most_labels: int = 500
    false_positives: float = 0.1
    threads: int = 1
    seed: int = 0

    def __post_init__(self) -> None:
        if self.geometry.width_px % COARSEST or self.geometry.height_px % COARSEST:
            raise ConfigError(
                f"the sides of the panorama must be multiples of {COARSEST} px, got {self.geometry.width_px} x "
                f"{self.geometry.height_px}"
            )
        if not 0.05 <= self.held_out <= 0.5:
            raise ConfigError(f"held_out = {self.held_out:g} is not allowed; use a share from 0.05 to 0.5")
        if not 0.0 < self.false_positives < 1.0:
            raise ConfigError(f"false_positives = {self.false_positives:g} is not allowed; use a share between 0 and 1")
        counts = "steps", "batch", "check_every", "patience", "least_labels", "most_labels", "threads"
        for name in (*counts, "learning_rate", "max_seconds"):
            if not getattr(self, name) > 0:
                raise ConfigError(f"{name} = {getattr(self, name):g} is not allowed; use a positive number")


def train_detector(
    taught: Taught,
    config: TrainingConfig | None = None,
    *,
    elsewhere: Sequence[Recording] = (),
    progress: Progress | None = None,
) -> LandmarkDetector:
    """A detector of all landmarks that ``taught`` has labels of.

    Recordings ``elsewhere`` show none of them, and make false positives rarer. ``progress`` is told of ``read`` and
    ``learn``. The detector's ``header.notes`` say how it was learnt and what it reached on what was held out. The same
    for the same seed, data and machine. A landmark that cannot be told from its surroundings is never found, and the
    notes say why. Raises ``InputError`` for labels that cannot be used, ``LearningError`` where no landmark can be told
    from its surroundings, ``MissingExtraError`` without torch, onnx or onnxruntime.
    """
    _require_extras()
    from andante.landmarks.learning import learnt, random_days
    from andante.landmarks.verdict import best_places

    config = config or TrainingConfig()
    _check_elsewhere(taught, elsewhere)
    grid = Grid(config.geometry, STRIDE)
    names, examples = gathered(
        taught, elsewhere, grid, most=config.most_labels, least=config.least_labels, progress=progress
    )
    learning, held_out = divided(examples, config.held_out)
    for number, name in enumerate(names):
        if not (learning.present[:, number].any() and held_out.present[:, number].any()):
            raise LearningError(f"landmark {name!r} has too few labels to hold some out; teach more, or raise held_out")
    rng = np.random.default_rng([config.seed, 2])
    pictures = random_days(held_out, grid, rng, batch=config.batch, most=-(-_JUDGED // config.batch))
    with threadpool_limits(config.threads):
        network, notes = learnt(learning, held_out, grid, config, progress)
        places_of = best_places(network, pictures, grid)
    landmarks, reached, failed = [], {}, dict[str, str]()
    for name, places in zip(names, places_of, strict=True):
        try:
            score = _score(name, places, config.false_positives)
        except LearningError as error:
            score, failed[name] = NEVER, str(error)
        landmarks.append(Landmark(name=name, slope=score.slope, offset=score.offset, threshold=score.threshold))
        reached[name] = places.figures(score.of(places.heat) >= score.threshold)
    if len(failed) == len(names):
        raise LearningError(failed[names[0]])
    used = dict(zip(names, examples.present.sum(axis=0).tolist(), strict=True))
    notes |= {"examples": len(learning), "labels": used, "held_out": reached, "never_found": failed}
    return LandmarkDetector(written(DetectorHeader.of(config.geometry, tuple(landmarks), notes), network.folded()))


def _check_elsewhere(taught: Taught, elsewhere: Sequence[Recording]) -> None:
    """A recording cannot show a landmark and show none."""
    taught_in = {recording.content_hash() for recording, _ in taught}
    for one in elsewhere:
        if one.content_hash() in taught_in:
            raise InputError(
                f"landmarks were taught in recording {one.name!r}, so it is not one that shows none of them; leave it "
                "out of --elsewhere"
            )


def _score(name: str, places: Places, false_positives: float) -> Score:
    """The score of one landmark."""
    heat = np.concatenate([places.heat, places.beside])
    right = np.concatenate([places.right, np.zeros(len(places.beside), np.bool_)])
    try:
        return fitted(heat, right, false_positives)
    except LearningError as error:
        raise LearningError(f"landmark {name!r}: {error}") from None


def _require_extras() -> None:
    """Before minutes of work, not after."""
    for package, extra in (("torch", "torch"), ("onnx", "onnx"), ("onnxruntime", "landmarks")):
        try:
            __import__(package)
        except ImportError:
            raise MissingExtraError(package, extra) from None
