"""A landmark detector as one ONNX file that says of itself what it finds, where, and how sure it has to be.

The file ends with a checksum of all that comes before it, as the last entry of the model's metadata: any ONNX runtime
reads the file, and whoever wants to know whether it is whole needs no library to find out.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from andante.camera import PanoramaGeometry
from andante.errors import ConfigError, InputError, MissingExtraError
from andante.landmarks.labels import check_name
from andante.landmarks.layout import PER_LANDMARK, STRIDE, Convolution, apply, convolutions

if TYPE_CHECKING:
    from onnx import NodeProto, TensorProto

FORMAT = "andante landmark detector"
SCHEMA = 1
INPUT, OUTPUT = "panorama", "told"
KEY = "andante"

_OPSET, _IR_VERSION = 17, 8  # any runtime of 2022 or later runs it
_DIGITS = 64
LEAST_CONTRAST = 1.0  # grey levels, below which a panorama shows nothing
_Pixels = Annotated[int, Field(ge=16, le=4096)]


@dataclass(frozen=True, slots=True)
class Folded:
    """A convolution as it is used: ``weight`` (outputs, inputs, kernel, kernel) and ``bias`` (outputs,)."""

    weight: NDArray[np.float32]
    bias: NDArray[np.float32]


class Landmark(BaseModel):
    """One landmark that a detector finds: its score is sigmoid(``slope`` x heat + ``offset``)."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    name: str
    slope: Annotated[float, Field(gt=0)]
    offset: float
    threshold: Annotated[float, Field(ge=0, le=1)]


class DetectorHeader(BaseModel):
    """What a detector's file says of itself; ``notes`` are free figures of how it was learnt."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    format: Literal["andante landmark detector"] = "andante landmark detector"
    version: Annotated[Literal[1], Field(alias="schema")] = 1
    package_version: str = Field(default_factory=lambda: version("andante"))
    width_px: _Pixels
    height_px: _Pixels
    min_deg: float
    max_deg: float
    landmarks: Annotated[tuple[Landmark, ...], Field(min_length=1, max_length=100)]
    notes: dict[str, Any] = {}

    @property
    def geometry(self) -> PanoramaGeometry:
        """The panoramas that it looks at."""
        return PanoramaGeometry(self.width_px, self.height_px, self.min_deg, self.max_deg)

    @classmethod
    def of(
        cls, geometry: PanoramaGeometry, landmarks: tuple[Landmark, ...], notes: Mapping[str, Any]
    ) -> DetectorHeader:
        """From its parts."""
        return cls(
            width_px=geometry.width_px,
            height_px=geometry.height_px,
            min_deg=geometry.min_deg,
            max_deg=geometry.max_deg,
            landmarks=landmarks,
            notes=dict(notes),
        )


def written(header: DetectorHeader, layers: Mapping[str, Folded]) -> bytes:
    """The whole file; ``layers`` are those of ``layout.convolutions``. Raises ``MissingExtraError`` without onnx."""
    try:
        import onnx
    except ImportError:
        raise MissingExtraError("onnx", "onnx") from None
    graph = _Graph(layers, convolutions(len(header.landmarks)))
    height, width = header.height_px, header.width_px
    result = apply(graph, graph.normalised(INPUT))
    graph.add("Identity", [result], [OUTPUT])
    helper, kinds = onnx.helper, onnx.TensorProto
    told = (1, PER_LANDMARK * len(header.landmarks), height // STRIDE, width // STRIDE)
    model = helper.make_model(
        helper.make_graph(
            graph.nodes,
            "landmarks",
            [helper.make_tensor_value_info(INPUT, kinds.UINT8, (1, height, width, 3))],
            [helper.make_tensor_value_info(OUTPUT, kinds.FLOAT, told)],
            graph.constants,
        ),
        producer_name="andante",
        producer_version=header.package_version,
        ir_version=_IR_VERSION,
        opset_imports=[helper.make_opsetid("", _OPSET)],
    )
    helper.set_model_props(model, {KEY: header.model_dump_json(by_alias=True)})
    onnx.checker.check_model(model, full_check=True)
    data: bytes = model.SerializeToString(deterministic=True)
    return data + _seal(data)


def checked_seal(data: bytes, source: str) -> None:
    """Raise ``InputError`` where the file is not what was written."""
    size = len(_seal(b""))
    body, seal = data[:-size], data[-size:]
    if not seal.startswith(_seal(b"")[:-_DIGITS]):
        raise InputError(
            f"{source} does not end with a checksum as landmark detectors do; it is another file or was cut short"
        )
    if seal != _seal(body):
        raise InputError(f"{source} was changed after it was written: its checksum does not fit; copy it again")


def read_header(text: str | None, source: str) -> DetectorHeader:
    """What a detector's file says of itself, checked; raises ``InputError``."""
    if text is None:
        raise InputError(f"{source} is an ONNX file but no landmark detector; make one with andante teach")
    try:
        header = DetectorHeader.model_validate_json(text)
        header.geometry  # noqa: B018  (checks elevations)
    except (ValidationError, ConfigError) as error:
        fault = error.errors(include_url=False)[0] if isinstance(error, ValidationError) else None
        if fault and fault["loc"] == ("schema",):
            raise InputError(
                f"landmark detector {source} has schema {fault['input']!r:.20}, this version of andante reads "
                f"{SCHEMA}; upgrade andante"
            ) from None
        reason = f"{'.'.join(map(str, fault['loc']))}: {fault['msg'].lower()}" if fault else str(error)
        raise InputError(
            f"landmark detector {source} cannot be used: {reason}; it was written by another version or tampered with"
        ) from None
    names = [landmark.name for landmark in header.landmarks]
    for name in names:
        try:
            check_name(name)
        except InputError as error:
            raise InputError(f"landmark detector {source} cannot be used: {error}") from None
    if len(set(names)) < len(names):
        raise InputError(f"landmark detector {source} has two landmarks of one name; learn it again")
    return header


def _seal(body: bytes) -> bytes:
    """An entry ``sha256`` of ModelProto.metadata_props (field 14), which protobuf lets follow whatever came before."""
    digest = hashlib.sha256(body).hexdigest().encode()
    entry = b"\x0a\x06sha256" + b"\x12" + bytes([_DIGITS]) + digest
    return b"\x72" + bytes([len(entry)]) + entry


class _Graph:
    """The network's operations as ONNX nodes over names."""

    def __init__(self, layers: Mapping[str, Folded], plan: Mapping[str, Convolution]) -> None:
        import onnx

        self._onnx, self._layers, self._plan = onnx, layers, plan
        self.nodes: list[NodeProto] = []
        self.constants: list[TensorProto] = []

    def add(self, kind: str, inputs: list[str], outputs: list[str] | None = None, **attributes: Any) -> str:  # noqa: ANN401
        """Add a node and return the name of its result."""
        outputs = outputs or [f"{kind}_{len(self.nodes)}"]
        self.nodes.append(self._onnx.helper.make_node(kind, inputs, outputs, name=outputs[0], **attributes))
        return outputs[0]

    def constant(self, array: NDArray[Any]) -> str:
        """Add a constant and return its name."""
        name = f"constant_{len(self.constants)}"
        self.constants.append(self._onnx.numpy_helper.from_array(np.ascontiguousarray(array), name))
        return name

    def normalised(self, name: str) -> str:
        """uint8 (1, height, width, 3) -> float32 (1, 3, height, width) of mean 0 and deviation 1."""
        value = self.add("Cast", [name], to=self._onnx.TensorProto.FLOAT)
        value = self.add("Transpose", [value], perm=[0, 3, 1, 2])
        axes = [1, 2, 3]
        value = self.add("Sub", [value, self.add("ReduceMean", [value], axes=axes)])
        power = self.add("ReduceMean", [self.add("Mul", [value, value])], axes=axes)
        deviation = self.add("Sqrt", [power])
        least = self.constant(np.array(LEAST_CONTRAST, np.float32))
        return self.add("Div", [value, self.add("Max", [deviation, least])])

    def convolved(self, name: str, value: str) -> str:
        plan, layer = self._plan[name], self._layers[name]
        margin = plan.kernel // 2
        if margin:
            value = self.add(
                "Concat", [self._columns(value, -margin, None), value, self._columns(value, 0, margin)], axis=3
            )
        inputs = [value, self.constant(layer.weight), self.constant(layer.bias)]
        return self.add("Conv", inputs, pads=[margin, 0, margin, 0], strides=[plan.stride, plan.stride])

    def rectified(self, value: str) -> str:
        return self.add("Relu", [value])

    def added(self, first: str, second: str) -> str:
        return self.add("Add", [first, second])

    def doubled(self, value: str) -> str:
        scales = self.constant(np.array([1.0, 1.0, 2.0, 2.0], np.float32))
        return self.add(
            "Resize",
            [value, "", scales],
            mode="nearest",
            coordinate_transformation_mode="asymmetric",
            nearest_mode="floor",
        )

    def _columns(self, value: str, start: int, stop: int | None) -> str:
        ends = np.iinfo(np.int64).max if stop is None else stop
        bounds = [self.constant(np.array([number], np.int64)) for number in (start, ends, 3)]
        return self.add("Slice", [value, *bounds])
