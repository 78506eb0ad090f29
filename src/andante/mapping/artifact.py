"""A map as one file: safetensors with JSON metadata, no pickle.

The file is checked before anything of it is used: size, header, schema, the names, types and shapes of all arrays,
and that they fit each other. It is written beside its place, flushed and renamed, so that a reader sees the old map or
the new one and never half of either.
"""

from __future__ import annotations

import dataclasses
import json
import os
import tempfile
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from pydantic import TypeAdapter
from safetensors import SafetensorError, safe_open
from safetensors.numpy import save

from andante.data import CameraSpec
from andante.errors import AndanteError, MapError
from andante.mapping.calibration import Calibration
from andante.mapping.compact import CompactModel
from andante.mapping.config import MapConfig
from andante.mapping.frontend import FrontEnd
from andante.mapping.readout import GaussianProcessReadout, LocalReadout, PolynomialReadout, Readout
from andante.mapping.slow_map import SlowMap, Source

SCHEMA = 1
_CAMERA = TypeAdapter(CameraSpec)
_CALIBRATION = TypeAdapter(Calibration)
_SOURCE = TypeAdapter(Source)
MAX_BYTES = 2**31
_FORMAT = "andante-map"
_READOUTS: dict[str, type[LocalReadout] | type[PolynomialReadout] | type[GaussianProcessReadout]] = {
    "local": LocalReadout,
    "polynomial": PolynomialReadout,
    "gaussian-process": GaussianProcessReadout,
}


def write_map(slowmap: SlowMap, path: str | Path) -> int:
    """Write atomically and return the size in bytes; raises ``MapError`` where the place cannot be written."""
    path = Path(path)
    arrays = _prefixed("model", slowmap.model.to_arrays()) | _prefixed("readout", slowmap.readout.to_arrays())
    # safetensors 0.8 writes the memory of a strided view as if it were contiguous.
    contiguous = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    metadata = {"format": _FORMAT, "schema": str(SCHEMA), "map": json.dumps(_header(slowmap, path), sort_keys=True)}
    data = save(contiguous, metadata=metadata)
    try:
        _replace(path, data)
    except OSError as error:
        raise MapError(f"map {path} cannot be written: {error.strerror}; choose another place with -o") from None
    return len(data)


def read_map(path: str | Path) -> SlowMap:
    """Read and check a map; raises ``MapError`` saying what is wrong with it."""
    path = Path(path)
    try:
        size = path.stat().st_size
    except OSError as error:
        raise MapError(f"map {path} cannot be read: {error.strerror}; make one with: andante map") from None
    if not path.is_file() or size > MAX_BYTES:
        raise MapError(f"map {path} is no map: {size} bytes, a map is a file of at most {MAX_BYTES}")
    try:
        with safe_open(path, framework="numpy") as file:
            header = _checked_header(file.metadata() or {}, path)
            arrays = {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118 (not a mapping)
    except (SafetensorError, OSError, ValueError) as error:
        raise MapError(f"map {path} is damaged or no map: {error}; make it again with: andante map") from None
    try:
        return _assembled(header, arrays, path)
    except (AndanteError, KeyError, TypeError, ValueError, AttributeError) as error:
        raise MapError(f"map {path} is inconsistent: {error}; make it again with: andante map") from None


def _header(slowmap: SlowMap, path: Path) -> dict[str, Any]:
    front_end = slowmap.front_end
    return {
        "package_version": version("andante"),
        "name": slowmap.name,
        "unit": slowmap.unit,
        "config": slowmap.config.model_dump(mode="json"),
        "camera": dataclasses.asdict(front_end.camera),
        "image_shape": list(front_end.image_shape),
        "calibration": dataclasses.asdict(slowmap.calibration),
        "sources": [_source(source, path) for source in slowmap.sources],
    }


def _source(source: Source, path: Path) -> dict[str, Any]:
    """As plain values; the folder relative to the map, so that both can move together."""
    values = dataclasses.asdict(source)
    if source.folder is not None:
        values["folder"] = os.path.relpath(source.folder, path.resolve().parent)
    return values


def _replace(path: Path, data: bytes) -> None:
    with tempfile.NamedTemporaryFile(dir=path.parent, prefix=f".{path.name}.", delete=False) as file:
        try:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
            # The mode that a plainly written file would have got; temporary files are private.
            umask = os.umask(0)
            os.umask(umask)
            os.chmod(file.name, 0o666 & ~umask)  # noqa: PTH101 (file.name is a string)
            os.replace(file.name, path)  # noqa: PTH105
        except BaseException:
            Path(file.name).unlink(missing_ok=True)
            raise


def _checked_header(metadata: Mapping[str, str], path: Path) -> dict[str, Any]:
    if metadata.get("format") != _FORMAT:
        raise MapError(f"map {path} is no Andante map; make one with: andante map")
    schema = metadata.get("schema", "")
    if not schema.isdecimal() or int(schema) != SCHEMA:
        raise MapError(
            f"map {path} has schema {schema or 'none'}, this version of andante reads schema {SCHEMA}; "
            "upgrade andante or make the map again"
        )
    header = json.loads(metadata.get("map", "null"))
    if not isinstance(header, dict):
        raise MapError(f"map {path} has no description; make it again with: andante map")
    return header


def _assembled(header: dict[str, Any], arrays: dict[str, NDArray[Any]], path: Path) -> SlowMap:
    config = MapConfig.checked(header["config"])
    camera = _CAMERA.validate_python(header["camera"])
    height, width = (int(side) for side in header["image_shape"])
    front_end = FrontEnd(camera, (height, width), config.panorama, config.features)
    for name, array in arrays.items():
        if array.dtype.kind not in "fi" or not np.isfinite(array).all():
            raise MapError(f"array {name} holds {array.dtype} or values that are not finite")
    model = CompactModel.from_arrays(_section("model", arrays))
    readout = _READOUTS[config.readout.kind].from_arrays(_section("readout", arrays))
    _check_shapes(front_end, model, readout)
    calibration = _CALIBRATION.validate_python(header["calibration"])
    sources = tuple(_read_source(values, path) for values in header["sources"])
    return SlowMap(config, front_end, model, readout, calibration, sources, header["unit"], header["name"])


def _read_source(values: dict[str, Any], path: Path) -> Source:
    folder = values["folder"]
    values["folder"] = None if folder is None else os.path.normpath(path.resolve().parent / folder)
    return _SOURCE.validate_python(values)


def _check_shapes(front_end: FrontEnd, model: CompactModel, readout: Readout) -> None:
    """Every product that localizing will form; the shapes inside one part are its own business."""
    r = model.weights.shape[1] if model.weights.ndim == 2 else -1
    k = model.output_dim
    _expect("model.mean", model.mean, (front_end.dim,), "f4")
    _expect("model.weights", model.weights, (front_end.dim, r), "f4")
    if model.quadratic is None:
        _expect("model.deltas", model.deltas, (r,), "f8")
    else:
        terms = r + r * (r + 1) // 2
        _expect("model.quadratic.weights", model.quadratic.weights, (terms, k), "f8")
    if isinstance(readout, LocalReadout):
        count = len(readout.references)
        _expect("readout.references", readout.references, (count, k), "f4")
        _expect("readout.xy", readout.xy, (count, 2), "f8")
        _expect("readout.metric", readout.metric, (k,), "f8")
        if not 1 <= readout.neighbours <= count:
            raise MapError(f"{readout.neighbours} neighbours of {count} references")
    elif isinstance(readout, GaussianProcessReadout):
        count = len(readout.points)
        _expect("readout.points", readout.points, (count, k), "f8")
        _expect("readout.metric", readout.metric, (k,), "f8")
        _expect("readout.dual", readout.dual, (count, 2), "f8")
        _expect("readout.factor", readout.factor, (count, count), "f8")
        _expect("readout.mean", readout.mean, (2,), "f8")
    elif isinstance(readout, PolynomialReadout):
        _expect("readout.coefficients", readout.coefficients, (readout.terms, 2), "f8")
        _expect("readout.residual", readout.residual, (2, 2), "f8")


def _expect(name: str, array: NDArray[Any], shape: tuple[int, ...], dtype: str) -> None:
    if array.shape != shape or array.dtype != np.dtype(dtype):
        raise MapError(f"array {name} is {array.dtype} of shape {array.shape}, expected {np.dtype(dtype)} {shape}")


def _prefixed(prefix: str, arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    return {f"{prefix}.{name}": array for name, array in arrays.items()}


def _section(prefix: str, arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    start = f"{prefix}."
    return {name.removeprefix(start): array for name, array in arrays.items() if name.startswith(start)}
