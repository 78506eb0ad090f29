"""``andante track``: a map and a recording in, a pose at every frame out, with odometry where there is any."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from andante.cli.options import (
    AsJson,
    CsvFile,
    MapFile,
    ReportFolder,
    TrainingError,
    TumFile,
    check_folder,
    check_place,
)
from andante.cli.output import examples, hint, print_facts, print_json, print_table, progress_bars

if TYPE_CHECKING:
    from andante.evaluation import Track

EPILOG = examples(
    "andante track garden.andante garden/sunday",
    "andante track garden.andante garden/sunday --report report --tum sunday.tum",
    "andante track garden.andante garden/sunday --filter kalman --json",
    "andante track garden.andante garden/sunday --smooth --csv sunday.csv",
    "andante track garden.andante garden/part-2 --state robot.state",
)

_ROWS = {
    "mean [m]": "mean_m",
    "median [m]": "median_m",
    "p95 [m]": "p95_m",
    "max [m]": "max_m",
    "> 1 m [%]": "share_over_1m",
    "heading median [deg]": "heading_median_deg",
    "heading p95 [deg]": "heading_p95_deg",
    "without a pose [%]": "lost_share",
    "within the 90 % radius [%]": "coverage_90",
    "ok and > 1 m off [%]": "confident_wrong_share",
    "frames to settle": "recovery_frames",
    "worst outage [frames]": "recovery_worst_frames",
    "ms after decoding": "ms_localize",
    "ms of it in the filter": "ms_filter",
}
_SHARES = {"share_over_1m", "lost_share", "coverage_90", "confident_wrong_share"}


def command(
    map_file: MapFile,
    recording: Annotated[
        Path,
        typer.Argument(metavar="REC", show_default=False, help="A recording that the map was not learnt from."),
    ],
    *,
    filter_: Annotated[
        Literal["particles", "kalman"],
        typer.Option(
            "--filter",
            help="particles: many hypotheses, finds itself again after anything; kalman: one, as in the thesis, "
            "lighter. Default: particles.",
            show_default=False,
        ),
    ] = "particles",
    smooth: Annotated[
        bool,
        typer.Option("--smooth", help="Correct every pose by the frames that follow it; for later use. Default: off."),
    ] = False,
    seed: Annotated[
        int,
        typer.Option(min=0, help="Of the particles: the same seed, the same track. Default: 0.", show_default=False),
    ] = 0,
    tum: TumFile = None,
    csv: CsvFile = None,
    report: ReportFolder = None,
    state: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="Go on from this state where the file exists; save it there. Default: none."),
    ] = None,
    training_error: TrainingError = False,
    as_json: AsJson = False,
) -> None:
    """Follow a robot through a recording: a pose, its 90 % radius and a status a frame.

    Of odometry (odom_x_m, odom_y_m, odom_heading_rad) only the steps count.

    Without any the images are alone. The statuses, with a reason in words:

    ok: images along the way confirm the pose, a robot may drive by it.

    degraded: a likely pose, not confirmed, or not for a while.

    lost: nobody knows where on the map. off_map: nothing looks mapped.

    Both come without a pose. Reference poses (x_m, y_m) tell the errors.
    """
    from andante.evaluation import track, write_csv, write_track_report, write_tum
    from andante.mapping import SlowMap
    from andante.recordings import open_recording

    if report is not None:
        check_folder(report, "--report")
    for option, path in (("--tum", tum), ("--csv", csv), ("--state", state)):
        if path is not None:
            check_place(path, option)
    # With what it remembers, by which a map of odometry is laid over the truth.
    slowmap, source = SlowMap.load(map_file, with_memory=True), open_recording(recording)
    with progress_bars() as progress:
        done = track(
            slowmap, source, kind=filter_, seed=seed, smooth=smooth, state=state,
            training_error=training_error, progress=progress,
        )  # fmt: skip
    if tum is not None:
        write_tum(tum, done.run)
    if csv is not None:
        write_csv(csv, done.run)
    page = None if report is None else write_track_report(done, report, slowmap)
    if as_json:
        print_json({**done.as_dict(), "report": None if page is None else str(page)})
        return
    _print(done)
    if page is not None:
        typer.echo(f"report: {page}")


def _print(done: Track) -> None:
    values = done.as_dict()
    if values["n"]:
        shown = [(title, _cell(values["single"], key), _cell(values, key)) for title, key in _ROWS.items()]
        title = f"{values['recording']}: {values['n']} frames with truth of {values['frames']}"
        print_table(title, ("", "single images", done.tracked.name), shown)
    else:
        counts = Counter(str(frame.estimate.status) for frame in done.run.frames)
        print_facts(f"{values['recording']}: {values['frames']} frames, {done.tracked.name}", dict(counts))
        hint("no reference poses (x_m, y_m), so no errors are told; --csv and --tum write the poses")
    for note in values["notes"]:
        hint(note)
    for skipped in values["skipped"]:
        hint(f"no picture: {skipped['reason']}")


def _cell(values: Mapping[str, Any], key: str) -> float | None:
    value: float | None = values.get(key)
    return 100 * value if value is not None and key in _SHARES else value
