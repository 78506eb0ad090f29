"""Somebody else's network in an ONNX file, as a function from pictures to vectors."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from andante.errors import ConfigError, MissingExtraError
from andante.features.illumination import Float32Array

if TYPE_CHECKING:  # an extra
    from onnxruntime import InferenceSession


class OnnxNetwork:
    """Pictures (n, ``channels``, ``input_px``) float32 -> vectors (n, d), run by onnxruntime in one thread.

    ``output`` names a tensor of the graph, by default its last output; maps (n, d, height, width) and tokens (n, m, d)
    are averaged over what is not d. Raises ``ConfigError`` for a file that is missing, is no ONNX model, has other than
    one input of floats (n, 1 or 3, height, width), or no such tensor; ``MissingExtraError`` without onnxruntime, or for
    a tensor within the graph without onnx.
    """

    def __init__(self, path: Path, output: str | None = None, input_px: tuple[int, int] | None = None) -> None:
        if not path.is_file():
            raise ConfigError(f"there is no network at {path}; give the path of an ONNX file")
        self.path = path
        self._session = _session(path)
        outputs = [one.name for one in self._session.get_outputs()]
        self.output = outputs[-1] if output is None else output
        if self.output not in outputs:
            self._session = _session(path, self.output)
        self.channels, self.input_px = _picture_shape(path, self._session.get_inputs(), input_px)
        self._input = self._session.get_inputs()[0].name
        self._one_by_one = isinstance(self._session.get_inputs()[0].shape[0], int)

    def __call__(self, pictures: Float32Array) -> Float32Array:
        """(n, channels, height, width) -> (n, d); raises ``ConfigError`` where its output is no vector or map."""
        batches = np.split(pictures, len(pictures)) if self._one_by_one else [pictures]
        return np.concatenate(
            [self._pooled(self._session.run([self.output], {self._input: one})[0]) for one in batches]
        )

    def _pooled(self, array: NDArray[Any]) -> Float32Array:
        if array.ndim not in (2, 3, 4) or not np.issubdtype(array.dtype, np.floating):
            raise ConfigError(
                f"output {self.output!r} of {self.path} is {array.dtype} of shape {array.shape}; an embedding is float "
                "(n, d), (n, m, d) or (n, d, height, width); name another tensor as output"
            )
        axes = {2: (), 3: (1,), 4: (2, 3)}[array.ndim]
        pooled: Float32Array = array.mean(axis=axes, dtype=np.float32) if axes else array.astype(np.float32)
        return pooled


def _session(path: Path, extra_output: str | None = None) -> InferenceSession:
    try:
        import onnxruntime
    except ModuleNotFoundError:
        raise MissingExtraError("onnxruntime", "onnx") from None
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = options.inter_op_num_threads = 1
    options.log_severity_level = 4
    model = str(path) if extra_output is None else _with_output(path, extra_output)
    try:
        return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])
    except Exception as error:  # onnxruntime's own exceptions have no common base but this
        what = str(error).splitlines()[0]
        raise ConfigError(f"{path} is not an ONNX model that onnxruntime can run: {what}; export it again") from None


def _with_output(path: Path, name: str) -> bytes:
    """The model with a tensor of its graph as one more output."""
    try:
        import onnx
    except ModuleNotFoundError:
        raise MissingExtraError("onnx", "onnx") from None
    model = onnx.load(str(path))
    if name not in {tensor for node in model.graph.node for tensor in node.output}:
        outputs = ", ".join(one.name for one in model.graph.output)
        raise ConfigError(f"{path} has no tensor {name!r}; its outputs are {outputs}, open it in a viewer for the rest")
    model.graph.output.append(onnx.ValueInfoProto(name=name))
    return bytes(model.SerializeToString())


def _picture_shape(path: Path, inputs: list[Any], input_px: tuple[int, int] | None) -> tuple[int, tuple[int, int]]:
    """Channels and (height, width) of the only input."""
    if len(inputs) != 1:
        names = ", ".join(one.name for one in inputs)
        raise ConfigError(f"{path} has {len(inputs)} inputs ({names}); an embedding takes one, the picture")
    shape, kind = list(inputs[0].shape), inputs[0].type
    # The size of a batch is open or one; of any other size batches would have to be filled up.
    fits = len(shape) == 4 and shape[1] in (1, 3) and (shape[0] == 1 or not isinstance(shape[0], int))
    if not fits or kind != "tensor(float)":
        raise ConfigError(
            f"the input of {path} is {kind} of shape {shape}; an embedding takes tensor(float) of "
            "(1 or any, 1 or 3, height, width); export it with channels first"
        )
    height, width = shape[2:]
    if isinstance(height, int) and isinstance(width, int):
        if input_px not in (None, (height, width)):
            raise ConfigError(
                f"{path} takes pictures of {(height, width)}, not input_px {input_px}; leave input_px out"
            )
        return shape[1], (height, width)
    if input_px is None or min(input_px) < 1:
        raise ConfigError(f"{path} leaves the size of its pictures open; give input_px (height, width), as 224, 224")
    return shape[1], input_px
