"""A whole map as one ONNX file: an image in, a position and what it is worth out."""

from __future__ import annotations

import dataclasses
import hashlib
import json
from dataclasses import dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from andante.errors import ConfigError, MapError
from andante.export.compass import CompassInGraph
from andante.export.encoders import add_encoder
from andante.export.graph import OPSET, Graph
from andante.export.judgement import (
    STATUSES,
    add_covariance,
    add_doubt,
    add_heading,
    add_known,
    add_radius,
    add_status,
    add_tempered,
)
from andante.export.local_readout import add_local
from andante.export.panoramas import add_panorama
from andante.export.regressions import LocatedNames, add_gaussian_process, add_polynomial
from andante.export.slow_models import add_slow_model
from andante.files import replace_file
from andante.mapping import SlowMap
from andante.mapping.located import Readout
from andante.mapping.readout import LocalReadout
from andante.mapping.regressions import GaussianProcessReadout, PolynomialReadout

_Shape = tuple[int, ...]


@dataclass(frozen=True)
class ExportedMap:
    """What was written: size in ``bytes``, ``opset``, the shapes of ``inputs`` and ``outputs`` by name."""

    bytes: int
    opset: int
    inputs: dict[str, _Shape]
    outputs: dict[str, _Shape]


def export_onnx(slowmap: SlowMap, path: str | Path, *, image_shape: tuple[int, int] | None = None) -> ExportedMap:
    """Write the map as an ONNX file that takes grey images (height, width) uint8 of one size.

    ``image_shape`` (height, width) defaults to that of the map's camera; others have to have its proportions. Outputs:
    ``slow`` (k,), ``xy`` (2,) and ``covariance`` (2, 2) and ``radius`` (1,) in the unit of the map, ``heading_rad`` and
    ``heading_deviation_rad`` (1,), ``likeness`` (1,), ``agreement`` (1,) and ``status`` (1,) int64, a number from the
    metadata's ``statuses``. Where the status has no pose all that belongs to one is NaN, and so is a heading that is
    not known. Raises ``MissingExtraError`` without onnx, ``ConfigError`` for an encoder or readout that has no such
    form, ``ImageError`` for a size that does not fit, ``MapError`` where the file cannot be written.
    """
    shape = image_shape or slowmap.front_end.image_shape
    graph = Graph()
    outputs = _add_map(graph, graph.image("image", shape), slowmap, shape)
    model = graph.model(slowmap.name, version("andante"), _metadata(slowmap, shape))
    data = model.SerializeToString(deterministic=True)
    try:
        replace_file(Path(path), data)
    except OSError as error:
        reason = error.strerror or error
        raise MapError(f"ONNX file {path} cannot be written: {reason}; choose another place with -o") from None
    return ExportedMap(len(data), OPSET, {"image": shape}, outputs)


def _add_map(graph: Graph, image: str, slowmap: SlowMap, shape: tuple[int, int]) -> dict[str, _Shape]:
    """The way of an image through a map, as ``SlowMap.localize`` goes it; shapes of the outputs by name."""
    panorama = add_panorama(graph, image, slowmap.front_end.unwrapper(shape))
    features = add_encoder(graph, panorama, slowmap.front_end.encoder)
    slow, spread = add_slow_model(graph, features, slowmap.model)
    compass = None if slowmap.compass is None else CompassInGraph.of(graph, panorama, slowmap.compass)
    located = _add_readout(graph, slow, slowmap.readout, compass)
    likeness, doubt = add_tempered(graph, located, spread), graph("Identity", np.ones(1))
    bearings = None if compass is None else compass.bearings(located.xy)
    if bearings is not None:
        likeness, doubt = graph("Mul", likeness, bearings.peak), add_doubt(graph, bearings.peak)
    bounds = slowmap.calibration
    status = add_status(graph, panorama, likeness, located.agreement, bounds)
    radius = add_radius(graph, located.covariance, doubt, bounds.radius_factor)
    covariance = add_covariance(graph, located.covariance, radius)
    heading, deviation = add_heading(graph, bearings, doubt, bounds.heading_factor)
    results: dict[str, tuple[str, _Shape]] = {
        "slow": (slow, (slowmap.model.output_dim,)),
        "xy": (add_known(graph, located.xy, status), (2,)),
        "covariance": (add_known(graph, covariance, status), (2, 2)),
        "radius": (add_known(graph, radius, status), (1,)),
        "heading_rad": (add_known(graph, heading, status), (1,)),
        "heading_deviation_rad": (add_known(graph, deviation, status), (1,)),
        "likeness": (likeness, (1,)),
        "agreement": (located.agreement, (1,)),
        "status": (status, (1,)),
    }
    for name, (value, size) in results.items():
        graph.output(name, value, size, integer=name == "status")
    return {name: size for name, (_, size) in results.items()}


def _add_readout(graph: Graph, slow: str, readout: Readout, compass: CompassInGraph | None) -> LocatedNames:
    if isinstance(readout, LocalReadout):
        return add_local(graph, slow, readout, compass)
    if isinstance(readout, PolynomialReadout):
        return add_polynomial(graph, slow, readout)
    if isinstance(readout, GaussianProcessReadout):
        return add_gaussian_process(graph, slow, readout)
    raise ConfigError(
        f"a map with the readout {type(readout).__name__} cannot be exported; local, polynomial and gaussian-process "
        "can: build the map with one of them"
    )


def _metadata(slowmap: SlowMap, shape: tuple[int, int]) -> dict[str, str]:
    """What a map says of itself; values that are not plain text are JSON."""
    described = slowmap.describe()
    sources = [{key: one[key] for key in ("name", "content_hash", "conditions")} for one in described["recordings"]]
    camera = dataclasses.asdict(slowmap.front_end.camera)
    return {
        "name": slowmap.name,
        "unit": slowmap.unit,
        "package_version": version("andante"),
        "provenance": _json(sources),
        "provenance_hash": _hash([sources, described["config"], camera]),
        "camera": _json(camera),
        "image_px": _json([shape[1], shape[0]]),
        "statuses": _json([status.value for status in STATUSES]),
        "radius_holds": _json(slowmap.config.calibration.coverage),
        "heading_invariant": _json(slowmap.heading_invariant),
        "tells_heading": _json(slowmap.tells_heading),
        "features": described["features"],
        "readout": slowmap.config.readout.kind,
    }


def _json(value: Any) -> str:  # noqa: ANN401 (whatever JSON can hold)
    return json.dumps(value, sort_keys=True)


def _hash(value: Any) -> str:  # noqa: ANN401 (whatever JSON can hold)
    return hashlib.sha256(_json(value).encode()).hexdigest()
