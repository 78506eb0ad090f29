"""``andante localize``: an image, a folder of images or a recording in, poses out."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from andante.cli.options import AsJson, CsvFile, MapFile, TumFile, check_place
from andante.cli.output import examples, hint, print_facts, print_json, print_table, progress_bars

if TYPE_CHECKING:
    from andante.data import CameraSpec
    from andante.evaluation import Run
    from andante.mapping import SlowMap
    from andante.protocols import Recording

EPILOG = examples(
    "andante localize garden.andante now.jpg",
    "andante localize garden.andante now.jpg --json",
    "andante localize garden.andante garden/sunday --tum sunday.tum --csv sunday.csv",
)


def command(
    map_file: MapFile,
    source: Annotated[
        Path,
        typer.Argument(metavar="SOURCE", show_default=False, help="An image, a folder of images, or a recording."),
    ],
    tum: TumFile = None,
    csv: CsvFile = None,
    as_json: AsJson = False,
) -> None:
    """Say where images were taken; one that fits no mapped place gets the status lost or off_map, never a pose."""
    from andante.evaluation import run_localizer, write_csv, write_tum
    from andante.mapping import SlowMap

    for option, path in (("--tum", tum), ("--csv", csv)):
        if path is not None:
            if not source.is_dir():
                raise typer.BadParameter(f"{option} needs a folder of images or a recording as SOURCE")
            check_place(path, option)
    slowmap = SlowMap.load(map_file)
    if not source.is_dir():
        _show_one(slowmap, source, as_json)
        return
    recording = _opened(source, slowmap.front_end.camera)
    with progress_bars() as progress:
        run = run_localizer(slowmap.for_recording(recording), recording, progress=progress)
    if tum is not None:
        write_tum(tum, run)
    if csv is not None:
        write_csv(csv, run)
    _show_run(run, recording.name, as_json)


def _opened(folder: Path, camera: CameraSpec) -> Recording:
    """A recording, or a plain folder of images from the map's camera."""
    from andante.recordings import open_images, open_recording
    from andante.recordings.folder import MANIFEST

    if (folder / MANIFEST).exists():
        return open_recording(folder)
    return open_images(folder, camera=camera)


def _show_one(slowmap: SlowMap, image: Path, as_json: bool) -> None:
    from andante.recordings import read_image

    values = slowmap.localize(read_image(image)).as_dict()
    if as_json:
        print_json({"image": str(image), **values})
    else:
        known = {name: f"{value:.3f}" for name, value in _pose(values).items() if value is not None}
        print_facts(str(image), {"status": values["status"], **known, "reason": values["reason"]})


def _show_run(run: Run, name: str, as_json: bool) -> None:
    estimates = [
        {"image": frame.info.image, "timestamp_s": frame.info.timestamp_s, **frame.estimate.as_dict()}
        for frame in run.frames
    ]
    if as_json:
        print_json({"estimates": estimates, "skipped": [asdict(one) for one in run.skipped]})
        return
    rows = [
        {"image": one["image"], "time [s]": one["timestamp_s"], "status": one["status"], **_pose(one)}
        for one in estimates
    ]
    print_table(name, tuple(rows[0]), [tuple(row.values()) for row in rows])
    for skipped in run.skipped:
        hint(f"skipped: {skipped.reason}")


def _pose(estimate: dict[str, Any]) -> dict[str, float | None]:
    """The numbers of an estimate for people, with units."""
    heading = estimate["heading_rad"]
    return {
        "x [m]": estimate["x_m"],
        "y [m]": estimate["y_m"],
        "heading [deg]": None if heading is None else math.degrees(heading),
        "90 % radius [m]": estimate["radius_m"],
        "place": estimate["place"],
    }
