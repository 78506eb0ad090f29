"""Pictures to panoramas in a graph: what ``Unwrapper`` has OpenCV do, to the last bit where OpenCV is exact."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.camera import FisheyeTable, Shrinking, Unwrapper
from andante.export.graph import Graph, Value

_FIXED_POINT_STEP_PX = np.float32(1 / 32)


def add_panorama(graph: Graph, image: str, unwrapper: Unwrapper) -> str:
    """Grey image (height, width) uint8 -> panorama (H, W) float32 with whole numbers."""
    if isinstance(unwrapper.lookup, FisheyeTable):
        return _looked_up(graph, image, unwrapper.lookup, unwrapper.image_shape)
    return _shrunk(graph, image, unwrapper.lookup, unwrapper.image_shape)


def _looked_up(graph: Graph, image: str, table: FisheyeTable, shape: tuple[int, int]) -> str:
    height, width = shape
    picture = image
    for _ in range(table.halvings):
        even = graph.part(graph.part(picture, 0, height // 2 * 2), 0, width // 2 * 2, axis=1)
        height, width = height // 2, width // 2
        pixels = graph.shaped(graph.floats(even), 1, 1, 2 * height, 2 * width)
        means = graph("AveragePool", pixels, kernel_shape=[2, 2], strides=[2, 2])
        picture = graph.shaped(_rounded_up(graph, means), height, width)
    if table.blur:
        pixels = graph.shaped(graph.floats(picture), 1, 1, height, width)
        padded = graph("Pad", pixels, np.array([0, 0, 1, 1, 0, 0, 1, 1]), mode="reflect")
        # Two means over 2 x 2 are one binomial 1-2-1, exact in binary fractions, and here faster than a convolution.
        smooth = padded
        for _ in range(2):
            smooth = graph("AveragePool", smooth, kernel_shape=[2, 2], strides=[1, 1])
        picture = graph.shaped(_rounded_up(graph, smooth), height, width)
    return _between(graph, picture, table, (height, width))


def _between(graph: Graph, picture: str, table: FisheyeTable, shape: tuple[int, int]) -> str:
    """Bilinear interpolation in the order of OpenCV's sums, which decides about the last bit and so about rounding."""
    height, width = shape
    x, y, fixed_point = _positions(table, shape)
    left, above = np.floor(x).astype(np.int32), np.floor(y).astype(np.int32)
    # Beyond the last pixel weights are zero.
    right, below = np.minimum(left + 1, width - 1), np.minimum(above + 1, height - 1)
    taps = np.array([[row * width + column for row in (above, below)] for column in (left, right)])
    pixels = graph.floats(graph("Gather", graph.shaped(picture, -1), taps, axis=0))
    rows = _blend(graph, pixels, x - left, axis=0)
    means = graph.shaped(_blend(graph, rows, y - above, axis=1), *x.shape)
    return _rounded_up(graph, means) if fixed_point else graph("Round", means)


def _blend(graph: Graph, values: str, share: NDArray[np.float32], axis: int) -> str:
    """Between the first and the second along an axis of two."""
    first, second = (graph.part(values, at, at + 1, axis) for at in (0, 1))
    return graph("Add", first, graph("Mul", graph("Sub", second, first), share))


def _positions(table: FisheyeTable, shape: tuple[int, int]) -> tuple[NDArray[np.float32], NDArray[np.float32], bool]:
    """Where OpenCV really looks, and whether in fixed point: version 4 rounds to 1/32 px, version 5 does not."""
    ramp = np.tile(np.arange(shape[1], dtype=np.float32), (shape[0], 1))
    seen = np.asarray(cv2.remap(ramp, table.x_px, table.y_px, cv2.INTER_LINEAR), np.float32)
    if np.abs(seen - table.x_px).max() < _FIXED_POINT_STEP_PX / 8:
        return table.x_px, table.y_px, False
    x, y = (np.rint(one / _FIXED_POINT_STEP_PX) * _FIXED_POINT_STEP_PX for one in (table.x_px, table.y_px))
    return x.astype(np.float32), y.astype(np.float32), True


def _shrunk(graph: Graph, image: str, shrinking: Shrinking, shape: tuple[int, int]) -> str:
    turned: Value = image
    if shrinking.columns is not None:
        turned = graph("Gather", image, shrinking.columns.astype(np.int32), axis=1)
    pixels = graph.floats(turned)
    if shrinking.shape == shape:
        return pixels
    times = [old // new if old % new == 0 else 0 for old, new in zip(shape, shrinking.shape, strict=True)]
    whole = all(times)
    rows, columns = (_areas(*sizes, whole=whole) for sizes in zip(shape, shrinking.shape, strict=True))
    # Along the rows first, as OpenCV does.
    sums = graph("MatMul", rows, graph("MatMul", pixels, columns.T))
    if not whole:
        return graph("Round", sums)
    # OpenCV adds whole blocks as integers and divides once; of halves, only those of 2 x 2 are rounded up.
    means = graph("Mul", sums, 1 / (times[0] * times[1]))
    return _rounded_up(graph, means) if times == [2, 2] else graph("Round", means)


def _areas(old: int, new: int, *, whole: bool) -> NDArray[np.float32]:
    """(new, old) weights of averaging over areas, as OpenCV has them; ones instead where blocks are ``whole``."""
    if old == new:
        return np.eye(old, dtype=np.float32)
    identity = np.eye(old, dtype=np.float32)
    areas = np.asarray(cv2.resize(identity, (old, new), interpolation=cv2.INTER_AREA), np.float32)
    return (areas > 0).astype(np.float32) if whole else areas


def _rounded_up(graph: Graph, values: str) -> str:
    """To the nearest whole number, halves up, as OpenCV rounds in fixed point; ``Round`` takes halves to even."""
    return graph("Floor", graph("Add", values, 0.5))
