"""Where to go: a pose, the place where an image was taken, or a place with a name."""

from __future__ import annotations

import tomllib
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from andante.data import FloatArray, ImageArray, Pose2D
from andante.errors import ConfigError, InputError
from andante.mapping import SlowMap


@dataclass(frozen=True, slots=True, eq=False)
class Goal:
    """A pose in the frame of the map, heading ``None`` where any will do.

    ``slow`` (k,) are the map's slow features of its image, where there is one.
    """

    name: str
    pose: Pose2D
    slow: FloatArray | None = None


def pose_goal(x_m: float, y_m: float, heading_rad: float | None = None) -> Goal:
    """A point, and which way to look there; raises ``ConfigError`` for numbers that are not finite."""
    if not np.isfinite([x_m, y_m, heading_rad or 0.0]).all():
        raise ConfigError(f"a goal needs finite numbers, got x {x_m}, y {y_m}, heading {heading_rad}")
    return Goal(f"({x_m:.2f}, {y_m:.2f})", Pose2D(x_m, y_m, heading_rad))


def image_goal(slowmap: SlowMap, image: ImageArray, name: str = "image") -> Goal:
    """Where an image was taken, as far as the map can tell; looking any way will do.

    Raises ``InputError`` for an image that the map does not know: a robot should not be sent to a guess.
    """
    estimate = slowmap.localize(image)
    if not estimate.status.has_pose or estimate.x_m is None or estimate.y_m is None:
        raise InputError(
            f"the goal image is {str(estimate.status).replace('_', ' ')}: {estimate.reason}; take one at a mapped "
            "place, or give the goal as a pose"
        )
    return Goal(name, Pose2D(estimate.x_m, estimate.y_m), slowmap.slow_features(image))


def places_file(map_file: str | Path) -> Path:
    """The file with the named places of a map: ``garden.places.toml`` beside ``garden.andante``."""
    return Path(map_file).with_suffix(".places.toml")


def named_goal(map_file: str | Path, name: str) -> Goal:
    """A place by its name, from the file beside the map: ``charging-station = [x_m, y_m]`` or with a heading in rad.

    Raises ``InputError`` for a file that is missing or cannot be read, ``ConfigError`` for what is wrong in it.
    """
    path = places_file(map_file)
    try:
        places = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(
            f"named places {path} cannot be read: {error.strerror}; write it with lines such as "
            "charging-station = [1.5, -2.0, 0.0]"
        ) from None
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise ConfigError(f"named places {path} is no valid TOML: {error}") from None
    if name not in places:
        known = ", ".join(sorted(places)) or "none"
        raise ConfigError(f"there is no place {name!r} in {path}; it has {known}")
    match places[name]:
        case [int() | float() as x, int() | float() as y]:
            heading = None
        case [int() | float() as x, int() | float() as y, int() | float() as heading]:
            heading = float(heading)
        case other:
            raise ConfigError(f"{path}: {name} = {other!r} is not allowed; give [x_m, y_m] or [x_m, y_m, heading_rad]")
    return Goal(name, pose_goal(float(x), float(y), heading).pose)
