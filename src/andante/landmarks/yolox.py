"""YOLOX, a detector of 80 everyday things, through onnxruntime: one picture in, boxes with names out.

Source: Ge et al., "YOLOX: Exceeding YOLO Series in 2021" (arXiv 2107.08430). The network wants BGR 0..255, the picture
in the upper left of a square that is grey elsewhere. Each of its rows tells a box relative to a cell of three grids,
how sure it is that there is anything, and the class.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.data import ImageArray
from andante.errors import ImageError, InputError, MissingExtraError
from andante.landmarks.coco_names import COCO_NAMES
from andante.landmarks.cuts import FILL, Pixels

_STRIDES = (8, 16, 32)
_BOX_AND_OBJECTNESS = 5
_SAME_OBJECT_IOU = 0.45


@dataclass(frozen=True, slots=True)
class Found:
    """Something in a picture: its rectangle in pixels, its name, a score from 0 to 1."""

    pixels: Pixels
    name: str
    score: float


class AnchorDetector:
    """A YOLOX file with the 80 classes of COCO; safe to call from many threads.

    Raises ``MissingExtraError`` without onnxruntime, ``InputError`` for a file that is missing, no ONNX, of other
    inputs and outputs, or of other classes than COCO's.
    """

    def __init__(self, path: str | Path, *, threads: int = 1) -> None:
        self._session = _opened(Path(path), threads)
        self.size_px = _checked(self._session, Path(path))
        self._input = self._session.get_inputs()[0].name
        self._cells, self._strides = _grid(self.size_px)

    @property
    def names(self) -> tuple[str, ...]:
        """What it can find."""
        return COCO_NAMES

    def __call__(self, picture: ImageArray, min_score: float = 0.3) -> list[Found]:
        """BGR (h, w, 3) uint8 -> what is in it with at least ``min_score``, surest first; raises ``ImageError``."""
        square, shrink = _letterboxed(picture, self.size_px)
        rows = self._session.run(None, {self._input: square.transpose(2, 0, 1)[None].astype(np.float32)})[0][0]
        scores = rows[:, 4:5] * rows[:, _BOX_AND_OBJECTNESS:]
        best = scores.argmax(axis=1)
        sure = np.flatnonzero(scores[np.arange(len(rows)), best] >= min_score)
        corners = self._corners(rows[sure, :4], sure) / shrink
        found = []
        for kept in _strongest(corners, scores[sure, best[sure]], best[sure]):
            left, top, right, bottom = (float(value) for value in corners[kept])
            number = sure[kept]
            found.append(Found((left, top, right, bottom), COCO_NAMES[best[number]], float(scores[number].max())))
        return found

    def _corners(self, raw: NDArray[np.float32], rows: NDArray[np.intp]) -> NDArray[np.float32]:
        """Boxes (k, 4) relative to their cells -> left, top, right, bottom in the square."""
        stride = self._strides[rows, None]
        middle = (raw[:, :2] + self._cells[rows]) * stride
        half = np.exp(np.clip(raw[:, 2:4], -20.0, 20.0)) * stride / 2.0
        corners: NDArray[np.float32] = np.concatenate([middle - half, middle + half], axis=1)
        return corners


def _letterboxed(picture: ImageArray, size_px: int) -> tuple[ImageArray, float]:
    """A picture in the upper left of a grey square, and by how much it was shrunk."""
    if picture.dtype != np.uint8 or picture.ndim != 3 or picture.shape[2] != 3 or picture.size == 0:
        raise ImageError(
            f"anchors are looked for in BGR pictures (height, width, 3) uint8, got shape {picture.shape} and type "
            f"{picture.dtype}; load frames in colour"
        )
    height, width = picture.shape[:2]
    if (height, width) == (size_px, size_px):
        return picture, 1.0
    shrink = min(size_px / height, size_px / width)
    inner = max(round(width * shrink), 1), max(round(height * shrink), 1)
    square = np.full((size_px, size_px, 3), FILL, np.uint8)
    square[: inner[1], : inner[0]] = cv2.resize(picture, inner, interpolation=cv2.INTER_LINEAR)
    return square, shrink


def _strongest(corners: NDArray[np.float32], scores: NDArray[np.float32], classes: NDArray[np.intp]) -> list[int]:
    """Which boxes are left where of several over one another only the surest of a class counts, surest first."""
    if not len(corners):
        return []
    rectangles = np.concatenate([corners[:, :2], corners[:, 2:] - corners[:, :2]], axis=1).astype(np.float64)
    kept = cv2.dnn.NMSBoxesBatched(rectangles.tolist(), scores.tolist(), classes.tolist(), 0.0, _SAME_OBJECT_IOU)
    return sorted((int(index) for index in np.asarray(kept).reshape(-1)), key=lambda index: -float(scores[index]))


def _grid(size_px: int) -> tuple[NDArray[np.float32], NDArray[np.float32]]:
    """Cells (n, 2), x and y, and strides (n,) of all rows that the network gives."""
    cells, strides = [], []
    for stride in _STRIDES:
        along = np.arange(size_px // stride)
        y, x = np.meshgrid(along, along, indexing="ij")
        cells.append(np.stack([x.reshape(-1), y.reshape(-1)], axis=1))
        strides.append(np.full(x.size, stride))
    return np.concatenate(cells).astype(np.float32), np.concatenate(strides).astype(np.float32)


def _opened(path: Path, threads: int) -> Any:  # noqa: ANN401  (onnxruntime has no types)
    try:
        import onnxruntime
    except ImportError:
        raise MissingExtraError("onnxruntime", "landmarks") from None
    if not path.is_file():
        raise InputError(f"the anchor detector {path} is no file; give the path of a YOLOX file (yolox_nano.onnx)")
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads, options.log_severity_level = threads, 3
    try:
        return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])
    except Exception as error:  # its own exceptions have no common base but this one
        reason = str(error).splitlines()[0][:120]
        raise InputError(f"the anchor detector {path} cannot be read as ONNX ({reason}); fetch it again") from None


def _checked(session: Any, path: Path) -> int:  # noqa: ANN401
    """The side of the square picture that the network takes; raises ``InputError`` where it is no YOLOX for COCO."""
    inputs = [tuple(value.shape) for value in session.get_inputs()]
    outputs = [tuple(value.shape) for value in session.get_outputs()]
    wanted = "a YOLOX file takes one picture (1, 3, s, s), s a multiple of 32, and gives one table (1, n, 85)"
    kinds = {value.type for value in (*session.get_inputs(), *session.get_outputs())}
    if kinds != {"tensor(float)"}:
        raise InputError(f"the anchor detector {path} takes or gives {', '.join(sorted(kinds))}, not floats; {wanted}")
    shape = inputs[0] if len(inputs) == 1 else ()
    square = len(shape) == 4 and shape[:2] == (1, 3) and shape[2] == shape[3] and isinstance(shape[2], int)
    if not square or shape[2] < 32 or shape[2] % 32 or len(outputs) != 1 or len(outputs[0]) != 3:
        raise InputError(f"the anchor detector {path} has inputs {inputs} and outputs {outputs}; {wanted}")
    rows, columns = outputs[0][1:]
    if columns != _BOX_AND_OBJECTNESS + len(COCO_NAMES):
        classes = columns - _BOX_AND_OBJECTNESS if isinstance(columns, int) else columns
        raise InputError(
            f"the anchor detector {path} knows {classes} classes, not the {len(COCO_NAMES)} of COCO; "
            "give one that learnt from COCO, as yolox_nano.onnx"
        )
    size = int(shape[2])
    cells = sum((size // stride) ** 2 for stride in _STRIDES)
    if rows != cells:
        raise InputError(f"the anchor detector {path} gives {rows} rows for {size} px, expected {cells}; {wanted}")
    return size
