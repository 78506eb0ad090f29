"""A map and a recording with odometry in, a track out; with truth, how far it is to be believed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from andante.data import FrameInfo
from andante.evaluation.alignment import alignment_of
from andante.evaluation.comparison import ODOMETRY_NOTE, Scored, leakage_notes
from andante.evaluation.figures import Figures, errors_of, figures_of_run
from andante.evaluation.recovery import recovery_of
from andante.evaluation.running import Run
from andante.evaluation.tracking import TrackedRun, run_tracker
from andante.localization import TrackerKind, make_tracker
from andante.mapping import Progress, SlowMap
from andante.protocols import Recording

_LAG = 20


@dataclass(frozen=True, kw_only=True)
class TrackFigures(Figures):
    """One tracker on one recording: errors as those of single images, of the best hypothesis of all frames with truth.

    ``recovery_frames`` are those from the start to the first lasting run of frames whose status is ok and that are
    right, ``recovery_median_frames`` and ``recovery_worst_frames`` are over all ``outages``, of which ``unrecovered``
    (0 or 1) lasted to the end (see ``recovery_of``). ``ms_filter`` is the median time of a frame beyond that of its
    single image.
    """

    recovery_frames: int | None
    recovery_median_frames: float | None
    recovery_worst_frames: int | None
    outages: int
    unrecovered: int
    ms_filter: float | None


@dataclass(frozen=True)
class Track:
    """What a tracker said of every frame, beside what every ``single`` image said by itself.

    The figures of a recording without truth have ``n`` = 0 and are otherwise ``None``; ``notes`` say what to keep in
    mind.
    """

    recording: Recording
    filter: TrackerKind
    seed: int
    smoothed: bool
    tracked: Scored
    single: Scored
    figures: TrackFigures
    notes: tuple[str, ...] = ()

    @property
    def run(self) -> Run:
        """What the tracker said of every frame."""
        return self.tracked.run

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: the track's figures, and those of single images."""
        return {
            **self.figures.as_dict(),
            "recording": self.recording.name,
            "filter": self.filter,
            "seed": self.seed,
            "smoothed": self.smoothed,
            "frames": len(self.run.frames),
            "single": self.single.figures.as_dict(),
            "notes": list(self.notes),
            "skipped": [{"image": one.image, "reason": one.reason} for one in self.run.skipped],
        }


def track(
    slowmap: SlowMap,
    recording: Recording,
    *,
    kind: TrackerKind = "particles",
    seed: int = 0,
    smooth: bool = False,
    state: str | Path | None = None,
    training_error: bool = False,
    progress: Progress | None = None,
) -> Track:
    """Follow a robot through a recording, by its images and, where there is any, its odometry.

    ``smooth`` corrects every pose by the 20 frames that follow it. ``state`` is a file from which the tracker goes on
    where it exists, and into which it is saved at the end. Raises ``LeakageError`` for a recording that the map was
    learnt from, as ``evaluate`` does, unless ``training_error`` asks for it, and ``InputError`` for a map of numbered
    places, which has no metres to move by.
    """
    notes = (*leakage_notes(slowmap, recording, training_error), *_odometry_notes(recording.name, recording.infos))
    slowmap = slowmap.for_recording(recording)
    tracker = make_tracker(slowmap, kind, seed=seed)
    if state is not None and Path(state).exists():
        tracker.resume(Path(state))
    done = run_tracker(tracker, recording, lag=_LAG if smooth else None, progress=progress)
    if state is not None:
        tracker.save(Path(state))
    if slowmap.config.positions == "odometry" and any(info.reference for info in recording.infos):
        alignment = alignment_of(slowmap, done.single)
        notes = (*notes, ODOMETRY_NOTE if alignment is None else str(alignment))
        if alignment is not None:
            moved = alignment.truth_in_map
            done = replace(done, track=moved(done.track), single=moved(done.single))
    name = f"{tracker.name}, smoothed" if smooth else tracker.name
    tracked = Scored(name, done.track, errors_of(done.track, "m"), figures_of_run(done.track, "m"))
    single = Scored(slowmap.name, done.single, errors_of(done.single, "m"), figures_of_run(done.single, "m"))
    return Track(recording, kind, seed, smooth, tracked, single, figures_of_track(done), notes)


def figures_of_track(done: TrackedRun) -> TrackFigures:
    """Figures over all frames of a track that have truth."""
    statuses = [frame.estimate.status for frame in done.track.frames]
    recovery = recovery_of(statuses, errors_of(done.track, "m"))
    return TrackFigures(
        **vars(figures_of_run(done.track, "m")),
        recovery_frames=recovery.first,
        recovery_median_frames=recovery.median,
        recovery_worst_frames=recovery.worst,
        outages=recovery.outages,
        unrecovered=recovery.unrecovered,
        ms_filter=1000 * float(np.median(done.filter_s)) if done.filter_s else None,
    )


def _odometry_notes(name: str, infos: Sequence[FrameInfo]) -> tuple[str, ...]:
    """What to know of a recording whose frames do not all have odometry."""
    lacking = sum(info.odometry is None for info in infos)
    if not lacking:
        return ()
    if lacking == len(infos):
        return (f"recording {name!r} has no odometry (odom_x_m, odom_y_m in frames.csv): tracked by images alone",)
    return (f"{lacking} of {len(infos)} frames of recording {name!r} have no odometry: there the images are alone",)
