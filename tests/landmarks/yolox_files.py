"""Tiny ONNX files of the form of YOLOX's, which tell what they are told to tell."""

from pathlib import Path

import numpy as np
from onnx import TensorProto, helper, numpy_helper, save

SIZE = 64
CELLS = 8 * 8 + 4 * 4 + 2 * 2


def row_of(stride: int, column: int, row: int) -> int:
    """Where in the table a cell of a grid is."""
    start = {8: 0, 16: 64, 32: 80}[stride]
    return start + row * (SIZE // stride) + column


def table(rows: dict[int, tuple[tuple[float, float, float, float], int, float]], columns: int = 85) -> np.ndarray:
    """Rows by index: (dx, dy, log width, log height) in cells, class, score."""
    values = np.zeros((1, CELLS, columns), np.float32)
    for index, (box, kind, score) in rows.items():
        values[0, index, :4] = box
        values[0, index, 4] = 1.0
        values[0, index, 5 + kind] = score
    return values


def write_yolox(
    path: Path, values: np.ndarray, *, size: int = SIZE, inputs: int = 3, kind: int = TensorProto.FLOAT
) -> Path:
    """A file that gives ``values`` times the blueness of the picture's mean (1 for pure blue) in objectness."""
    blue = np.zeros_like(values)
    blue[..., 4] = values[..., 4]
    rest = values - blue
    nodes = [
        helper.make_node("Cast", ["images"], ["floats"], to=TensorProto.FLOAT),
        helper.make_node("Slice", ["floats", "from", "to", "axis"], ["first"]),
        helper.make_node("ReduceMax", ["first"], ["level"], axes=[1, 2, 3], keepdims=0),
        helper.make_node("Mul", ["level", "scale"], ["share"]),
        helper.make_node("Mul", ["blue", "share"], ["lit"]),
        helper.make_node("Add", ["lit", "rest"], ["output"]),
    ]
    constants = {
        "from": np.array([0], np.int64),
        "to": np.array([1], np.int64),
        "axis": np.array([1], np.int64),
        "scale": np.array([1 / 255], np.float32),
        "blue": blue,
        "rest": rest,
    }
    graph = helper.make_graph(
        nodes,
        "yolox",
        [helper.make_tensor_value_info("images", kind, [1, inputs, size, size])],
        [helper.make_tensor_value_info("output", TensorProto.FLOAT, list(values.shape))],
        [numpy_helper.from_array(value, name) for name, value in constants.items()],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    save(model, str(path))
    return path
