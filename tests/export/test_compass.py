"""Phases and bearings in a graph are those of the encoder and the compass themselves."""

import cv2
import numpy as np
import pytest

from andante.export.compass import CompassInGraph
from andante.features import PhaseEncoder
from andante.mapping.codes import Codes
from andante.mapping.compass import Compass

SHAPES = [(14, 60), (12, 120), (6, 30), (3, 300), (1, 7), (5, 9)]


def panorama(shape: tuple[int, int], seed: int) -> np.ndarray:
    """Smooth and without a seam."""
    rough = np.random.default_rng(seed).normal(size=shape).astype(np.float32)
    smooth = cv2.GaussianBlur(np.tile(rough, 3), (0, 0), 1.5)[:, shape[1] : 2 * shape[1]]
    return np.clip(128 + 60 * smooth / smooth.std(), 0, 255).astype(np.uint8)


def compass_of(shape: tuple[int, int], places: int = 9) -> Compass:
    encoder = PhaseEncoder(*shape)
    signatures = encoder.encode(np.stack([panorama(shape, seed) for seed in range(places)]))
    xy = 500.0 + 0.7 * np.stack(np.divmod(np.arange(places), 3), axis=1)
    built = Compass.fit(encoder, Codes.of(signatures), xy, np.zeros(places), 0.5)
    assert built is not None
    return built


@pytest.mark.parametrize("shape", SHAPES)
def test_spectra(shape, run_piece):
    encoder, compass = PhaseEncoder(*shape), compass_of(shape)
    bands, k = encoder.bands, encoder.frequencies
    for image in (panorama(shape, 50), np.zeros(shape, np.uint8)):
        seen = run_piece(
            lambda graph, name: CompassInGraph.of(graph, graph.floats(name), compass).seen, image, (1, 2, 2 * bands, k)
        )
        plain, turned = seen.reshape(2, bands, 2, k).transpose(0, 1, 3, 2).copy().view(np.float32).reshape(2, -1)
        expected = encoder.encode(image)
        np.testing.assert_allclose(plain, expected, atol=3e-6)
        back = -1j * encoder.spectra(expected[None])[0]
        np.testing.assert_allclose(encoder.spectra(turned[None])[0], back, atol=3e-6)


@pytest.mark.parametrize("shape", SHAPES[:3])
@pytest.mark.parametrize("places", [1, 3, 9])
def test_bearings_anywhere(shape, places, run_piece):
    compass, rng = compass_of(shape, places), np.random.default_rng(2)
    for turn in (0, 1, shape[1] // 2, shape[1] - 1):
        image = np.roll(panorama(shape, turn % places), turn, axis=1)
        spots = [*compass.xy[:3], *(500 + rng.uniform(0, 1.4, (3, 2))), np.array([520.0, 480.0])]
        for spot in spots:
            heading, peak = (
                run_piece(
                    lambda graph, name, part=part, spot=spot: getattr(
                        CompassInGraph.of(graph, graph.floats(name), compass).bearings(graph("Identity", spot)), part
                    ),
                    image,
                    (1,),
                ).item()
                for part in ("heading", "peak")
            )
            expected = compass.bearings(compass.encoder.encode(image[None]), spot[None])
            # Single precision of 500 m.
            assert peak == pytest.approx(np.clip(expected.peak.item(), 0, 1), abs=1e-3)
            if abs(expected.peak.item() / expected.rival.item() - 1.1) < 1e-2:
                continue  # just clear, or just not
            assert np.isnan(heading) == np.isnan(expected.heading.item())
            if not np.isnan(heading):
                off = np.mod(heading - expected.heading.item() + np.pi, 2 * np.pi) - np.pi
                assert abs(off) < 2e-3


def test_a_panorama_that_repeats_itself_has_no_heading(run_piece):
    shape = (12, 120)
    trees = np.tile(panorama((12, 60), 3), 2)
    encoder = PhaseEncoder(*shape)
    compass = Compass.fit(encoder, Codes.of(encoder.encode(trees[None])), np.zeros((1, 2)), np.zeros(1), 0.5)
    heading = run_piece(
        lambda graph, name: (
            CompassInGraph.of(graph, graph.floats(name), compass).bearings(graph("Identity", np.zeros(2))).heading
        ),
        trees,
        (1,),
    )
    assert np.isnan(heading).all()


def test_persuasion(run_piece):
    shape = (12, 120)
    compass = compass_of(shape)
    references = np.concatenate([compass.xy[[4, 2, 7, 1]], 500 + np.random.default_rng(4).uniform(0, 1.4, (6, 2))])
    nearest = np.array([9, 3, 0, 5, 1])
    for seed in range(4):
        image = np.roll(panorama(shape, seed), 31, axis=1)
        found = run_piece(
            lambda graph, name: CompassInGraph.of(graph, graph.floats(name), compass).persuasion(
                graph("Identity", nearest), references, 5
            ),
            image,
            (5,),
        )
        expected = compass.persuasion(compass.encoder.encode(image[None]), references[None, nearest])[0]
        np.testing.assert_allclose(np.exp(found - found.max()), expected, rtol=1e-4)
