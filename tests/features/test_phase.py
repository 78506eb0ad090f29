"""Phases: a turn of the robot multiplies them by what it should, and nothing else does."""

import cmath
import math

import cv2
import numpy as np
import pytest

from andante.errors import ConfigError
from andante.features import PhaseEncoder
from andante.features.illumination import Surroundings, patch_normalised, window_px

HEIGHT, WIDTH = 8, 48
SEEN = slice(0, 18)
"""The last two panoramas show nothing at all."""


def encoder(**options) -> PhaseEncoder:
    return PhaseEncoder(HEIGHT, WIDTH, **{"most_bands": 4, "n_frequencies": 12, **options})


@pytest.mark.parametrize("frequencies", [12, WIDTH // 2])
@pytest.mark.parametrize("columns", [1, 5, WIDTH // 2, WIDTH - 1, -3])
def test_a_turn_is_an_exact_factor(panoramas, columns, frequencies):
    """To the left by ``columns``: everything moves to the right, and the k-th coefficient turns by k times as much."""
    phases, seen = encoder(n_frequencies=frequencies), panoramas[SEEN]
    turn = np.full(len(seen), 2 * np.pi * columns / WIDTH)
    rolled = phases.encode(np.roll(seen, columns, axis=2))
    np.testing.assert_allclose(phases.turned(phases.encode(seen), turn), rolled, atol=1e-6)


def test_turning_by_any_angle_adds_up_and_back(panoramas):
    phases = encoder()
    signatures = phases.encode(panoramas[SEEN])
    one, other = np.random.default_rng(0).uniform(-4, 4, (2, len(signatures)))
    twice = phases.turned(phases.turned(signatures, one), other)
    np.testing.assert_allclose(twice, phases.turned(signatures, one + other), atol=1e-6)
    np.testing.assert_allclose(phases.turned(twice, -one - other), signatures, atol=1e-6)
    np.testing.assert_allclose(phases.turned(signatures, np.full(len(signatures), 2 * np.pi)), signatures, atol=1e-5)
    np.testing.assert_allclose(np.linalg.norm(twice, axis=1), 1, rtol=1e-5)


def test_a_signature_is_the_transform_of_patch_normalised_bands(panoramas):
    """Term by term: means over two rows each, coefficients 1, 2, .., real and imaginary part beside each other."""
    phases = encoder()
    window = window_px((HEIGHT, WIDTH), phases.window_share)
    for panorama in panoramas[[0, 7, 17]]:
        around = Surroundings.of(panorama[None].astype(np.float32), window, wrap=True)
        bands = patch_normalised(around, phases.deviation_floor)[0].reshape(4, 2, WIDTH).mean(axis=1)
        expected = [
            sum(x * cmath.exp(-2j * math.pi * k * t / WIDTH) for t, x in enumerate(band))
            for band in bands.tolist()
            for k in range(1, 13)
        ]
        flat = np.array([part for one in expected for part in (one.real, one.imag)])
        found = phases.encode(panorama)
        np.testing.assert_allclose(found, flat / np.linalg.norm(flat), atol=1e-5)
        spectra = phases.spectra(found[None])
        assert spectra.shape == (1, 4, 12)
        np.testing.assert_allclose(spectra.ravel(), np.array(expected) / np.linalg.norm(flat), atol=1e-5)


def test_signatures_have_length_one_or_are_zero(panoramas):
    lengths = np.linalg.norm(encoder().encode(panoramas), axis=1)
    np.testing.assert_allclose(lengths[SEEN], 1, rtol=1e-5)
    np.testing.assert_array_equal(lengths[-1], 0)


@pytest.mark.parametrize("size", [1, 3, 7, 19])
def test_cutting_a_stack_into_pieces_changes_nothing(panoramas, size):
    phases = encoder()
    pieces = [phases.encode(panoramas[start : start + size]) for start in range(0, len(panoramas), size)]
    np.testing.assert_array_equal(np.concatenate(pieces), phases.encode(panoramas))


def test_a_panorama_alone_gives_its_row_in_a_stack_exactly(panoramas):
    phases = encoder()
    stacked = phases.encode(panoramas)
    assert (stacked.dtype, stacked.shape) == (np.float32, (len(panoramas), phases.dim))
    for panorama, row in zip(panoramas, stacked, strict=True):
        alone = phases.encode(panorama)
        assert alone.shape == (phases.dim,)
        np.testing.assert_array_equal(alone, row)


@pytest.mark.parametrize(
    ("shape", "bands", "frequencies"), [((24, 300), 6, 40), ((3, 300), 3, 40), ((6, 30), 6, 15), ((1, 7), 1, 3)]
)
def test_low_and_narrow_panoramas_have_fewer_numbers(shape, bands, frequencies):
    phases = PhaseEncoder(*shape)
    assert (phases.bands, phases.frequencies, phases.dim) == (bands, frequencies, 2 * bands * frequencies)
    picture = np.random.default_rng(3).integers(0, 256, shape, dtype=np.uint8)
    signature, rolled = phases.encode(picture), phases.encode(np.roll(picture, 2, axis=1))
    assert signature.shape == (phases.dim,)
    turned = phases.turned(signature[None], np.array([4 * np.pi / shape[1]]))
    np.testing.assert_allclose(turned[0], rolled, atol=1e-5)


@pytest.mark.parametrize("rows", [3, 5, 6])
def test_bands_that_do_not_divide_the_height_share_its_rows_by_area(panoramas, rows):
    phases = encoder(most_bands=rows)
    around = Surroundings.of(panoramas[:1].astype(np.float32), window_px((HEIGHT, WIDTH), (0.043, 0.2)), wrap=True)
    normal = patch_normalised(around, 20.0)[0]
    # Every row cut into as many slices as there are bands: then the bands are whole numbers of slices.
    bands = np.repeat(normal, rows, axis=0).reshape(rows, HEIGHT, WIDTH).mean(axis=1)
    spectra = np.fft.rfft(bands, axis=1)[:, 1:13].ravel()
    found = phases.spectra(phases.encode(panoramas[0])[None]).ravel()
    np.testing.assert_allclose(found, spectra / np.linalg.norm(spectra), atol=1e-5)


def test_another_light_changes_a_signature_less_than_another_place(panoramas):
    phases = encoder()
    pictures = panoramas[:10]
    darker = (pictures * 0.7 + 60).astype(np.uint8)
    blurred = np.stack([cv2.GaussianBlur(one, (3, 3), 0.5) for one in pictures])
    signatures = phases.encode(pictures)
    elsewhere = 1 - signatures @ signatures.T + 9 * np.eye(10)
    for changed in (darker, blurred):
        assert (1 - (signatures * phases.encode(changed)).sum(axis=1)).max() < 0.5 * elsewhere.min()


@pytest.mark.parametrize("wrong", [np.zeros((8, 47), np.uint8), np.zeros((8, 48)), np.zeros((0, 8, 48), np.uint8)])
def test_other_panoramas_are_refused(wrong):
    with pytest.raises(ConfigError, match=r"this encoder takes grey uint8 panoramas \(8, 48\)"):
        encoder().encode(wrong)
