"""``andante map``: recordings in, a map file out."""

from __future__ import annotations

import time
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import typer

from andante.cli.options import AsJson, check_place
from andante.cli.output import examples, hint, print_facts, print_json, progress_bars
from andante.cli.trials import print_closings, print_trials
from andante.errors import InputError

if TYPE_CHECKING:
    from andante.landmarks.detector import LandmarkDetector
    from andante.mapping import MapConfig, SlowMap

# The same words as in ``andante.mapping.config``, which would take too long to import for a help text.
Features = Literal["auto", "fourier", "flat", "pixels"]
Order = Literal["places", "restructured", "temporal"]
Positions = Literal["auto", "reference", "odometry", "place"]
ReadoutKind = Literal["local", "polynomial", "gaussian-process"]
Preset = Literal["default", "thesis", "thesis-pixels"]

EPILOG = examples(
    "andante map garden/monday -o garden.andante",
    "andante map garden/summer garden/winter -o garden.andante --slow-features 64 --json",
    "andante map garden/summer garden/winter -o garden.andante --features pixels",
    "andante map garden/monday -o thesis.andante --preset thesis",
    "andante map garden/monday -o garden.andante --landmarks garden.onnx",
)


def command(
    recordings: Annotated[
        list[Path],
        typer.Argument(metavar="REC...", show_default=False, help="Recordings in one common frame of reference."),
    ],
    *,
    output: Annotated[
        Path,
        typer.Option(
            "--output",
            "-o",
            metavar="MAP",
            show_default=False,
            help="The map file to write; a map it replaces is kept.",
        ),
    ],
    features: Annotated[
        Features | None,
        typer.Option(
            help="What of the panorama is learnt from; pixels go through a network that is learnt first. "
            "Default: auto, by the camera."
        ),
    ] = None,
    order: Annotated[
        Order | None, typer.Option(help="Which frames count as alike. Default: places (thesis: restructured).")
    ] = None,
    positions: Annotated[
        Positions | None, typer.Option(help="Which positions are learnt. Default: auto, the best that all have.")
    ] = None,
    slow_features: Annotated[
        int | None, typer.Option(min=1, help="Slow features at most, a number. Default: by trial (thesis: 8).")
    ] = None,
    readout: Annotated[
        ReadoutKind | None,
        typer.Option(help="From slow features to positions. Default: local (thesis: polynomial)."),
    ] = None,
    config: Annotated[
        Path | None,
        typer.Option(metavar="FILE", help="TOML file with values of MapConfig; options win over it. Default: none."),
    ] = None,
    preset: Annotated[
        Preset, typer.Option(show_default=False, help="What --config and options start from. Default: default.")
    ] = "default",
    landmarks: Annotated[
        Path | None,
        typer.Option(
            metavar="NAME.onnx",
            help="Go by the landmarks that this detector finds as well; the map carries it. Default: none.",
        ),
    ] = None,
    localize_only: Annotated[
        bool,
        typer.Option("--localize-only", help="A smaller map that cannot be updated. Default: it can."),
    ] = False,
    seed: Annotated[int | None, typer.Option(min=0, help="For all random choices, a number. Default: 0.")] = None,
    as_json: AsJson = False,
) -> None:
    """Learn a map from recordings with known positions and write it to one file."""
    from andante.mapping import BuildLog, add_landmarks, build_map
    from andante.mapping.history import replace_map
    from andante.mapping.landmark_builder import check_drives
    from andante.recordings import open_recording

    sections = {
        "features": {"kind": features},
        "learning": {"order": order, "slow_features": slow_features},
        "readout": {"kind": readout},
        "memory": {"keep": False if localize_only else None},
    }
    resolved = _resolved(preset, config, {**sections, "positions": positions, "seed": seed})
    check_place(output, "-o")
    detector = None if landmarks is None else _detector(landmarks)
    started, log, drives = time.perf_counter(), BuildLog(), [open_recording(one) for one in recordings]
    if detector is not None:
        check_drives(drives, resolved.positions)
    with progress_bars() as progress:
        slowmap = build_map(drives, resolved, progress=progress, log=log)
        if detector is not None:
            with log.timed("landmarks"):
                slowmap = add_landmarks(slowmap, drives, detector, progress=progress)
            log.hints += _left_out(detector, slowmap)
    size = replace_map(slowmap, output)
    log.seconds["total"] = time.perf_counter() - started
    summary = {"map": str(output), "bytes": size, **_summary(slowmap, log.seconds)}
    summary |= {"stationary": log.stationary, "without_position": log.without_position}
    summary["hints"] = log.hints
    summary["odometry"] = [asdict(closing) for closing in log.closings]
    if as_json:
        print_json(summary)
    else:
        _print(summary)


def _resolved(preset: Preset, file: Path | None, flags: dict[str, Any]) -> MapConfig:
    """Flag over file over preset."""
    from andante.mapping import MapConfig

    presets = {"default": MapConfig, "thesis": MapConfig.thesis, "thesis-pixels": MapConfig.thesis_pixels}
    config = presets[preset]()
    if file is not None:
        config = config.with_values(MapConfig.from_toml(file).model_dump(exclude_unset=True))
    return config.with_values(_given(flags))


def _detector(path: Path) -> LandmarkDetector:
    """Read before the work that would be lost."""
    from andante.landmarks.detector import LandmarkDetector

    if path.is_dir():
        raise InputError(
            f"--landmarks {path} is a folder; learn a detector from its labels first: "
            f"andante learn-landmarks {path} -o NAME.onnx"
        )
    return LandmarkDetector.load(path)


def _left_out(detector: LandmarkDetector, slowmap: SlowMap) -> list[str]:
    """Of landmarks that the detector knows and the map does not."""
    mapped = () if slowmap.landmarks is None else slowmap.landmarks.names
    missing = ", ".join(name for name in detector.names if name not in mapped)
    return [f"seen too seldom to be learnt and tried, so the map goes without: {missing}"] if missing else []


def _given(values: dict[str, Any]) -> dict[str, Any]:
    """What was said on the command line."""
    nested = {key: _given(value) if isinstance(value, dict) else value for key, value in values.items()}
    return {key: value for key, value in nested.items() if value is not None}


def _summary(slowmap: SlowMap, seconds: dict[str, float]) -> dict[str, Any]:
    described = slowmap.describe()
    stages = ("decode", "network", "features", "learn", "readout", "landmarks", "total")
    return {
        "recordings": described["recordings"],
        "frames": sum(one["frames"] for one in described["recordings"]),
        "feature_dim": described["feature_dim"],
        "slow_features": described["slow_features"],
        "deltas": described["deltas"],
        "unit": described["unit"],
        "landmarks": described["landmarks"],
        "seconds": {stage: seconds.get(stage) for stage in stages},
        "cross_validation": described["cross_validation"],
        "skipped": [
            {"recording": one["name"], "reason": reason} for one in described["recordings"] for reason in one["skipped"]
        ],
    }


def _print(summary: dict[str, Any]) -> None:
    seconds = {stage: value for stage, value in summary["seconds"].items() if value is not None}
    facts = {
        "frames": f"{summary['frames']} of {', '.join(one['name'] for one in summary['recordings'])}",
        "left out": f"{summary['stationary']} standing still, {summary['without_position']} without a position, "
        f"{len(summary['skipped'])} unreadable",
        "features": f"{summary['feature_dim']} numbers an image, {summary['slow_features']} slow features",
        "size": f"{summary['bytes'] / 1e6:.2f} MB",
        "seconds": ", ".join(f"{stage} {value:.2f}" for stage, value in seconds.items()),
    }
    if summary["landmarks"]:
        facts["landmarks"] = ", ".join(f"{one['name']} ({one['error_m']:.2f} m)" for one in summary["landmarks"])
    print_facts(summary["map"], facts)
    print_closings(summary["odometry"])
    for told in summary["hints"]:
        hint(told)
    for skipped in summary["skipped"]:
        hint(f"skipped in {skipped['recording']}: {skipped['reason']}")
    print_trials(summary["cross_validation"], summary["unit"])
