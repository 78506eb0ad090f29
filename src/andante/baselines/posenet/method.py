"""PoseNet: a network that is shown pictures with their poses until it tells the pose of others."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from importlib.util import find_spec
from typing import TYPE_CHECKING

import numpy as np

from andante.baselines.drives import Drives, read_drives
from andante.baselines.method import Learned
from andante.baselines.posenet.pictures import evened, front_end_of
from andante.baselines.posenet.schedule import CHANNEL_GROUP, Schedule
from andante.data import FloatArray, PoseSource
from andante.errors import ConfigError, LearningError, MissingExtraError, RecordingError
from andante.mapping import FrontEnd, Progress
from andante.protocols import Recording

if TYPE_CHECKING:  # torch costs seconds to import and is an extra
    from andante.baselines.posenet.network import PoseNetwork
    from andante.baselines.posenet.training import Course

HELD_OUT_EVERY = 4
"""Every fourth picture validates and teaches nothing (thesis 7.4)."""


@dataclass(frozen=True)
class PoseNet:
    """A ``Method``: PoseNet 2017 (Kendall & Cipolla), as the thesis compares with, made as good as two cores allow.

    From the thesis and the paper are the unwrapped panoramas, the validation on every fourth picture, and the loss that
    weighs position and heading by learnt uncertainties. Weights that were learnt elsewhere there are none: the network
    is small, starts from chance, and is made for panoramas (``PoseNetwork``). The same recordings and settings give
    the same weights, unless time runs out. Elevations end at 30 degrees: trained on a single drive, a network that
    sees more of the sky finds its way by the clouds of that day.
    ``channels`` are a multiple of 8. Raises ``ConfigError`` for others.
    """

    width_px: int = 256
    height_px: int = 24
    elevation_deg: tuple[float, float] = (3.0, 30.0)
    channels: int = 24
    schedule: Schedule = field(default_factory=Schedule)

    def __post_init__(self) -> None:
        if self.channels < 1 or self.channels % CHANNEL_GROUP:
            raise ConfigError(f"channels of posenet must be a multiple of {CHANNEL_GROUP}, got {self.channels}")

    @property
    def name(self) -> str:
        """The name in tables."""
        return "posenet"

    def learn(
        self, recordings: Sequence[Recording], *, positions: PoseSource = "reference", progress: Progress | None = None
    ) -> Learned:
        """Train on all frames with a position; raises as ``Method.learn`` says."""
        if find_spec("torch") is None:
            raise MissingExtraError("torch", "torch")
        if not recordings:
            raise RecordingError("posenet needs at least one recording to learn from, got none")
        from andante.baselines.posenet.localizer import PoseNetLocalizer

        front_end = front_end_of(recordings[0], self.width_px, self.height_px, self.elevation_deg)
        drives = read_drives(recordings, front_end, positions, progress=progress)
        centre, scale_m = _unit_of(drives.xy)
        start = time.perf_counter()
        network, course = self._trained(drives, front_end, (drives.xy - centre) / scale_m, progress)
        seconds = time.perf_counter() - start
        if not np.isfinite(course.validation):
            raise LearningError(
                f"posenet did not converge: no finite position after {course.steps} steps; lower the learning rate, "
                f"which is {self.schedule.learning_rate:g}, or give it more than {self.schedule.max_seconds:g} s"
            )
        count = sum(weights.numel() for weights in network.parameters())
        localizer = PoseNetLocalizer(front_end, network, centre, scale_m, bool(np.isfinite(drives.heading).any()))
        return Learned(localizer, drives.seconds, seconds, 4 * count, _notes(drives, course, count, scale_m))

    def _trained(
        self, drives: Drives, front_end: FrontEnd, position: FloatArray, progress: Progress | None
    ) -> tuple[PoseNetwork, Course]:
        import torch

        from andante.baselines.posenet.augmentation import Augmentation
        from andante.baselines.posenet.network import PoseNetwork
        from andante.baselines.posenet.training import Views, threads_and_seed, train

        wrap = front_end.camera.heading_invariant
        pictures = np.ascontiguousarray(evened(drives.panoramas, wrap=wrap)[:, None])
        views = Views(
            torch.from_numpy(pictures), torch.from_numpy(position).float(), torch.from_numpy(drives.heading).float()
        )
        held_out = torch.arange(len(views)) % HELD_OUT_EVERY == HELD_OUT_EVERY - 1

        def told(step: int, steps: int) -> None:
            if progress is not None:
                progress(self.name, step, steps)

        with threads_and_seed(self.schedule.threads, self.schedule.seed) as generator:
            network = PoseNetwork(front_end.panorama_shape, wrap=wrap, channels=self.channels)
            course = train(
                network,
                views[~held_out],
                views[held_out],
                Augmentation(turn=wrap),
                self.schedule,
                generator=generator,
                progress=told,
            )
        return network, course


def _unit_of(xy: FloatArray) -> tuple[FloatArray, float]:
    """Middle (2,) and deviation of the positions, in metres; raises ``LearningError`` where they teach nothing."""
    if len(xy) < 2 * HELD_OUT_EVERY:
        raise LearningError(
            f"posenet needs at least {2 * HELD_OUT_EVERY} frames, got {len(xy)}; every {HELD_OUT_EVERY}th is held out"
        )
    scale_m = float(xy.std(axis=0).max())
    if scale_m == 0:
        raise LearningError(f"all {len(xy)} frames have the same position; posenet needs a drive around the place")
    return xy.mean(axis=0), scale_m


def _notes(drives: Drives, course: Course, parameters: int, scale_m: float) -> tuple[str, ...]:
    held_out = len(drives.xy) // HELD_OUT_EVERY
    notes = [
        f"{parameters} parameters, from chance",
        f"{len(drives.xy) - held_out} frames learnt, {course.steps} steps or {course.epochs:.0f} epochs: {course.end}",
        f"median error on {held_out} frames held out (every {HELD_OUT_EVERY}th): {course.validation * scale_m:.2f} m",
    ]
    return (*notes, f"{drives.skipped} frames skipped") if drives.skipped else tuple(notes)
