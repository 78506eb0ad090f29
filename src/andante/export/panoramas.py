"""Pictures to panoramas in a graph: what ``Unwrapper`` has OpenCV do, to the last bit where OpenCV is exact."""

from __future__ import annotations

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.camera import FisheyeTable, Shrinking, Unwrapper
from andante.export.graph import Graph, Value

_BINOMIAL = np.outer((1, 2, 1), (1, 2, 1)).astype(np.float32) / 16


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
        smooth = graph("Conv", padded, _BINOMIAL[None, None], kernel_shape=[3, 3])
        picture = graph.shaped(_rounded_up(graph, smooth), height, width)
    taps, weights = _bilinear(table, (height, width))
    pixels = graph.floats(graph("Gather", graph.shaped(picture, -1), taps, axis=0))
    return _rounded_up(graph, graph.total(graph("Mul", pixels, weights), 0))


def _bilinear(table: FisheyeTable, shape: tuple[int, int]) -> tuple[NDArray[np.int32], NDArray[np.float32]]:
    """Which four pixels of a flat picture make each pixel of the panorama, and their weights: (4, H, W) each."""
    height, width = shape
    # OpenCV 4 rounds positions to 1/32 px, OpenCV 5 does not: what it makes of ramps says where it really looks.
    down, right = np.mgrid[:height, :width].astype(np.float32)
    x, y = (cv2.remap(ramp, table.x_px, table.y_px, cv2.INTER_LINEAR) for ramp in (right, down))
    x, y = (np.clip(np.asarray(p, np.float64), 0, size - 1) for p, size in ((x, width), (y, height)))
    left, above = np.floor(x).astype(np.int32), np.floor(y).astype(np.int32)
    taps, weights = [], []
    for dy in (0, 1):
        for dx in (0, 1):
            taps.append(np.minimum(above + dy, height - 1) * width + np.minimum(left + dx, width - 1))
            weights.append((1 - np.abs(y - above - dy)) * (1 - np.abs(x - left - dx)))
    return np.stack(taps).astype(np.int32), np.stack(weights).astype(np.float32)


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
    sums = graph("MatMul", graph("MatMul", rows, pixels), columns.T)
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
