"""``andante info``: what is in a map or a recording."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from andante.cli.options import AsJson
from andante.cli.output import examples, hint, print_facts, print_json, print_table
from andante.cli.trials import print_trials
from andante.errors import InputError

if TYPE_CHECKING:
    from andante.mapping import SlowMap

EPILOG = examples(
    "andante info garden.andante",
    "andante info garden/monday --json",
    "andante info taught.andante --picture landmarks.png",
)


def command(
    path: Annotated[
        Path, typer.Argument(metavar="MAP|REC", show_default=False, help="A map file or the folder of a recording.")
    ],
    picture: Annotated[
        Path | None,
        typer.Option(
            metavar="FILE.png",
            help="Draw where the landmarks of a map stand, and where to teach another one. Default: none.",
        ),
    ] = None,
    as_json: AsJson = False,
) -> None:
    """Show what is in a map or a recording, and what may be wrong with it."""
    if picture is not None and path.is_dir():
        raise InputError(f"{path} is a recording; --picture draws the landmarks of a map")
    if path.is_dir():
        from andante.cli.describe import describe_recording
        from andante.recordings import open_recording

        described = describe_recording(open_recording(path))
        show = _print_recording
    else:
        from andante.mapping import SlowMap

        slowmap = SlowMap.load(path)
        described = {"kind": "map", "map": str(path), "bytes": path.stat().st_size, **slowmap.describe()}
        show = _print_map
        if picture is not None:
            _draw(slowmap, path, picture)
    if as_json:
        print_json(described)
    else:
        show(described)


def _draw(slowmap: SlowMap, path: Path, picture: Path) -> None:
    """Where landmarks stand, as a picture."""
    if slowmap.landmarks is None:
        raise InputError(f"map {path} has no landmarks to draw; teach some with: andante teach")
    from andante.evaluation.files import write_bytes
    from andante.evaluation.landmark_map import landmark_png

    write_bytes(picture, landmark_png(slowmap.landmarks))
    hint(f"{picture} shows where the landmarks stand")


def _print_map(described: dict[str, Any]) -> None:
    config = described["config"]
    facts = {
        "size": f"{described['bytes'] / 1e6:.2f} MB",
        "features": f"{config['features']['kind']}, {described['feature_dim']} numbers an image, from panoramas of "
        f"{described['panorama_px'][0]}x{described['panorama_px'][1]} px",
        "slow features": f"{described['slow_features']}, slowness from {config['learning']['order']}",
        "readout": config["readout"]["kind"],
        "heading": "does not matter" if described["heading_invariant"] else "must be like in the mapped drives",
        "tells headings": f"yes, from {described['compass_places']} places" if described["tells_heading"] else "no",
        "calibrated on": described["cross_validation"]["kind"],
        "can be updated": "yes" if described["updatable"] else "no, it does not remember its frames",
    }
    print_facts(described["map"], facts)
    keys = ("name", "frames", "poses")
    rows = [(*(one[key] for key in keys), _conditions(one["conditions"])) for one in described["recordings"]]
    print_table("Learnt from", (*keys, "conditions"), rows)
    _print_landmarks(described)
    print_trials(described["cross_validation"], described["unit"])


def _print_landmarks(described: dict[str, Any]) -> None:
    """Landmarks of a map, and where another one would help."""
    if not described["landmarks"]:
        return
    keys = ("name", "x_m", "y_m", "error_m")
    columns = ("landmark", "x [m]", "y [m]", "expected error [m]")
    print_table("Landmarks", columns, [tuple(one[key] for key in keys) for one in described["landmarks"]])
    if weak := described["weak_places"]:
        seen = [(one["x_m"], one["y_m"], one["radius_m"] or "none is seen", one["frames"]) for one in weak]
        print_table("Teach another landmark near", ("x [m]", "y [m]", "90 % radius [m]", "frames"), seen)


def _print_recording(described: dict[str, Any]) -> None:
    camera, circle, brightness = (described[key] for key in ("camera", "image_circle", "brightness"))
    poses = [f"{count} {kind}" for kind, count in described["poses"].items() if count]
    facts: dict[str, object] = {
        "frames": described["frames"],
        "duration": f"{described['duration_s']:.1f} s",
        "length": None
        if described["length_m"] is None
        else f"{described['length_m']:.1f} m ({described['length_of']})",
        "poses": ", ".join(poses) or "none",
        "conditions": _conditions(described["conditions"]),
        "camera": f"{camera['model']}, {camera['projection']}, {camera['field_of_view_deg']:g} degrees, facing "
        f"{camera['facing']}"
        if camera["model"] == "fisheye"
        else camera["model"],
        "images": None if described["image_px"] is None else "{}x{} px".format(*described["image_px"]),
    }
    if circle is not None:
        how = "declared" if circle["declared"] else f"found, confidence {circle['confidence']:.2f}"
        x, y = circle["centre_px"]
        facts["image circle"] = f"centre ({x:.1f}, {y:.1f}) px, radius {circle['radius_px']:.1f} px, {how}"
    if brightness is not None:
        facts["brightness"] = "median {median:.0f}, from {darkest:.0f} to {brightest:.0f} of 255".format(**brightness)
    print_facts(described["name"], facts)
    for message in described["hints"]:
        hint(message)


def _conditions(conditions: dict[str, Any]) -> str:
    return ", ".join(f"{key} {value}" for key, value in conditions.items()) or "none"
