"""A recording through a tracker: what every image says by itself, and what comes of it over time."""

from __future__ import annotations

import time
from dataclasses import dataclass, field
from typing import Protocol

from andante.data import Estimate, Fix, Frame, FrameInfo, ImageArray
from andante.evaluation.running import LocalizedFrame, Run, Skips
from andante.localization import Evidence
from andante.mapping import Progress
from andante.protocols import Recording
from andante.recordings import map_frames
from andante.sfa import one_thread


class SeeingTracker(Protocol):
    """A tracker in two halves: ``see`` has no state and may be called by many threads, ``fuse`` has it all."""

    @property
    def name(self) -> str:
        """The name in tables."""
        ...

    def see(self, image: ImageArray) -> Evidence:
        """What one image says; raises ``ImageError`` for a picture of another camera."""
        ...

    def fuse(self, evidence: Evidence | None, info: FrameInfo, fix: Fix | None = None) -> Estimate:
        """The estimate of now; without evidence by odometry alone."""
        ...


@dataclass(frozen=True, slots=True)
class TrackedRun:
    """One pass over a recording: ``track`` has every frame, ``single`` those whose picture could be read.

    ``filter_s`` are the seconds in ``fuse`` of every frame of the track; those of its frames themselves count seeing as
    well.
    """

    track: Run
    single: Run
    filter_s: tuple[float, ...] = field(repr=False)


def run_tracker(tracker: SeeingTracker, recording: Recording, *, progress: Progress | None = None) -> TrackedRun:
    """See every picture in the threads that decode, with one BLAS thread each, and fuse them in order in this one.

    A picture that cannot be read is told to the tracker as a frame without evidence; more than 5 % of them raise
    ``RecordingError``.
    """
    singles, tracked, filter_s = list[LocalizedFrame](), list[LocalizedFrame](), list[float]()
    skips = Skips(recording, progress)

    def see(frame: Frame) -> tuple[Evidence, float]:
        start = time.perf_counter()
        evidence = tracker.see(frame.image)
        return evidence, time.perf_counter() - start

    def fuse(info: FrameInfo, evidence: Evidence | None, seeing_s: float) -> None:
        start = time.perf_counter()
        estimate = tracker.fuse(evidence, info)
        filter_s.append(time.perf_counter() - start)
        tracked.append(LocalizedFrame(info, estimate, seeing_s + filter_s[-1]))
        skips.tell(len(singles))

    def go_blind(info: FrameInfo, reason: str) -> None:
        skips(info, reason)
        fuse(info, None, 0.0)

    start = time.perf_counter()
    with one_thread():
        # Skipped frames are told in their turn, so that the tracker gets all of them in order.
        for info, (evidence, seconds) in map_frames(recording, see, on_skip=go_blind):
            singles.append(LocalizedFrame(info, evidence.estimate, seconds))
            fuse(info, evidence, seconds)
    wall_s, skipped = time.perf_counter() - start, tuple(skips.seen)
    seen = Run(tuple(singles), skipped, wall_s - sum(filter_s))
    return TrackedRun(Run(tuple(tracked), skipped, wall_s), seen, tuple(filter_s))
