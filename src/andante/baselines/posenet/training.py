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
_BALANCE_RATE = 0.05
"""Learning rate of the two uncertainties: at that of the weights they would come too late to matter."""


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
    optimiser = torch.optim.AdamW(network.parameters(), weight_decay=schedule.weight_decay)
    balance = torch.optim.Adam(loss.parameters(), _BALANCE_RATE)
    pace, keeper = _Pace(schedule), _Keeper(network, schedule)
    batches, step = _batches(len(views), schedule.batch_size, generator), 0
    while not (pace.over(step) or keeper.gave_up(step)):
        for group in optimiser.param_groups:
            group["lr"] = schedule.learning_rate * _share_of_rate(step / pace.steps)
        batch = views[next(batches)]
        panoramas, heading = augmentation(batch.panoramas, batch.heading, generator)
        optimiser.zero_grad()
        balance.zero_grad()
        loss(*network(panoramas), batch.position, heading).backward()
        torch.nn.utils.clip_grad_norm_(network.parameters(), _CLIP)
        optimiser.step()
        balance.step()
        step += 1
        if step % schedule.validate_every == 0 or step == pace.steps:
            pace.adapt(step)
            progress(step, pace.steps)
            keeper.offer(step, median_error(network, held_out))
    if step and math.isinf(keeper.error):  # time was up before the first look
        keeper.offer(step, median_error(network, held_out))
    end = "all of them"
    if keeper.gave_up(step):
        end = f"stopped as {schedule.patience} validations brought nothing better"
    elif step < schedule.steps:
        end = f"no more in the budget of {schedule.max_seconds:g} s"
    network.load_state_dict(keeper.weights)
    network.eval()
    return Course(step, step * schedule.batch_size / len(views), keeper.error, end)


class _Pace:
    """How many ``steps`` there is time for; then the learning rate comes down to nothing on any machine."""

    def __init__(self, schedule: Schedule) -> None:
        self.steps = schedule.steps
        self._schedule, self._start = schedule, time.perf_counter()

    def over(self, step: int) -> bool:
        """Whether all steps are done, or time is up before that was foreseen."""
        return step >= self.steps or time.perf_counter() - self._start >= self._schedule.max_seconds

    def adapt(self, step: int) -> None:
        """Go by how long the steps so far took."""
        affordable = int(step * self._schedule.max_seconds / (time.perf_counter() - self._start))
        self.steps = max(step, min(self._schedule.steps, affordable))


class _Keeper:
    """The weights that did best so far, and the ``error`` that they had."""

    def __init__(self, network: PoseNetwork, schedule: Schedule) -> None:
        self.error, self._step = math.inf, 0
        self._network, self._patience = network, schedule.patience * schedule.validate_every
        self.weights = self._copied()

    def offer(self, step: int, error: float) -> None:
        """Keep the weights of now if they are better."""
        if error < self.error:
            self.error, self._step, self.weights = error, step, self._copied()

    def gave_up(self, step: int) -> bool:
        """Whether nothing better came for too long."""
        return step - self._step >= self._patience

    def _copied(self) -> dict[str, Tensor]:
        return {name: value.detach().clone() for name, value in self._network.state_dict().items()}


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
