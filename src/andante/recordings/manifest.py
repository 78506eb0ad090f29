"""``recording.toml``: what a recording says of itself, read with checks and written back."""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field
from datetime import date, time
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from andante.data import CameraModel, CameraSpec, Facing, Projection
from andante.errors import RecordingError

SCHEMA = 1

Source = Literal["rendered", "real"]
_FieldOfView = Annotated[float, Field(gt=0, le=360)]
_Pixels = Annotated[float, Field(gt=0)]


class _Section(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, strict=True, allow_inf_nan=False)


class _Camera(_Section):
    """The keys of ``CameraSpec`` with the values that a camera can have."""

    model: CameraModel = "fisheye"
    projection: Projection = "equidistant"
    field_of_view_deg: _FieldOfView = 180.0
    facing: Facing = "up"
    centre_px: Annotated[tuple[float, float], Field(strict=False)] | None = None  # TOML has lists, no tuples
    radius_px: _Pixels | None = None
    focal_px: _Pixels | None = None
    coefficients: Annotated[tuple[float, ...], Field(strict=False)] = ()
    forward_deg: Annotated[float, Field(ge=-360, le=360)] = 0.0
    mirrored: bool = False
    horizontal_field_of_view_deg: _FieldOfView = 360.0


class _File(_Section):
    schema_: Literal[1] = Field(alias="schema")
    name: Annotated[str, Field(min_length=1)]
    source: Source | None = None
    camera: _Camera
    conditions: dict[str, Any] = {}


@dataclass(frozen=True, slots=True)
class Manifest:
    """The checked content of ``recording.toml``; ``conditions`` hold only what JSON can say."""

    name: str
    camera: CameraSpec
    conditions: Mapping[str, Any] = field(default_factory=dict)
    source: Source | None = None


def parse_manifest(text: str, source: str) -> Manifest:
    """Read the text of a ``recording.toml``; ``source`` names it in errors. Raises ``RecordingError``."""
    try:
        content = tomllib.loads(text)
    except (ValueError, RecursionError) as error:  # also of numbers with thousands of digits
        raise RecordingError(f"{source}: not valid TOML: {error}") from None
    schema = content.get("schema")
    if isinstance(schema, int) and schema > SCHEMA:  # before all else: a newer schema may have other keys
        raise RecordingError(
            f"{source}: schema {schema} is newer than this version of andante reads ({SCHEMA}); update andante"
        )
    try:
        file = _File.model_validate(content)
        conditions = json.loads(json.dumps(file.conditions, allow_nan=False, default=str))  # dates become text
    except ValidationError as error:
        raise RecordingError(f"{source}: {_first_fault(error)}") from None
    except (ValueError, RecursionError) as error:
        raise RecordingError(f"{source}: [conditions] hold what JSON cannot say: {error}") from None
    camera = CameraSpec(**file.camera.model_dump())
    return Manifest(file.name, camera, conditions, file.source)


def _first_fault(error: ValidationError) -> str:
    fault = error.errors(include_url=False)[0]
    path = ".".join(str(part) for part in fault["loc"])
    section: type[BaseModel] = _Camera if fault["loc"][0] == "camera" else _File
    if fault["type"] == "extra_forbidden":
        allowed = ", ".join(field.alias or name for name, field in section.model_fields.items())
        return f"unknown key {path!r}; allowed are {allowed}"
    if fault["type"] == "missing":
        return f"{path!r} is missing; add it"
    return f"{path!r}: {fault['msg']}, got {str(fault['input'])[:80]!r}"


def format_manifest(manifest: Manifest) -> str:
    """The TOML text of a manifest; raises ``RecordingError`` for a condition that TOML cannot say."""
    head: dict[str, Any] = {"schema": SCHEMA, "name": manifest.name, "source": manifest.source}
    sections = ((head, ""), (asdict(manifest.camera), "[camera]\n"), (manifest.conditions, "[conditions]\n"))
    return "\n".join(
        title + "".join(f"{_key(key)} = {_value(value)}\n" for key, value in pairs.items() if value is not None)
        for pairs, title in sections
    )


def _key(key: str) -> str:
    return key if re.fullmatch(r"[A-Za-z0-9_-]+", key) else _string(key)


def _string(text: str) -> str:
    """A basic string: backslash, quote and control characters are escaped, all else stands for itself."""
    return '"' + re.sub(r'[\x00-\x1f\x7f"\\]', lambda match: f"\\u{ord(match[0]):04x}", text) + '"'


def _value(value: object) -> str:
    if isinstance(value, np.generic):
        value = value.item()
    match value:
        case bool():
            return str(value).lower()
        case str():
            return _string(value)
        case int() | float() | date() | time():
            return value.isoformat() if isinstance(value, date | time) else repr(value)
        case Mapping():
            return "{" + ", ".join(f"{_key(key)} = {_value(item)}" for key, item in value.items()) + "}"
        case list() | tuple():
            return "[" + ", ".join(_value(item) for item in value) + "]"
    raise RecordingError(
        f"a condition of type {type(value).__name__} cannot be written; "
        f"allowed are text, numbers, true, false, dates, and lists and tables of them"
    )
