"""From a plan or a rendered recording back to the simulated world it is of."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from andante.errors import InputError
from andante.protocols import Recording
from andante.recordings import open_recording
from andante.recordings.folder import MANIFEST
from andante.simulator import Conditions, GardenSpec, Plan, SimulatedCamera
from andante.simulator.conditions import Season

_GARDEN = "garden_"
_LENS = (
    "projection",
    "field_of_view_deg",
    "facing",
    "radius_px",
    "focal_px",
    "coefficients",
    "forward_deg",
    "mirrored",
)


@dataclass(frozen=True)
class SimulatedWorld:
    """A garden, what it is seen with, and when."""

    garden: GardenSpec
    camera: SimulatedCamera
    conditions: Conditions


def world_of(path: Path, season: Season | None) -> SimulatedWorld:
    """Of a plan in TOML, or of a folder that ``andante simulate`` wrote or one of the recordings in it.

    Conditions are those of the first session, with another ``season`` where one is asked for. Raises ``InputError`` for
    folders without simulated recordings, ``ConfigError`` for faults of a plan.
    """
    world = _of_folder(path) if path.is_dir() else _of_plan(path)
    if season is None:
        return world
    conditions = Conditions(**{**world.conditions.model_dump(), "season": season})
    return SimulatedWorld(world.garden, world.camera, conditions)


def _of_plan(path: Path) -> SimulatedWorld:
    plan = Plan.from_toml(path)
    return SimulatedWorld(plan.garden, plan.camera, plan.sessions[0].conditions)


def _of_folder(path: Path) -> SimulatedWorld:
    folders = [path] if (path / MANIFEST).exists() else sorted(one.parent for one in path.glob(f"*/{MANIFEST}"))
    if not folders:
        raise InputError(f"--world {path} holds no recording; give a plan or a folder made with: andante simulate")
    recording = open_recording(folders[0])
    known = recording.conditions
    garden = {key.removeprefix(_GARDEN): value for key, value in known.items() if key.startswith(_GARDEN)}
    if not garden:
        raise InputError(f"--world {folders[0]} was not simulated; give a plan or a folder made with: andante simulate")
    conditions = {key: known[key] for key in Conditions.model_fields if key in known}
    where = f"recording {folders[0]}"
    return SimulatedWorld(
        GardenSpec.checked(garden, where), _camera(recording, folders[0]), Conditions.checked(conditions, where)
    )


def _camera(recording: Recording, folder: Path) -> SimulatedCamera:
    spec = recording.camera
    if spec.model != "fisheye":
        raise InputError(
            f"--world {folder} does not say which elevations its {spec.model} shows; give its plan instead"
        )
    height, width = recording.load(recording.infos[0]).shape[:2]
    lens = {name: getattr(spec, name) for name in _LENS}
    values = {"width_px": width, "height_px": height, **{key: one for key, one in lens.items() if one is not None}}
    return SimulatedCamera.checked(values, f"recording {folder}")
