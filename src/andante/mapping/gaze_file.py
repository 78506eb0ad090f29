"""A map of gazes as one file: safetensors with JSON metadata, no pickle, written whole or not at all."""

from __future__ import annotations

import dataclasses
import json
from importlib.metadata import version
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from andante.data import CameraSpec
from andante.errors import AndanteError, MapError
from andante.files import replace_file
from andante.mapping.artifact import MAX_BYTES
from andante.mapping.codes import Codes
from andante.mapping.config import FeatureConfig
from andante.mapping.frontend import FrontEnd
from andante.mapping.gaze import GazeMap, patch_encoder
from andante.mapping.gaze_calibration import GazeBounds
from andante.mapping.gaze_config import GazeConfig
from andante.mapping.gaze_lesson import rules_of
from andante.mapping.gaze_readout import GazeModel, GazeReadout
from andante.mapping.gaze_votes import Gallery
from andante.mapping.memory import Source

SCHEMA = 1
_KEY = "andante-gaze"
_AGAIN = "make it again with build_gaze_map"
_TYPES = {"mean": "F32", "weights": "F32", "codes": "I8", "scale": "F32", "xy": "F64", "points": "F64"}
_Side = Annotated[int, Field(ge=1, le=2**16)]


class _Header(BaseModel):
    """What a map of gazes says of itself beside its arrays."""

    model_config = ConfigDict(extra="forbid", allow_inf_nan=False)

    schema_: int = Field(alias="schema")
    package_version: str
    name: str
    config: GazeConfig
    camera: CameraSpec
    image_shape: tuple[_Side, _Side]
    bounds: Annotated[tuple[GazeBounds, ...], Field(min_length=1)]
    sources: tuple[Source, ...]


def write_gaze_map(gaze: GazeMap, path: str | Path) -> int:
    """Write atomically and return the size in bytes; raises ``MapError`` where the place cannot be written."""
    path, model, gallery = Path(path), gaze.readout.model, gaze.readout.gallery
    header = {
        "schema": SCHEMA,
        "package_version": version("andante"),
        "name": gaze.name,
        "config": gaze.config.model_dump(mode="json"),
        "camera": dataclasses.asdict(gaze.front_end.camera),
        "image_shape": list(gaze.front_end.image_shape),
        "bounds": [dataclasses.asdict(bounds) for bounds in gaze.bounds],
        # Where drives lie is nobody's business in a map that does not read them again.
        "sources": [dataclasses.asdict(dataclasses.replace(source, folder=None)) for source in gaze.sources],
    }
    codes = Codes.of(gallery.slow.reshape(-1, gallery.slow.shape[2]))
    arrays = {
        "mean": model.mean,
        "weights": model.weights,
        "xy": gallery.xy,
        "points": gallery.points_m,
        **codes.to_arrays(),
    }
    try:
        data = save(
            {name: np.ascontiguousarray(array) for name, array in arrays.items()},
            metadata={_KEY: json.dumps(header, sort_keys=True, allow_nan=False)},
        )
        replace_file(path, data)
    except OSError as error:
        raise MapError(
            f"map {path} cannot be written: {error.strerror or error}; choose another place for it"
        ) from None
    except (TypeError, ValueError) as error:
        raise MapError(f"map {path} cannot be written: {error}; conditions of recordings hold plain values") from None
    return len(data)


def read_gaze_map(path: str | Path) -> GazeMap:
    """Read and check a map of gazes; raises ``MapError`` saying what is wrong with it."""
    path = Path(path)
    try:
        if not path.is_file() or path.stat().st_size > MAX_BYTES:
            raise MapError(f"there is no such file of at most {MAX_BYTES} bytes")
        header, arrays = _read(path)
        return _assembled(header, arrays)
    except ValidationError as error:
        fault = error.errors(include_url=False, include_input=False)[0]
        where = ".".join(map(str, fault["loc"])) or "header"
        raise MapError(f"map {path} cannot be used: its {where} is wrong: {fault['msg']}; {_AGAIN}") from None
    except (SafetensorError, OSError) as error:
        raise MapError(f"map {path} is damaged or no map of gazes: {error}; {_AGAIN}") from None
    except (AndanteError, KeyError, TypeError, ValueError, RecursionError) as error:
        raise MapError(f"map {path} cannot be used: {error}; {_AGAIN}") from None


def _read(path: Path) -> tuple[_Header, dict[str, NDArray[Any]]]:
    with safe_open(path, framework="numpy") as file:
        text = (file.metadata() or {}).get(_KEY)
        if text is None:
            raise MapError("it is no map of gazes")
        values = json.loads(text)
        if not isinstance(values, dict) or values.get("schema") != SCHEMA:
            raise MapError(f"it has another schema than {SCHEMA}, which this version of andante reads")
        found = {name: file.get_slice(name).get_dtype() for name in file.keys()}  # noqa: SIM118 (not a mapping)
        if found != _TYPES:
            raise MapError(f"it has arrays {found}, a map of gazes has {_TYPES}")
        return _Header.model_validate(values), {name: file.get_tensor(name) for name in _TYPES}


def _assembled(header: _Header, arrays: dict[str, NDArray[Any]]) -> GazeMap:
    for name, array in arrays.items():
        if name != "points" and not np.isfinite(array).all():
            raise MapError(f"array {name} holds values that are not finite")
    counts = [bounds.patches for bounds in header.bounds]
    if counts[0] != 1 or counts != sorted(set(counts)):
        raise MapError(f"its bounds are of {counts} patches, they have to rise from 1")
    config = header.config
    front_end = FrontEnd(header.camera, header.image_shape, config.panorama, FeatureConfig())
    encoder = patch_encoder(front_end, config)
    model, codes = GazeModel(arrays["mean"], arrays["weights"]), Codes.from_arrays(arrays)
    frames = len(arrays["xy"])
    shapes = model.mean.shape, model.weights.shape, codes.codes.shape, codes.scale.shape
    expected = (encoder.dim,), (encoder.dim, codes.dim), (frames * config.regions, codes.dim), (len(codes),)
    if shapes != expected:
        raise MapError(f"its arrays have shapes {shapes}, its configuration asks for {expected}")
    gallery = Gallery(codes.rows().reshape(frames, config.regions, codes.dim), arrays["xy"], arrays["points"])
    readout = GazeReadout(encoder, model, gallery, rules_of(config))
    return GazeMap(config, front_end, readout, header.bounds, header.sources, header.name)
