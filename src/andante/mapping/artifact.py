"""A map as one file: safetensors with JSON metadata, no pickle.

The file is checked before anything of it is used: size, header, schema, the names, types and shapes of all arrays,
and that they fit each other (``andante.mapping.consistency``). It is written beside its place, flushed and renamed,
so that a reader sees the old map or the new one and never half of either.
"""

from __future__ import annotations

import dataclasses
import json
import math
import os
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, Field, ValidationError
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from andante.data import CameraSpec
from andante.errors import AndanteError, MapError
from andante.features import PhaseEncoder
from andante.files import replace_file
from andante.landmarks.sealed import SealedDetector
from andante.mapping.calibration import Calibration
from andante.mapping.compact import CompactModel
from andante.mapping.compass import Compass
from andante.mapping.config import MapConfig
from andante.mapping.consistency import (
    check_compass,
    check_landmarks,
    check_memory,
    check_parts,
    check_scenery,
    check_sources,
)
from andante.mapping.frontend import FrontEnd
from andante.mapping.landmark_config import LandmarkConfig
from andante.mapping.landmark_lesson import LandmarkCalibration
from andante.mapping.landmarks import LandmarkMap
from andante.mapping.memory import Source, memory_arrays, memory_of, rows_of
from andante.mapping.network import network_arrays, network_of
from andante.mapping.readout import LocalReadout
from andante.mapping.regressions import GaussianProcessReadout, PolynomialReadout
from andante.mapping.scenery import Scenery
from andante.mapping.slow_map import SlowMap, Unit

SCHEMA = 3
MOST_LANDMARKS = 200
MAX_BYTES = 2**31
_KEY = "andante"
_DTYPES = ("F16", "F32", "F64", "I8", "I64", "U8", "U32")
_MEMORY = "memory"
_MAY_BE_UNKNOWN = ("memory.heading",)
_Side = Annotated[int, Field(ge=1, le=2**16)]
_READOUTS: dict[str, type[LocalReadout] | type[PolynomialReadout] | type[GaussianProcessReadout]] = {
    "local": LocalReadout,
    "polynomial": PolynomialReadout,
    "gaussian-process": GaussianProcessReadout,
}


class _Landmarks(BaseModel):
    """What a map says of its landmarks beside their arrays; absent where it has none."""

    names: Annotated[tuple[str, ...], Field(min_length=1, max_length=MOST_LANDMARKS)]
    calibration: LandmarkCalibration
    config: LandmarkConfig


class _Header(BaseModel):
    """What a map says of itself beside its arrays."""

    package_version: str
    name: str
    unit: Unit
    config: MapConfig
    asked: MapConfig
    camera: CameraSpec
    image_shape: tuple[_Side, _Side]
    calibration: Calibration
    sources: tuple[Source, ...]
    landmarks: _Landmarks | None = None


def write_map(slowmap: SlowMap, path: str | Path) -> int:
    """Write atomically and return the size in bytes; raises ``MapError`` where the place cannot be written."""
    path = Path(path)
    arrays = _prefixed("model", slowmap.model.to_arrays()) | _prefixed("readout", slowmap.readout.to_arrays())
    if slowmap.front_end.network is not None:
        arrays |= _prefixed("network", network_arrays(slowmap.front_end.network))
    if slowmap.compass is not None:
        arrays |= _prefixed("compass", slowmap.compass.to_arrays())
    if slowmap.scenery is not None:
        arrays |= _prefixed("scenery", slowmap.scenery.to_arrays())
    if slowmap.landmarks is not None:
        arrays |= _prefixed("landmarks", slowmap.landmarks.to_arrays())
    arrays["pictures"] = np.concatenate(slowmap.pictures)
    if slowmap.memory is not None:
        arrays |= _prefixed(_MEMORY, memory_arrays(slowmap.memory))
    # safetensors 0.8 writes the memory of a strided view as if it were contiguous.
    contiguous = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    try:
        # A single key: safetensors writes several in random order, but the same map has to give the same bytes.
        data = save(contiguous, metadata={_KEY: json.dumps(_header(slowmap, path), sort_keys=True, allow_nan=False)})
        replace_file(path, data)
    except OSError as error:
        reason = error.strerror or error
        raise MapError(f"map {path} cannot be written: {reason}; choose another place with -o") from None
    except (TypeError, ValueError, RecursionError) as error:
        raise MapError(
            f"map {path} cannot be written: {error}; conditions of recordings hold text, finite numbers, true, false, "
            "and lists and tables of them"
        ) from None
    return len(data)


def read_map(path: str | Path, *, with_memory: bool = False) -> SlowMap:
    """Read and check a map; raises ``MapError`` saying what is wrong with it.

    The memory of its frames, where it has one, is read only where ``with_memory`` asks for it.
    """
    path = Path(path)
    try:
        size = path.stat().st_size
    except OSError as error:
        raise MapError(f"map {path} cannot be read: {error.strerror}; make one with: andante map") from None
    if path.is_dir():
        raise MapError(f"{path} is a folder, not a map; where it is a recording, the map comes before it")
    if not path.is_file() or size > MAX_BYTES:
        raise MapError(f"map {path} is no map: {size} bytes, a map is a file of at most {MAX_BYTES}")
    try:
        header, arrays = _read(path, with_memory=with_memory)
        return _assembled(header, arrays, path)
    except (SafetensorError, OSError) as error:
        raise MapError(f"map {path} is damaged or no map: {error}; make it again with: andante map") from None
    except (AndanteError, KeyError, TypeError, ValueError, AttributeError, ArithmeticError) as error:
        raise MapError(f"map {path} cannot be used: {error}; make it again with: andante map") from None


def _header(slowmap: SlowMap, path: Path) -> dict[str, Any]:
    front_end, landmarks = slowmap.front_end, slowmap.landmarks
    known = {} if landmarks is None else {"landmarks": _landmarks_header(landmarks)}
    return known | {
        "schema": SCHEMA,
        "package_version": version("andante"),
        "name": slowmap.name,
        "unit": slowmap.unit,
        "config": slowmap.config.model_dump(mode="json"),
        # A map that was loaded without its memory is written without it, and says so.
        "asked": _asked(slowmap).model_dump(mode="json"),
        "camera": dataclasses.asdict(front_end.camera),
        "image_shape": list(front_end.image_shape),
        "calibration": dataclasses.asdict(slowmap.calibration),
        "sources": [_source(source, path) for source in slowmap.sources],
    }


def _landmarks_header(landmarks: LandmarkMap) -> dict[str, Any]:
    return {
        "names": list(landmarks.names),
        "calibration": dataclasses.asdict(landmarks.calibration),
        "config": landmarks.config.model_dump(mode="json"),
    }


def _asked(slowmap: SlowMap) -> MapConfig:
    remembers = slowmap.memory is not None
    return slowmap.asked.with_values({"memory": {"keep": remembers}})


def _source(source: Source, path: Path) -> dict[str, Any]:
    """As plain values; the folder relative to the map, so that both can move together."""
    values = dataclasses.asdict(source)
    if source.folder is not None:
        values["folder"] = os.path.relpath(source.folder, path.resolve().parent)
    return values


def _read(path: Path, *, with_memory: bool) -> tuple[_Header, dict[str, NDArray[Any]]]:
    """Header and arrays, each checked for itself."""
    with safe_open(path, framework="numpy") as file:
        header = _checked_header(file.metadata() or {})
        arrays = {}
        for name in file.keys():  # noqa: SIM118 (not a mapping)
            if name.startswith(f"{_MEMORY}.") and not with_memory:
                continue
            dtype = file.get_slice(name).get_dtype()
            if dtype not in _DTYPES:
                raise MapError(f"array {name} is of type {dtype}, allowed are {', '.join(_DTYPES)}")
            arrays[name] = file.get_tensor(name)
            unknown = np.isnan(arrays[name]) if name in _MAY_BE_UNKNOWN else False
            if not (np.isfinite(arrays[name]) | unknown).all():
                raise MapError(f"array {name} holds values that are not finite")
    return header, arrays


def _checked_header(metadata: Mapping[str, str]) -> _Header:
    if _KEY not in metadata:
        raise MapError("it is no Andante map")
    try:
        values = json.loads(metadata[_KEY], parse_float=_finite, parse_constant=_finite)
        # Before all else: a newer schema may have other keys.
        schema = values.get("schema") if isinstance(values, dict) else None
        if schema != SCHEMA:
            raise MapError(f"it has schema {schema!r:.20}, this version of andante reads {SCHEMA}; upgrade andante")
        return _Header.model_validate(values)
    except ValidationError as error:
        fault = error.errors(include_url=False, include_input=False)[0]
        raise MapError(f"its {'.'.join(map(str, fault['loc'])) or 'header'} is wrong: {fault['msg']}") from None
    except (ValueError, RecursionError) as error:
        raise MapError(f"its header is no JSON: {error}") from None


def _finite(number: str) -> float:
    value = float(number)
    if not math.isfinite(value):
        raise ValueError(f"{number} is no finite number")
    return value


def _assembled(header: _Header, arrays: dict[str, NDArray[Any]], path: Path) -> SlowMap:
    config = header.config
    front_end = FrontEnd(header.camera, header.image_shape, config.panorama, config.features)
    if front_end.lacks_network:
        front_end = front_end.with_network(network_of(_section("network", arrays), config.network, front_end))
    model = CompactModel.from_arrays(_section("model", arrays))
    readout = _READOUTS[config.readout.kind].from_arrays(_section("readout", arrays))
    check_parts(front_end, model, readout)
    compass = _compass(front_end, _section("compass", arrays))
    scenery = _scenery(front_end, _section("scenery", arrays))
    if (scenery is None) != (header.calibration.views is None):
        raise MapError("of its scenery and what may be promised of that, one is missing")
    sources = tuple(_found_again(source, path) for source in header.sources)
    pictures = arrays.get("pictures", np.empty(0, np.uint32))
    check_sources(sources, pictures, header.calibration)
    fingerprints = tuple(pictures[rows] for rows in rows_of(sources))
    remembered = _section(_MEMORY, arrays)
    memory = None
    if remembered:
        check_memory(remembered, sources, front_end)
        memory = memory_of(remembered, sources, fingerprints)
    landmarks = _landmarks(header.landmarks, _section("landmarks", arrays))
    slowmap = SlowMap(
        config=config,
        asked=header.asked,
        front_end=front_end,
        model=model,
        readout=readout,
        compass=compass,
        scenery=scenery,
        calibration=header.calibration,
        sources=sources,
        pictures=fingerprints,
        unit=header.unit,
        name=header.name,
        memory=memory,
        landmarks=landmarks,
    )
    if landmarks is None or landmarks.detector is None:
        return slowmap
    source = f"the landmark detector in {path.name}"
    return slowmap.with_detector(SealedDetector(landmarks.detector, source, landmarks.names))


def _landmarks(header: _Landmarks | None, arrays: dict[str, NDArray[Any]]) -> LandmarkMap | None:
    """Checked; ``None`` where the map has none."""
    if header is None:
        return None
    landmarks = LandmarkMap.from_arrays(arrays, header.names, header.calibration, header.config)
    check_landmarks(landmarks)
    return landmarks


def _compass(front_end: FrontEnd, arrays: dict[str, NDArray[Any]]) -> Compass | None:
    """Checked; ``None`` where the map has none."""
    if not arrays:
        return None
    compass = Compass.from_arrays(_phase_encoder(front_end, "compass"), arrays)
    check_compass(compass)
    return compass


def _scenery(front_end: FrontEnd, arrays: dict[str, NDArray[Any]]) -> Scenery | None:
    """Checked; ``None`` where the map has none."""
    if not arrays:
        return None
    scenery = Scenery.from_arrays(_phase_encoder(front_end, "scenery"), arrays)
    check_scenery(scenery)
    return scenery


def _phase_encoder(front_end: FrontEnd, what: str) -> PhaseEncoder:
    if front_end.phase_encoder is None:
        raise MapError(f"it has a {what}, which its camera cannot use")
    return front_end.phase_encoder


def _found_again(source: Source, path: Path) -> Source:
    if source.folder is None:
        return source
    return dataclasses.replace(source, folder=os.path.normpath(path.resolve().parent / source.folder))


def _prefixed(prefix: str, arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {f"{prefix}.{name}": array for name, array in arrays.items()}


def _section(prefix: str, arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    start = f"{prefix}."
    return {name.removeprefix(start): array for name, array in arrays.items() if name.startswith(start)}
