"""Learns to find landmarks from a few hundred labels, on a CPU, in minutes. Needs the extras ``torch`` and ``onnx``."""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from andante.camera import PanoramaGeometry
from andante.errors import ConfigError, LearningError, MissingExtraError
from andante.landmarks.detector import LandmarkDetector
from andante.landmarks.detector_file import DetectorHeader, Landmark, written
from andante.landmarks.examples import Examples, Progress, Taught, divided, gathered
from andante.landmarks.heatmaps import Grid, targets
from andante.landmarks.layout import COARSEST, STRIDE
from andante.landmarks.scoring import Score, fitted
from andante.protocols import Recording

if TYPE_CHECKING:
    from andante.landmarks.augmentation import Batch
    from andante.landmarks.network import LandmarkNetwork
    from andante.landmarks.verdict import Places

_JUDGED = 300
"""Held-out pictures, each in light of its own, from which scores are learnt."""

_KEPT = 0.98


@dataclass(frozen=True, slots=True)
class TrainingConfig:
    """How to learn; raises ``ConfigError`` for values that make no sense.

    A third of ``held_out`` examples would be too many: they decide when to stop (after ``patience`` looks, one every
    ``check_every`` steps, without getting better) and what a score is worth. ``false_positives`` is the share of wrong
    places on them that may pass for the landmark.
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
    false_positives: float = 0.005
    seed: int = 0

    def __post_init__(self) -> None:
        if self.geometry.width_px % COARSEST or self.geometry.height_px % COARSEST:
            raise ConfigError(
                f"the sides of the panorama must be multiples of {COARSEST} px, got {self.geometry.width_px} x "
                f"{self.geometry.height_px}"
            )
        if not 0.05 <= self.held_out <= 0.5:
            raise ConfigError(f"held_out = {self.held_out:g} is not allowed; use a share from 0.05 to 0.5")
        positive = "steps", "batch", "learning_rate", "check_every", "patience", "max_seconds", "least_labels"
        for name in positive:
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
    for the same seed, data and machine. Raises ``InputError`` for labels that cannot be used, ``LearningError`` where a
    landmark cannot be told from its surroundings, ``MissingExtraError`` without torch, onnx or onnxruntime.
    """
    _require_extras()
    from andante.landmarks.verdict import best_places

    config = config or TrainingConfig()
    grid = Grid(config.geometry, STRIDE)
    names, examples = gathered(
        taught, elsewhere, grid, most=config.most_labels, least=config.least_labels, progress=progress
    )
    learning, held_out = divided(examples, config.held_out)
    for number, name in enumerate(names):
        if not (learning.present[:, number].any() and held_out.present[:, number].any()):
            raise LearningError(f"landmark {name!r} has too few labels to hold some out; teach more, or raise held_out")
    network, notes = _learnt(learning, held_out, grid, config, progress)
    pictures = _batches(held_out, config, grid, np.random.default_rng([config.seed, 2]), most=_judging(config))
    landmarks, reached = [], {}
    for name, places in zip(names, best_places(network, pictures, grid), strict=True):
        score = _score(name, places, config.false_positives)
        landmarks.append(Landmark(name=name, slope=score.slope, offset=score.offset, threshold=score.threshold))
        reached[name] = places.figures(score.of(places.heat) >= score.threshold)
    notes |= {"examples": len(learning), "held_out": reached}
    return LandmarkDetector(written(DetectorHeader.of(config.geometry, tuple(landmarks), notes), network.folded()))


def _judging(config: TrainingConfig) -> int:
    """Number of batches from which scores are learnt."""
    return -(-_JUDGED // config.batch)


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


def _learnt(
    learning: Examples, held_out: Examples, grid: Grid, config: TrainingConfig, progress: Progress | None
) -> tuple[LandmarkNetwork, dict[str, Any]]:
    """The network with the lowest loss on what is held out, averaged over steps, and how it came about."""
    import torch

    from andante.landmarks.network import LandmarkNetwork, averaged_in

    started = time.monotonic()
    rng = np.random.default_rng([config.seed, 0])
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        network = LandmarkNetwork(learning.known.shape[1])
    average = copy.deepcopy(network)
    optimizer = torch.optim.AdamW(network.parameters(), lr=config.learning_rate, weight_decay=1e-3)
    rates = torch.optim.lr_scheduler.OneCycleLR(optimizer, config.learning_rate, total_steps=config.steps)
    checks = list(_batches(held_out, config, grid, np.random.default_rng([config.seed, 1]), most=8))
    best, best_loss, since, step, why = copy.deepcopy(network), np.inf, 0, 0, "all steps done"
    for step, batch in enumerate(_batches(learning, config, grid, rng, most=config.steps), start=1):
        network.train()
        optimizer.zero_grad()
        _loss(network, batch, grid).backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), 10.0)
        optimizer.step()
        rates.step()
        averaged_in(average, network, min(_KEPT, step / (step + 9.0)))
        if progress is not None:
            progress("learn", step, config.steps)
        late = time.monotonic() - started > config.max_seconds
        if step % config.check_every and step < config.steps and not late:
            continue
        held_out_loss = _held_out_loss(average, checks, grid)
        since = 0 if held_out_loss < best_loss else since + 1
        if since == 0:
            best, best_loss = copy.deepcopy(average), held_out_loss
        if late or since >= config.patience:
            why = "no time left" if late else "no better on what is held out"
            break
    best.eval()
    return best, {
        "steps": step,
        "seconds": round(time.monotonic() - started, 1),
        "stopped": why,
        "held_out_loss": round(float(best_loss), 4),
    }


def _batches(
    examples: Examples, config: TrainingConfig, grid: Grid, rng: np.random.Generator, *, most: int
) -> Iterator[Batch]:
    """Augmented batches, every example once before any comes again."""
    from andante.landmarks.augmentation import augmented

    order = np.empty(0, np.int64)
    for _ in range(most):
        while len(order) < config.batch:
            order = np.concatenate([order, rng.permutation(len(examples))])
        rows, order = order[: config.batch], order[config.batch :]
        chosen = examples.chosen(rows)
        yield augmented(chosen.panoramas, chosen.cells, chosen.known, grid, rng)


def _loss(network: LandmarkNetwork, batch: Batch, grid: Grid) -> Any:  # noqa: ANN401 (torch is not imported here)
    import torch

    from andante.landmarks.network import loss

    counts = torch.from_numpy(batch.counts.astype(np.float32))
    return loss(network(batch.pictures), targets(batch.cells, grid), counts)


def _held_out_loss(network: LandmarkNetwork, checks: Sequence[Batch], grid: Grid) -> float:
    import torch

    network.eval()
    with torch.no_grad():
        return float(np.mean([float(_loss(network, batch, grid)) for batch in checks]))
