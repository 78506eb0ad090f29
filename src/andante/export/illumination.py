"""Local means, deviations and orientations in a graph, as ``andante.features.illumination`` works them out."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.export.graph import Graph
from andante.features import window_px


@dataclass(frozen=True)
class Around:
    """A panorama with its margins ``tall``, the ``rim`` taken off again where windows fit: (1, 1, height, width)."""

    graph: Graph
    tall: str
    shape: tuple[int, int]
    window: tuple[int, int]

    @classmethod
    def of(
        cls, graph: Graph, panorama: str, shape: tuple[int, int], window_share: tuple[float, float], *, wrap: bool
    ) -> Around:
        """Of a panorama (height, width); see ``Surroundings.of``."""
        window = window_px(shape, window_share)
        rows = _with_margin(shape[0], window[1], wrap=False)
        columns = _with_margin(shape[1], window[0], wrap=wrap)
        tall = graph("Gather", graph("Gather", panorama, rows, axis=0), columns, axis=1)
        return cls(graph, graph.shaped(tall, 1, 1, len(rows), len(columns)), shape, window)

    def inner(self, dx: int = 0, dy: int = 0) -> str:
        """``tall`` without its outermost pixels, seen from ``dx`` and ``dy`` pixels further on."""
        width, height = (size + 2 * (window // 2) for size, window in zip(self.shape[::-1], self.window, strict=True))
        return self.graph.part(self.graph.part(self.tall, 1 + dy, 1 + dy + height, 2), 1 + dx, 1 + dx + width, 3)

    def mean(self, inner: str) -> str:
        """Mean over the window around every pixel; in two steps, for windows of hundreds of pixels."""
        width, height = self.window
        along = self.graph("AveragePool", inner, kernel_shape=[1, width], strides=[1, 1])
        return self.graph("AveragePool", along, kernel_shape=[height, 1], strides=[1, 1])

    def cropped(self, inner: str) -> str:
        """Without the windows' margin: (1, 1, height, width)."""
        (mx, my), (height, width) = (size // 2 for size in self.window), self.shape
        return self.graph.part(self.graph.part(inner, my, my + height, 2), mx, mx + width, 3)


def add_patch_normalised(around: Around, deviation_floor: float) -> str:
    """(1, 1, height, width); see ``patch_normalised``."""
    graph, grey = around.graph, around.inner()
    mean = around.mean(grey)
    variance = graph("Max", graph("Sub", around.mean(graph.square(grey)), graph.square(mean)), 0.0)
    deviation = graph("Sqrt", graph("Add", variance, deviation_floor**2))
    return graph("Div", graph("Sub", around.cropped(grey), mean), deviation)


def add_orientation_channels(around: Around, count: int, gradient_floor: float) -> str:
    """(1, count, height, width); see ``orientation_channels``."""
    graph = around.graph
    along_x = graph("Mul", graph("Sub", around.inner(dx=1), around.inner(dx=-1)), 0.5)
    along_y = graph("Mul", graph("Sub", around.inner(dy=1), around.inner(dy=-1)), 0.5)
    energy = around.mean(graph("Add", graph.square(along_x), graph.square(along_y)))
    scale = graph("Add", graph("Sqrt", energy), gradient_floor)
    both = graph("Div", graph("Concat", around.cropped(along_x), around.cropped(along_y), axis=1), scale)
    angles = np.pi * np.arange(count) / count
    directions = np.stack([np.cos(angles), np.sin(angles)], axis=1)[:, :, None, None]
    return graph("Abs", graph("Conv", both, directions, kernel_shape=[1, 1]))


def _with_margin(size: int, window: int, *, wrap: bool) -> NDArray[np.int32]:
    """Which of ``size`` pixels stand in a row with its margins: around the circle, or mirrored."""
    margin = window // 2 + 1
    reach = np.arange(-margin, size + margin)
    folded = np.mod(reach, 2 * size)
    columns = np.mod(reach, size) if wrap else np.minimum(folded, 2 * size - 1 - folded)
    return np.asarray(columns, np.int32)
