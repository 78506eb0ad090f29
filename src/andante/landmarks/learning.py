"""Learns the network of the landmark detector: random days, and the network that did best on what was held out.

Imported only by ``training``, where torch is there for certain.
"""

from __future__ import annotations

import copy
import time
from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import torch
from torch import Tensor

from andante.landmarks.augmentation import Batch, augmented
from andante.landmarks.examples import Examples, Progress
from andante.landmarks.heatmaps import Grid, targets
from andante.landmarks.network import LandmarkNetwork, averaged_in, loss

if TYPE_CHECKING:
    from andante.landmarks.training import TrainingConfig

_KEPT = 0.98
"""Of the averaged weights at each step: noise of the last fifty steps is averaged out."""

_WEIGHT_DECAY = 1e-3
_LONGEST_GRADIENT = 10.0
_CHECKS = 8


def learnt(
    learning: Examples, held_out: Examples, grid: Grid, config: TrainingConfig, progress: Progress | None
) -> tuple[LandmarkNetwork, dict[str, Any]]:
    """The network with the lowest loss on what is held out, its weights averaged over steps; how it came about."""
    started = time.monotonic()
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(config.seed)
        network = LandmarkNetwork(learning.known.shape[1])
    average = copy.deepcopy(network)
    best = _Best(average, config.patience)
    optimizer = torch.optim.AdamW(network.parameters(), lr=config.learning_rate, weight_decay=_WEIGHT_DECAY)
    days = (np.random.default_rng([config.seed, stream]) for stream in (0, 1))
    batches = random_days(learning, grid, next(days), batch=config.batch, most=config.steps)
    checks = list(random_days(held_out, grid, next(days), batch=config.batch, most=_CHECKS))
    step, why = 0, "all steps done"
    for step, batch in enumerate(batches, start=1):
        spent = (time.monotonic() - started) / config.max_seconds
        for group in optimizer.param_groups:
            group["lr"] = config.learning_rate * _rate(max(step / config.steps, spent))
        _descend(network, optimizer, batch, grid)
        averaged_in(average, network, min(_KEPT, step / (step + 9.0)))
        if progress is not None:
            progress("learn", step, config.steps)
        if step % config.check_every == 0 or step == config.steps or spent >= 1.0:
            best.look_at(average, _mean_loss(average, checks, grid))
        if step < config.steps and (spent >= 1.0 or best.settled):
            why = "no time left" if spent >= 1.0 else "no better on what is held out"
            break
    notes = {"steps": step, "seconds": round(time.monotonic() - started, 1), "stopped": why}
    return best.network, {**notes, "held_out_loss": round(best.loss, 4)}


def random_days(examples: Examples, grid: Grid, rng: np.random.Generator, *, batch: int, most: int) -> Iterator[Batch]:
    """``most`` augmented batches, every example once before any comes again."""
    order = np.empty(0, np.int64)
    for _ in range(most):
        while len(order) < batch:
            order = np.concatenate([order, rng.permutation(len(examples))])
        rows, order = order[:batch], order[batch:]
        yield augmented(examples.chosen(rows), grid, rng)


class _Best:
    """The network with the lowest loss so far, ready to use; ``settled`` after ``patience`` looks without a lower."""

    def __init__(self, network: LandmarkNetwork, patience: int) -> None:
        self.network, self.loss, self._patience, self._since = copy.deepcopy(network).eval(), float("inf"), patience, 0

    def look_at(self, network: LandmarkNetwork, loss: float) -> None:
        self._since += 1
        if loss < self.loss:
            self.network, self.loss, self._since = copy.deepcopy(network).eval(), loss, 0

    @property
    def settled(self) -> bool:
        return self._since >= self._patience


def _descend(network: LandmarkNetwork, optimizer: torch.optim.Optimizer, batch: Batch, grid: Grid) -> None:
    """One step downhill."""
    network.train()
    optimizer.zero_grad()
    _loss(network, batch, grid).backward()  # type: ignore[no-untyped-call]
    torch.nn.utils.clip_grad_norm_(network.parameters(), _LONGEST_GRADIENT)
    optimizer.step()


def _rate(done: float) -> float:
    """Share of the learning rate: up during the first tenth, down to nothing at the end of all steps or of the time."""
    return min(done / 0.1, 0.5 + 0.5 * float(np.cos(np.pi * min(done, 1.0))))


def _loss(network: LandmarkNetwork, batch: Batch, grid: Grid) -> Tensor:
    counts = torch.from_numpy(batch.counts.astype(np.float32))
    return loss(network(batch.pictures), targets(batch.cells, grid), counts)


def _mean_loss(network: LandmarkNetwork, batches: Sequence[Batch], grid: Grid) -> float:
    network.eval()
    with torch.no_grad():
        return float(np.mean([float(_loss(network, batch, grid)) for batch in batches]))
