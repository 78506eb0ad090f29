"""Learning the weights of PoseNet on the spot: AdamW, a warm-up and a cosine, and a clock."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import torch
from torch import Tensor

from andante.baselines.posenet.augmentation import Augmentation
from andante.baselines.posenet.loss import GeometricLoss
from andante.baselines.posenet.network import PoseNetwork
from andante.baselines.posenet.schedule import Schedule

_WARM_UP = 0.05
_CLIP = 1.0
"""Norm that gradients are clipped to."""


@dataclass(frozen=True, slots=True, eq=False)
class Views:
    """Panoramas (n, 1, height, width), their positions (n, 2) in the network's unit and headings (n,)."""

    panoramas: Tensor
    position: Tensor
    heading: Tensor

    def __len__(self) -> int:
        return len(self.panoramas)

    def __getitem__(self, rows: Tensor) -> Views:
        return Views(self.panoramas[rows], self.position[rows], self.heading[rows])


@dataclass(frozen=True, slots=True)
class Course:
    """How learning went: batches, passes over the pictures, the best median of validation, and why it ended."""

    steps: int
    epochs: float
    validation: float
    end: str


@contextmanager
def threads_and_seed(threads: int, seed: int) -> Iterator[torch.Generator]:
    """Inside, torch works in so many threads and all its chance comes from the seed; both are put back after it."""
    before = torch.get_num_threads()
    torch.set_num_threads(threads)
    try:
        with torch.random.fork_rng(devices=[]):
            torch.manual_seed(seed)
            yield torch.Generator().manual_seed(seed)
    finally:
        torch.set_num_threads(before)


def train(
    network: PoseNetwork,
    views: Views,
    held_out: Views,
    augmentation: Augmentation,
    schedule: Schedule,
    *,
    generator: torch.Generator,
    progress: Callable[[int, int], None],
) -> Course:
    """Learn from ``views``; the network is left with the weights that did best on ``held_out``."""
    loss = GeometricLoss()
    optimiser = torch.optim.AdamW(
        [
            {"params": network.parameters(), "weight_decay": schedule.weight_decay},
            {"params": loss.parameters(), "weight_decay": 0.0},
        ],
        lr=schedule.learning_rate,
    )
    start, best, best_step, end = time.perf_counter(), math.inf, 0, "all steps done"
    kept = _copied(network)
    batches = _batches(len(views), schedule.batch_size, generator)
    step = 0
    while step < schedule.steps:
        # Time runs out as gently as steps do: the rate has come down to nothing when either is used up.
        spent = max(step / schedule.steps, (time.perf_counter() - start) / schedule.max_seconds)
        if spent >= 1:
            end = f"stopped by the budget of {schedule.max_seconds:g} s"
            break
        for group in optimiser.param_groups:
            group["lr"] = schedule.learning_rate * _share_of_rate(spent)
        batch = views[next(batches)]
        panoramas, heading = augmentation(batch.panoramas, batch.heading, generator)
        optimiser.zero_grad(set_to_none=True)
        loss(*network(panoramas), batch.position, heading).backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), _CLIP)
        optimiser.step()
        step += 1
        if step % schedule.validate_every == 0 or step == schedule.steps:
            progress(step, schedule.steps)
            error = median_error(network, held_out)
            if error < best:
                best, best_step, kept = error, step, _copied(network)
            elif step - best_step >= schedule.patience * schedule.validate_every:
                end = f"stopped as {schedule.patience} validations brought nothing better"
                break
    network.load_state_dict(kept)
    network.eval()
    return Course(step, step * schedule.batch_size / len(views), best, end)


def median_error(network: PoseNetwork, views: Views) -> float:
    """Median distance of the positions, in the network's unit."""
    network.eval()
    with torch.inference_mode():
        parts = [network(part)[0] for part in torch.split(views.panoramas, 64)]
    network.train()
    return float(torch.linalg.vector_norm(torch.cat(parts) - views.position, dim=1).median())


def _batches(count: int, size: int, generator: torch.Generator) -> Iterator[Tensor]:
    """Rows in random order, all of them before any comes again."""
    rows = torch.empty(0, dtype=torch.int64)
    while True:
        while len(rows) < size:
            rows = torch.cat([rows, torch.randperm(count, generator=generator)])
        yield rows[:size]
        rows = rows[size:]


def _share_of_rate(spent: float) -> float:
    """Of the highest learning rate, after a share of the training: linear warm-up, then half a cosine."""
    if spent < _WARM_UP:
        return (spent + 1e-3) / (_WARM_UP + 1e-3)
    return 0.5 * (1 + math.cos(math.pi * (spent - _WARM_UP) / (1 - _WARM_UP)))


def _copied(network: PoseNetwork) -> dict[str, Tensor]:
    return {name: value.detach().clone() for name, value in network.state_dict().items()}
