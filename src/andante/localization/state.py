"""The state of a tracker as one file: safetensors with JSON metadata, no pickle, checked before it is used.

A tracker that goes on from it does what it would have done without a stop, bit for bit: numbers are written in full
and the generator's state is in it.
"""

from __future__ import annotations

import dataclasses
import hashlib
import json
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, ValidationError
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from andante.data import Estimate, FloatArray, Hypothesis, Pose2D, Status
from andante.errors import AndanteError, MapError
from andante.files import replace_file
from andante.localization.faults import Pulse
from andante.localization.judge import Judge
from andante.localization.memory import Memory
from andante.localization.motion import Odometer
from andante.localization.trail import Trail
from andante.localization.witness import Novelty
from andante.mapping.slow_map import SlowMap

SCHEMA = 1
MAX_BYTES = 2**26
_KEY = "andante-tracker"
_FILTER, _TRAIL, _GOOD, _LAST, _COVARIANCE = "filter.", "trail", "good", "last", "covariance"
_OF_MEMORY = (
    *("odometer", "pulse", "image_news", "fix_news", "judge"),
    *("fast", "slow", "image_radius_m", "strain_m"),
)
"""Fields of a memory that are written under their own names."""


class _Scalars(BaseModel):
    """What of a tracker's state is no array; infinity is written as a word."""

    model_config = ConfigDict(extra="forbid", ser_json_inf_nan="strings")

    schema_version: int
    kind: str
    map_digest: str
    config: str
    generator: dict[str, Any] | None
    odometer: Odometer
    trail_pose: Pose2D
    pulse: Pulse
    image_news: Novelty
    fix_news: Novelty
    judge: Judge
    fast: float
    slow: float
    image_radius_m: float
    strain_m: float
    status: Status
    reason: str
    place: tuple[float | None, float | None, float | None, float | None]
    hypotheses: tuple[Hypothesis, ...]


@dataclasses.dataclass(frozen=True, eq=False)
class State:
    """All of a tracker: its memory, its filter's arrays, its generator where it has one, and its last estimate."""

    memory: Memory
    filter_arrays: dict[str, NDArray[Any]]
    generator: dict[str, Any] | None
    estimate: Estimate


@dataclasses.dataclass(frozen=True, slots=True)
class Owner:
    """Which tracker a state belongs to: its kind, its map and its configuration."""

    kind: str
    map_digest: str
    config: str

    @classmethod
    def of(cls, kind: str, slowmap: SlowMap, config: BaseModel) -> Owner:
        """A tracker's."""
        return cls(kind, map_digest(slowmap), config.model_dump_json())


def map_digest(slowmap: SlowMap) -> str:
    """A hash of what localizes: the slow features' model and the readout, whatever the file is called."""
    digest = hashlib.sha256()
    for part in (slowmap.model.to_arrays(), slowmap.readout.to_arrays()):
        for name, array in sorted(part.items()):
            digest.update(f"{name} {array.dtype} {array.shape}".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()


def write_state(state: State, owner: Owner, path: str | Path) -> None:
    """Write atomically; raises ``MapError`` where the place cannot be written."""
    memory, estimate = state.memory, state.estimate
    scalars = _Scalars(
        schema_version=SCHEMA,
        **dataclasses.asdict(owner),
        generator=state.generator,
        trail_pose=memory.trail.pose,
        **{name: getattr(memory, name) for name in _OF_MEMORY},
        status=estimate.status,
        reason=estimate.reason,
        place=(estimate.x_m, estimate.y_m, estimate.heading_rad, estimate.radius_m),
        hypotheses=estimate.hypotheses,
    )
    arrays = {_FILTER + name: array for name, array in state.filter_arrays.items()} | {_TRAIL: memory.trail.rows}
    for name, array in ((_GOOD, memory.good), (_LAST, memory.last), (_COVARIANCE, estimate.covariance)):
        if array is not None:
            arrays[name] = array
    contiguous = {name: np.ascontiguousarray(array, dtype=np.float64) for name, array in arrays.items()}
    try:
        replace_file(Path(path), save(contiguous, metadata={_KEY: scalars.model_dump_json()}))
    except OSError as error:
        raise MapError(f"tracker state {path} cannot be written: {error.strerror or error}; choose another") from None


def read_state(path: str | Path, owner: Owner) -> State:
    """Read and check; raises ``MapError`` for anything but a complete state of this tracker on this map."""
    path = Path(path)
    try:
        if not path.is_file() or path.stat().st_size > MAX_BYTES:
            raise MapError(f"tracker state {path} is no file of at most {MAX_BYTES} bytes; write one with save")
        scalars, arrays = _read(path)
        _require_owner(scalars, owner)
        return _assembled(scalars, arrays)
    except (SafetensorError, OSError) as error:
        raise MapError(f"tracker state {path} is damaged or none: {error}; begin without it") from None
    except ValidationError as error:
        first = error.errors(include_url=False)[0]
        key = ".".join(str(part) for part in first["loc"]) or "value"
        raise MapError(
            f"tracker state {path} cannot be used: {key}: {first['msg'].lower()}; begin without it"
        ) from None
    except (AndanteError, KeyError, ValueError) as error:
        raise MapError(f"tracker state {path} cannot be used: {error}; begin without it") from None


def _read(path: Path) -> tuple[_Scalars, dict[str, FloatArray]]:
    with safe_open(path, framework="numpy") as file:
        metadata = file.metadata() or {}
        if _KEY not in metadata:
            raise MapError("it is no state of a tracker")
        version = json.loads(metadata[_KEY]).get("schema_version")
        if version != SCHEMA:
            raise MapError(f"it has schema {version}, this version reads {SCHEMA}")
        arrays = {}
        for name in file.keys():  # noqa: SIM118 (not a mapping)
            if file.get_slice(name).get_dtype() != "F64":
                raise MapError(f"array {name} is of type {file.get_slice(name).get_dtype()}, allowed is F64")
            arrays[name] = file.get_tensor(name)
            if name not in (_TRAIL, _COVARIANCE) and not np.isfinite(arrays[name]).all():
                raise MapError(f"array {name} holds values that are not finite")
    return _Scalars.model_validate_json(metadata[_KEY]), arrays


def _require_owner(scalars: _Scalars, owner: Owner) -> None:
    for what, value in dataclasses.asdict(owner).items():
        if getattr(scalars, what) != value:
            other = {"kind": f"a tracker of kind {scalars.kind!r}", "map_digest": "another map"}
            raise MapError(f"it belongs to {other.get(what, 'a tracker with another configuration')}")


def _assembled(scalars: _Scalars, arrays: dict[str, FloatArray]) -> State:
    rows, covariance = arrays[_TRAIL], arrays.get(_COVARIANCE)
    if rows.shape != Trail.empty().rows.shape or (covariance is not None and covariance.shape != (3, 3)):
        raise MapError("its arrays have shapes that do not fit each other")
    memory = Memory(
        trail=Trail(scalars.trail_pose, rows),
        good=arrays.get(_GOOD),
        last=arrays.get(_LAST),
        **{name: getattr(scalars, name) for name in _OF_MEMORY},
    )
    x, y, heading, radius = scalars.place
    estimate = Estimate(
        scalars.status, scalars.reason, x, y, heading, covariance, radius, hypotheses=scalars.hypotheses
    )
    own = {name.removeprefix(_FILTER): array for name, array in arrays.items() if name.startswith(_FILTER)}
    return State(memory, own, scalars.generator, estimate)
