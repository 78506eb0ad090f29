"""One self-contained HTML page on a track."""

from __future__ import annotations

import json
from collections import Counter
from itertools import pairwise
from pathlib import Path

from andante.data import Status
from andante.evaluation.pages import render_page
from andante.evaluation.report import (
    COMMON,
    HEADINGS,
    METRES,
    conditions,
    mapped_places,
    share,
    shown_plots,
    texts_of,
    write_page,
)
from andante.evaluation.running import Run
from andante.evaluation.tracks import Track
from andante.mapping import SlowMap

_MOST_CHANGES = 40
_RECOVERY: dict[str, tuple[str, int | None]] = {
    "frames until it had settled": ("recovery_frames", 0),
    "worst outage, frames": ("recovery_worst_frames", 0),
    "ms in the filter": ("ms_filter", 1),
}
_TILES = (
    *("mean error, m", "95 % error, m", "more than 1 m off", "sure (ok) and more than 1 m off"),
    *("median heading error, °", "inside the 90 % radius", "frames until it had settled", "ms in the filter"),
)


def write_track_report(track: Track, folder: str | Path, slowmap: SlowMap) -> Path:
    """Write ``report.html`` to a folder, which is made where it does not exist; gives the path of the page.

    The page needs nothing but itself. Raises ``InputError`` where it cannot be written.
    """
    return write_page(folder, render_track(track, slowmap))


def render_track(track: Track, slowmap: SlowMap) -> str:
    """The page as text."""
    changes = status_changes(track.run)
    headings = HEADINGS if track.figures.heading_median_deg is not None else {}
    own = texts_of(track.figures.as_dict(), METRES | headings | COMMON | _RECOVERY)
    single = texts_of(track.single.figures.as_dict(), METRES | headings | COMMON)
    return render_page(
        "track.html.j2",
        map_name=slowmap.name,
        track=track,
        figures=track.figures,
        tiles=[(title, own[title]) for title in _TILES if title in own] if track.figures.n else [],
        table={title: (text, single.get(title, "")) for title, text in own.items()},
        statuses=_counts(track.run),
        plots=_plots(track, slowmap),
        changes=changes[:_MOST_CHANGES],
        more_changes=max(0, len(changes) - _MOST_CHANGES),
        sources=slowmap.sources,
        conditions=conditions(track.recording),
        config=json.dumps(slowmap.config.model_dump(mode="json"), indent=2),
    )


def status_changes(run: Run) -> list[dict[str, str]]:
    """The frames whose status is another than that of the frame before: image, time in seconds, status, reason."""
    frames = run.frames
    changed = [*frames[:1], *(b for a, b in pairwise(frames) if a.estimate.status is not b.estimate.status)]
    return [
        {
            "image": frame.info.image,
            "time": f"{frame.info.timestamp_s - frames[0].info.timestamp_s:.1f}",
            "status": str(frame.estimate.status),
            "reason": frame.estimate.reason,
        }
        for frame in changed
    ]


def _counts(run: Run) -> dict[str, int]:
    """How many frames have each status that occurs."""
    counts = Counter(frame.estimate.status for frame in run.frames)
    return {str(status): counts[status] for status in Status if counts[status]}


def _plots(track: Track, slowmap: SlowMap) -> list[dict[str, str]]:
    if not track.run.frames:
        return []
    from andante.evaluation import status_plots, track_plots

    drawn: list[tuple[str, str | None]] = [
        ("The way, with 90 % ellipses", track_plots.way(track.tracked, mapped_places(slowmap))),
        ("Error and status over time", status_plots.timeline(track.tracked, "m")),
    ]
    if track.figures.n:
        covered = [share(one.coverage_90) for one in (track.figures, track.single.figures)]
        drawn += [
            (f"Predicted radius: {covered[0]} of the answers lie within it", status_plots.calibration(track.tracked)),
            ("Single images: error and status over time", status_plots.timeline(track.single, "m")),
            (f"Single images: {covered[1]} of the answers lie within it", status_plots.calibration(track.single)),
        ]
    return shown_plots(*drawn)
