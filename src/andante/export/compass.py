"""Phases and headings in a graph; see ``PhaseEncoder`` and ``Compass``.

Spectra have their bands and their real and imaginary parts one below the other: (2 bands, K). What an image and a place
have in common at frequency k is Z = sum_b seen_b conj(stored_b): its real part is the product of two such columns, its
imaginary part that of a column with the image's own, multiplied by -i.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.export.graph import Graph
from andante.export.illumination import Around, add_patch_normalised
from andante.features import PhaseEncoder
from andante.mapping.codes import LARGEST_CODE
from andante.mapping.compass import BLENDED, CLEAR, ELSEWHERE_RAD, PERSUASION, SAMPLES, Compass


@dataclass(frozen=True)
class BearingNames:
    """Heading (1,), NaN where two are about as likely, and ``peak`` (1,) in 0..1, how alike image and place are."""

    heading: str
    peak: str


@dataclass(frozen=True)
class CompassInGraph:
    """A compass and the spectrum that an image has: ``seen`` (1, 2, 2 bands, K), as it is and times -i."""

    graph: Graph
    compass: Compass
    seen: str

    @classmethod
    def of(cls, graph: Graph, panorama: str, compass: Compass) -> CompassInGraph:
        """For a panorama (height, width) float32."""
        return cls(graph, compass, _add_spectrum(graph, panorama, compass.encoder))

    def persuasion(self, nearest: str, xy: FloatArray, count: int) -> str:
        """Logarithm (count,), up to a constant, of how much the image speaks for ``nearest`` of references ``xy``."""
        graph = self.graph
        place = self.compass.nearest(xy, 1)[1][:, 0].astype(np.int32)
        curves = self._alike(self._rows(graph("Gather", place, nearest, axis=0)), count)
        return graph("Mul", graph("ReduceMax", curves, axes=[1], keepdims=0), PERSUASION)

    def bearings(self, xy: str) -> BearingNames:
        """What the compass says at a position (2,)."""
        graph, around = self.graph, min(BLENDED, len(self.compass.codes))
        # Around their middle positions are small numbers, of which single precision keeps more digits.
        middle = self.compass.xy.mean(axis=0)
        offset = graph("Sub", self.compass.xy - middle, graph("Sub", xy, middle))
        squared, place = graph.top(graph.total(graph.square(offset), 1), around)
        further = graph("Sub", squared, graph.part(squared, 0, 1))
        weight = graph("Exp", graph("Mul", further, -2 / self.compass.cell_m**2))
        rows = graph("Mul", self._rows(place), graph.shaped(weight, around, 1, 1))
        blend = graph.total(rows, 0, keep=True)
        length = graph("Sqrt", graph.total(graph.square(blend), 0, 1, 2))
        blend = graph("Div", blend, graph("Max", length, np.finfo(np.float32).tiny))
        return self._read_off(graph.shaped(self._alike(blend, 1), SAMPLES))

    def _read_off(self, curve: str) -> BearingNames:
        """From how alike image and place are (SAMPLES,) under all headings."""
        graph = self.graph
        at = graph("ArgMax", curve, axis=0, keepdims=1)
        # Turned so that its peak comes first, between its neighbours.
        turned = graph("Gather", curve, graph("Mod", graph("Add", np.arange(SAMPLES), at), np.array([SAMPLES])), axis=0)
        peak, right, left = (graph.part(turned, one, one + 1) for one in (0, 1, SAMPLES - 1))
        apart = int(ELSEWHERE_RAD / (2 * np.pi) * SAMPLES) + 1
        rival = graph("ReduceMax", graph.part(turned, apart, SAMPLES - apart + 1), axes=[0], keepdims=1)
        bend = graph("Sub", graph("Add", left, right), graph("Mul", peak, 2.0))
        between = graph("Div", graph("Mul", graph("Sub", left, right), 0.5), graph("Min", bend, -1e-12))
        turn = graph("Mul", graph("Add", graph.floats(at), between), 2 * np.pi / SAMPLES)
        heading = graph("Where", graph("Less", turn, np.pi), turn, graph("Sub", turn, 2 * np.pi))
        clear = graph("Greater", peak, graph("Mul", rival, CLEAR))
        return BearingNames(graph("Where", clear, heading, np.nan), graph("Clip", peak, 0.0, 1.0))

    def _rows(self, places: str) -> str:
        """Places (c,) -> (c, 2 bands, K) from one byte a number: the signed square of a code, times its row's scale."""
        graph, codes, encoder = self.graph, self.compass.codes, self.compass.encoder
        interleaved = codes.codes.reshape(-1, encoder.bands, encoder.frequencies, 2)
        apart = interleaved.transpose(0, 1, 3, 2).reshape(-1, 2 * encoder.bands, encoder.frequencies)
        steps = graph.floats(graph("Gather", apart, places, axis=0))
        scale = codes.scale[:, None, None] / np.float32(LARGEST_CODE**2)
        return graph("Mul", graph("Mul", steps, graph("Abs", steps)), graph("Gather", scale, places, axis=0))

    def _alike(self, rows: str, count: int) -> str:
        """Stored spectra (count, 2 bands, K) -> how alike the image is to each under all headings (count, SAMPLES)."""
        graph, k = self.graph, self.compass.encoder.frequencies
        products = graph("Mul", graph.shaped(rows, count, 1, 2 * self.compass.encoder.bands, k), self.seen)
        return graph("MatMul", graph.shaped(graph.total(products, 2), count, 2 * k), _turns(k))


def _add_spectrum(graph: Graph, panorama: str, encoder: PhaseEncoder) -> str:
    """Panorama (height, width) -> (1, 2, 2 bands, K): its spectrum of length one, and the same times -i."""
    shape, k = (encoder.height_px, encoder.width_px), encoder.frequencies
    around = Around.of(graph, panorama, shape, encoder.window_share, wrap=True)
    normal = graph.shaped(add_patch_normalised(around, encoder.deviation_floor), *shape)
    parts = graph("MatMul", graph("MatMul", encoder.band_weights, normal), _waves(encoder.width_px, k))
    # Both have the same length.
    length = graph("Sqrt", graph("Mul", graph.total(graph.square(parts), 0, 1), 0.5))
    unit = graph("Div", parts, graph("Where", graph("Greater", length, 0.0), length, 1.0))
    both = graph("Transpose", graph.shaped(unit, encoder.bands, 2, 2, k), perm=[1, 0, 2, 3])
    return graph.shaped(both, 1, 2, 2 * encoder.bands, k)


def _waves(width: int, count: int) -> NDArray[np.float32]:
    """(width, 4 count): a row times this is its spectrum from frequency 1 on, real and imaginary, and that times -i."""
    angles = 2 * np.pi * (np.outer(np.arange(width), np.arange(1, count + 1)) % width) / width
    real, imaginary = np.cos(angles), -np.sin(angles)
    return np.concatenate([real, imaginary, imaginary, -real], axis=1).astype(np.float32)


def _turns(count: int) -> NDArray[np.float32]:
    """(2 count, SAMPLES): real and imaginary parts times this are the real part of a sum of turning phases."""
    angles = 2 * np.pi * (np.outer(np.arange(1, count + 1), np.arange(SAMPLES)) % SAMPLES) / SAMPLES
    return np.concatenate([np.cos(angles), -np.sin(angles)]).astype(np.float32)
