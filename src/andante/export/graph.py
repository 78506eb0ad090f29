"""An ONNX graph in the making: every operation returns the name of what it gives, and none is done twice.

Only standard operations of opset 17 in float32 are used, so that any runtime of 2022 or later runs the graph.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from andante.errors import MissingExtraError

if TYPE_CHECKING:
    from onnx import ModelProto, NodeProto, TensorProto

OPSET = 17
_IR_VERSION = 8
"""The one that came with opset 17; a newer one would shut out older runtimes."""

Value = str | float | np.floating[Any] | NDArray[Any]
"""The name of an intermediate result, or a constant."""


class Graph:
    """Operations and constants in order; raises ``MissingExtraError`` without onnx."""

    def __init__(self) -> None:
        try:
            import onnx
        except ImportError:
            raise MissingExtraError("onnx", "onnx") from None
        self._onnx = onnx
        self._nodes: list[NodeProto] = []
        self._constants: list[TensorProto] = []
        self._inputs: list[Any] = []
        self._outputs: list[Any] = []
        self._known: dict[tuple[object, ...], str] = {}

    def __call__(self, kind: str, *inputs: Value, **attributes: object) -> str:
        """Add an operation with one result, unless it is there already."""
        named = [self._named(one) for one in inputs]
        key = (kind, *named, repr(attributes))
        if key not in self._known:
            self._known[key] = self._add(kind, named, [f"{kind}_{len(self._nodes)}"], attributes)[0]
        return self._known[key]

    def top(self, values: Value, count: int, *, largest: bool = False) -> tuple[str, str]:
        """The ``count`` smallest or largest of values (n,), best first, and where they are."""
        outputs = [f"TopK_{len(self._nodes)}_{part}" for part in ("values", "indices")]
        inputs = [self._named(values), self._named(np.array([count]))]
        smallest, where = self._add("TopK", inputs, outputs, {"axis": -1, "largest": int(largest), "sorted": 1})
        return smallest, where

    def table(self, rows: NDArray[np.floating[Any]]) -> str:
        """A constant that may be kept in half precision, as float32."""
        return self("Cast", rows, to=self._onnx.TensorProto.FLOAT) if rows.dtype == np.float16 else self._named(rows)

    def floats(self, values: Value) -> str:
        """Whatever type as float32."""
        return self("Cast", values, to=self._onnx.TensorProto.FLOAT)

    def total(self, values: Value, *axes: int, keep: bool = False) -> str:
        """Sum over axes."""
        return self("ReduceSum", values, np.array(axes), keepdims=int(keep))

    def shaped(self, values: Value, *shape: int) -> str:
        """The same numbers in another shape."""
        return self("Reshape", values, np.array(shape))

    def part(self, values: Value, start: int, stop: int, axis: int = 0, step: int = 1) -> str:
        """``values[start:stop:step]`` along an axis."""
        return self("Slice", values, *(np.array([number]) for number in (start, stop, axis, step)))

    def square(self, values: Value) -> str:
        """Every number times itself."""
        return self("Mul", values, values)

    def image(self, name: str, shape: tuple[int, int]) -> str:
        """Declare the input (height, width) uint8."""
        self._inputs.append(self._onnx.helper.make_tensor_value_info(name, self._onnx.TensorProto.UINT8, shape))
        return name

    def output(self, name: str, value: str, shape: tuple[int, ...], *, integer: bool = False) -> None:
        """Declare a result under a name of its own."""
        self._add("Identity", [value], [name], {})
        kind = self._onnx.TensorProto.INT64 if integer else self._onnx.TensorProto.FLOAT
        self._outputs.append(self._onnx.helper.make_tensor_value_info(name, kind, shape))

    def model(self, name: str, producer_version: str, metadata: dict[str, str]) -> ModelProto:
        """All of it as a checked model."""
        helper = self._onnx.helper
        graph = helper.make_graph(self._nodes, name, self._inputs, self._outputs, self._constants)
        model: ModelProto = helper.make_model(
            graph,
            producer_name="andante",
            producer_version=producer_version,
            ir_version=_IR_VERSION,
            opset_imports=[helper.make_opsetid("", OPSET)],
        )
        helper.set_model_props(model, metadata)
        self._onnx.checker.check_model(model, full_check=True)
        return model

    def _add(self, kind: str, inputs: list[str], outputs: list[str], attributes: dict[str, Any]) -> list[str]:
        self._nodes.append(self._onnx.helper.make_node(kind, inputs, outputs, name=outputs[0], **attributes))
        return outputs

    def _named(self, value: Value) -> str:
        """Equal constants get one name; floating ones become float32, except for those in half precision."""
        if isinstance(value, str):
            return value
        array = np.asarray(value)
        if array.dtype == np.float64:
            array = array.astype(np.float32)
        key = (array.dtype.str, array.shape, array.tobytes())
        if key not in self._known:
            self._known[key] = name = f"constant_{len(self._constants)}"
            self._constants.append(self._onnx.numpy_helper.from_array(np.ascontiguousarray(array), name))
        return self._known[key]
