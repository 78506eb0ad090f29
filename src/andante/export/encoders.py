"""Panoramas to features in a graph, one function for each encoder."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from andante.errors import ConfigError
from andante.export.graph import Graph
from andante.export.illumination import Around, add_orientation_channels, add_patch_normalised
from andante.export.network import add_network
from andante.features import FourierEncoder, NetworkEncoder, PixelEncoder
from andante.protocols import Encoder


def add_encoder(graph: Graph, panorama: str, encoder: Encoder) -> str:
    """Panorama (height, width) float32 -> features (d,); raises ``ConfigError`` for an encoder of another house."""
    if isinstance(encoder, FourierEncoder):
        return _fourier(graph, panorama, encoder)
    if isinstance(encoder, PixelEncoder):
        return _pixels(graph, panorama, encoder)
    if isinstance(encoder, NetworkEncoder):
        outputs = add_network(graph, panorama, encoder.model)
        return _unit_length(graph, outputs) if encoder.unit else outputs
    raise ConfigError(
        f"a map with the encoder {type(encoder).__name__} cannot be exported; FourierEncoder, PixelEncoder and "
        "NetworkEncoder can: build the map with the features of one of them"
    )


def _fourier(graph: Graph, panorama: str, encoder: FourierEncoder) -> str:
    shape = encoder.height_px, encoder.width_px
    around = Around.of(graph, panorama, shape, encoder.window_share, wrap=encoder.wrap)
    waves = _waves(encoder.width_px, encoder.n_frequencies)
    base = add_patch_normalised(around, encoder.deviation_floor) if encoder.normalise else panorama
    features = _magnitudes(graph, base, waves, encoder.height_px, unit=encoder.unit)
    if encoder.orientations:
        channels = add_orientation_channels(around, encoder.orientations, encoder.gradient_floor)
        edges = _magnitudes(graph, channels, waves, encoder.orientations * encoder.height_px, unit=encoder.unit)
        features = graph("Concat", features, graph("Mul", edges, encoder.orientation_weight), axis=0)
        features = _unit_length(graph, features) if encoder.unit else features
    return features


def _pixels(graph: Graph, panorama: str, encoder: PixelEncoder) -> str:
    if not encoder.normalise:
        return graph.shaped(panorama, -1)
    shape = encoder.height_px, encoder.width_px
    around = Around.of(graph, panorama, shape, encoder.window_share, wrap=encoder.wrap)
    return _unit_length(graph, graph.shaped(add_patch_normalised(around, encoder.deviation_floor), -1))


def _magnitudes(graph: Graph, pictures: str, waves: NDArray[np.float32], rows: int, *, unit: bool) -> str:
    """Magnitudes of the lowest frequencies of every row, by one product with cosines and sines side by side."""
    parts = graph("MatMul", graph.shaped(pictures, rows, len(waves)), waves)
    power = graph.total(graph.square(graph.shaped(parts, rows, 2, waves.shape[1] // 2)), 1)
    flat = graph.shaped(graph("Sqrt", power), -1)
    return _unit_length(graph, flat) if unit else flat


def _waves(width: int, n_frequencies: int) -> NDArray[np.float32]:
    """(width, 2 n_frequencies): what a Fourier transform multiplies a row with."""
    # The product modulo the width is exact, and so is the angle.
    steps = np.outer(np.arange(width), np.arange(n_frequencies)) % width
    angles = 2 * np.pi * steps / width
    return np.concatenate([np.cos(angles), np.sin(angles)], axis=1).astype(np.float32)


def _unit_length(graph: Graph, row: str) -> str:
    """At Euclidean length one; a row of zeros stays as it is."""
    length = graph("ReduceL2", row, axes=[0], keepdims=1)
    return graph("Div", row, graph("Where", graph("Greater", length, 0.0), length, 1.0))
