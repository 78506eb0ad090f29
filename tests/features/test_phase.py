"""Phases: a turn of the robot multiplies them by what it should, and nothing else does."""

import cmath
import math

import cv2
import numpy as np
import pytest

from andante.errors import ConfigError
from andante.features import PhaseEncoder
from andante.features.illumination import Surroundings, patch_normalised, window_px
from andante.features.phase import alike_under_turns

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


def normal(picture: np.ndarray, phases: PhaseEncoder) -> np.ndarray:
    """(height, width) patch-normalised."""
    window = window_px((HEIGHT, WIDTH), phases.window_share)
    around = Surroundings.of(picture[None].astype(np.float32), window, wrap=True)
    return patch_normalised(around, phases.deviation_floor)[0]


def test_a_signature_is_the_transform_of_patch_normalised_bands(panoramas):
    """Term by term: coefficients 1, 2, .. of every band, real and imaginary part beside each other."""
    phases = encoder()
    for panorama in panoramas[[0, 7, 17]]:
        bands = phases.band_weights @ normal(panorama, phases)
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


ELEVATIONS = [None, (3.0, 50.0), (-20.0, 60.0), (0.0, 85.0)]


@pytest.mark.parametrize("height", [1, 3, 12, 24, 60])
@pytest.mark.parametrize("elevation_deg", ELEVATIONS)
def test_bands_lie_one_below_the_other_and_each_sums_to_one(height, elevation_deg):
    phases = PhaseEncoder(height, 60, elevation_deg)
    weights = phases.band_weights
    assert weights.shape == (min(12, height), height)
    assert (weights >= 0).all()
    np.testing.assert_allclose(weights.sum(axis=1), 1, rtol=1e-6)
    # Near the horizon several may share a row.
    assert (np.diff(weights @ np.arange(height)) > -1e-5).all()


def test_bands_of_unknown_elevation_are_as_high_as_each_other():
    weights = PhaseEncoder(24, 60, None, 6).band_weights
    np.testing.assert_allclose(weights @ np.arange(24), 1.5 + 4 * np.arange(6), atol=0.1)
    assert PhaseEncoder(24, 60).band_step is None


def test_what_comes_nearer_by_the_factor_of_a_band_moves_up_by_one():
    """Tangents of the elevations at which bands have their middles, by a camera of very many rows."""
    phases = PhaseEncoder(4000, 60, (3.0, 50.0))
    row = phases.band_weights @ np.arange(4000)
    tangent = np.tan(np.radians(50 - 47 * (row + 0.5) / 4000))
    np.testing.assert_allclose(np.log(tangent[:-1] / tangent[1:]), phases.band_step, rtol=5e-3)
    assert phases.band_step == pytest.approx(np.log(np.tan(np.radians(50)) / np.tan(np.radians(3))) / 12)


@pytest.mark.parametrize("width", [WIDTH, 60, 31, 120])
def test_pictures_are_what_signatures_stand_for(panoramas, width):
    """Bands with their detail gone, of any width; encoded again they give the signature."""
    phases = encoder()
    signatures = phases.encode(panoramas[SEEN])
    pictures = phases.pictures(signatures, width)
    assert pictures.shape == (18, 4, width)
    np.testing.assert_allclose(phases.encoded(pictures), signatures, atol=1e-5)
    if width == WIDTH:
        bands = phases.band_weights @ normal(panoramas[0], phases)
        spectrum = np.fft.rfft(bands, axis=1)
        spectrum[:, 0] = spectrum[:, 13:] = 0
        smooth = np.fft.irfft(spectrum, WIDTH, axis=1)
        np.testing.assert_allclose(
            pictures[0] / np.linalg.norm(pictures[0]), smooth / np.linalg.norm(smooth), atol=1e-5
        )


def test_columns_of_pictures_of_any_width_look_the_same_way():
    """One bright post: its middle is at the same azimuth, whatever the width."""
    azimuth = np.pi - 2 * np.pi * (np.arange(WIDTH) + 0.5) / WIDTH
    post = np.tile(np.exp(-(((azimuth - 0.6) / 0.3) ** 2)), (4, 1))
    phases = encoder()
    for width in (WIDTH, 60, 97, 120):
        picture = phases.pictures(phases.encoded(post[None].astype(np.float32)), width)[0, 0]
        looks = np.pi - 2 * np.pi * (np.arange(width) + 0.5) / width
        seen = np.clip(picture - 0.5 * picture.max(), 0, None)
        assert (seen * looks).sum() / seen.sum() == pytest.approx(0.6, abs=0.01)


def test_alike_under_turns_is_the_product_of_turned_signatures(panoramas):
    phases = encoder()
    seen, stored = phases.encode(panoramas[:6]), phases.encode(panoramas[6:12])
    curves = alike_under_turns(phases.spectra(seen), phases.spectra(stored), 64)
    for turn in range(0, 64, 7):
        turned = phases.turned(stored, np.full(6, 2 * np.pi * turn / 64))
        np.testing.assert_allclose(curves[:, turn], (seen * turned).sum(axis=1), atol=1e-5)


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
    ("shape", "bands", "frequencies"), [((24, 300), 12, 40), ((3, 300), 3, 40), ((6, 30), 6, 15), ((1, 7), 1, 3)]
)
def test_low_and_narrow_panoramas_have_fewer_numbers(shape, bands, frequencies):
    phases = PhaseEncoder(*shape)
    assert (phases.bands, phases.frequencies, phases.dim) == (bands, frequencies, 2 * bands * frequencies)
    picture = np.random.default_rng(3).integers(0, 256, shape, dtype=np.uint8)
    signature, rolled = phases.encode(picture), phases.encode(np.roll(picture, 2, axis=1))
    assert signature.shape == (phases.dim,)
    turned = phases.turned(signature[None], np.array([4 * np.pi / shape[1]]))
    np.testing.assert_allclose(turned[0], rolled, atol=1e-5)


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
