"""A recording through a tracker: what every image says by itself, and what comes of it over time."""

from __future__ import annotations

import time
from dataclasses import dataclass, field

from andante.data import Estimate, Frame, FrameInfo
from andante.evaluation.running import LocalizedFrame, Run, Skips
from andante.localization import Evidence, FixedLagSmoother, KalmanTracker, ParticleTracker
from andante.mapping import Progress
from andante.protocols import Recording
from andante.recordings import map_frames
from andante.sfa import one_thread


@dataclass(frozen=True, slots=True)
class TrackedRun:
    """One pass over a recording: ``track`` has every frame, ``single`` those whose picture could be read.

    ``filter_s`` are the seconds in ``fuse`` of every frame of the track; those of its frames themselves count seeing as
    well. The wall time is that of the pass for both, because seeing and fusing go on at the same time.
    """

    track: Run
    single: Run
    filter_s: tuple[float, ...] = field(repr=False)


def run_tracker(
    tracker: ParticleTracker | KalmanTracker,
    recording: Recording,
    *,
    lag: int | None = None,
    progress: Progress | None = None,
) -> TrackedRun:
    """See every picture in the threads that decode, with one BLAS thread each, and fuse them in order in this one.

    A picture that cannot be read is told to the tracker as a frame without evidence; more than 5 % of them raise
    ``RecordingError``. With ``lag`` every estimate is smoothed by so many frames that follow it.
    """
    fusion, singles = _Fusion(tracker, lag), list[LocalizedFrame]()
    skips = Skips(recording, progress)

    def see(frame: Frame) -> tuple[Evidence, float]:
        start = time.perf_counter()
        evidence = tracker.see(frame.image)
        return evidence, time.perf_counter() - start

    def go_blind(info: FrameInfo, reason: str) -> None:
        skips(info, reason)
        fusion.fuse(None, info, 0.0)

    start = time.perf_counter()
    with one_thread():
        # Skipped frames are told in their turn, so that the tracker gets all of them in order.
        for info, (evidence, seconds) in map_frames(recording, see, on_skip=go_blind):
            singles.append(LocalizedFrame(info, evidence.estimate, seconds))
            fusion.fuse(evidence, info, seconds)
            skips.tell(len(singles))
        tracked = fusion.finished()
    wall_s, skipped = time.perf_counter() - start, tuple(skips.seen)
    return TrackedRun(Run(tracked, skipped, wall_s), Run(tuple(singles), skipped, wall_s), tuple(fusion.filter_s))


class _Fusion:
    """A tracker with the estimates that it gave so far, or that its smoother gave late, and the time they took."""

    def __init__(self, tracker: ParticleTracker | KalmanTracker, lag: int | None) -> None:
        self._tracker = tracker
        self._smoother = None if lag is None else FixedLagSmoother(tracker, lag=lag)
        self._infos, self._seeing_s, self._told = list[FrameInfo](), list[float](), list[Estimate]()
        self.filter_s: list[float] = []

    def fuse(self, evidence: Evidence | None, info: FrameInfo, seeing_s: float) -> None:
        """The next frame, with the seconds that seeing it took."""
        start = time.perf_counter()
        told = (self._smoother.push if self._smoother else self._tracker.fuse)(evidence, info)
        self.filter_s.append(time.perf_counter() - start)
        self._infos.append(info)
        self._seeing_s.append(seeing_s)
        if told is not None:
            self._told.append(told)

    def finished(self) -> tuple[LocalizedFrame, ...]:
        """All frames in order."""
        if self._smoother is not None:
            self._told.extend(self._smoother.flush())
        rows = zip(self._infos, self._told, self._seeing_s, self.filter_s, strict=True)
        return tuple(LocalizedFrame(info, told, seeing_s + filter_s) for info, told, seeing_s, filter_s in rows)
