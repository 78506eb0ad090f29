"""Encoders in a graph give the features of the encoders themselves."""

import cv2
import numpy as np
import pytest

from andante.errors import ConfigError
from andante.export.encoders import add_encoder
from andante.export.graph import Graph
from andante.features import FourierEncoder, NetworkEncoder, PixelEncoder
from andante.sfa import HierarchicalSFA, Layer

SHAPE = (14, 60)
ENCODERS = {
    "fourier": FourierEncoder(*SHAPE, n_frequencies=20),
    "four directions": FourierEncoder(*SHAPE, n_frequencies=31, orientations=4, window_share=(0.3, 1.0)),
    "thesis": FourierEncoder(*SHAPE, n_frequencies=15, normalise=False, orientations=0, unit=False),
    "no seam": FourierEncoder(*SHAPE, n_frequencies=20, wrap=False),
    "flat": PixelEncoder(*SHAPE, wrap=False),
    "grey": PixelEncoder(*SHAPE, normalise=False),
}


def panorama(seed: int) -> np.ndarray:
    return cv2.GaussianBlur(np.random.default_rng(seed).integers(0, 256, SHAPE).astype(np.uint8), (5, 5), 0)


def encoded(run_piece, encoder, image: np.ndarray) -> np.ndarray:
    return run_piece(lambda graph, name: add_encoder(graph, graph.floats(name), encoder), image, (encoder.dim,))


@pytest.mark.parametrize("name", ENCODERS)
def test_features(name, run_piece):
    encoder = ENCODERS[name]
    for seed in range(3):
        image = panorama(seed)
        expected = encoder.encode(image)
        # Single precision: a variance is a difference of two numbers 100 times larger, of which five digits remain.
        np.testing.assert_allclose(encoded(run_piece, encoder, image), expected, atol=2e-5 * np.abs(expected).max())


def test_a_black_panorama_has_no_length(run_piece):
    black = np.zeros(SHAPE, np.uint8)
    np.testing.assert_allclose(encoded(run_piece, ENCODERS["fourier"], black), 0, atol=1e-6)


@pytest.mark.parametrize("unit", [False, True])
@pytest.mark.parametrize("floor", [None, 20.0])
def test_network(floor, unit, run_piece):
    pictures = np.stack([panorama(seed) for seed in range(80)])
    layers = [Layer(4, (6, 6), (3, 2), 6), Layer(3, reduced_dim=8, clip=None)]
    model = HierarchicalSFA(layers, wrap=True, deviation_floor=floor).fit(pictures).model_
    for network in (model, model.first(1)):
        encoder = NetworkEncoder(network, unit)
        expected = encoder.encode(pictures[0])
        np.testing.assert_allclose(encoded(run_piece, encoder, pictures[0]), expected, atol=3e-4)


def test_another_encoder_is_refused():
    class Mean:
        dim = 1

        def encode(self, panoramas):
            return panoramas.mean(keepdims=True)

    with pytest.raises(ConfigError, match="encoder Mean cannot be exported; FourierEncoder, PixelEncoder and Net"):
        add_encoder(Graph(), "panorama", Mean())
