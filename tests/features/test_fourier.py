"""Fourier features: the same whichever way the robot looks, and what the thesis says they are."""

import cmath
import math

import numpy as np
import pytest

from andante.errors import ConfigError
from andante.features import FourierEncoder, fourier_magnitudes

HEIGHT, WIDTH = 8, 48
THESIS = {"normalise": False, "orientations": 0, "unit": False}


def encoder(**options) -> FourierEncoder:
    return FourierEncoder(HEIGHT, WIDTH, **{"n_frequencies": 12, **options})


def magnitudes_by_definition(row: list[float], n_frequencies: int) -> list[float]:
    """|sum_t x_t exp(-2 pi i k t / T)| for k = 0, 1, .., term by term."""
    length = len(row)
    return [
        abs(sum(x * cmath.exp(-2j * math.pi * k * t / length) for t, x in enumerate(row))) for k in range(n_frequencies)
    ]


@pytest.mark.parametrize("options", [{}, {"orientations": 0}, {"orientations": 3}, {"normalise": False}, THESIS])
@pytest.mark.parametrize("shift", [1, 5, WIDTH // 2, WIDTH - 1])
def test_a_turn_of_the_robot_changes_nothing(panoramas, options, shift):
    features = encoder(**options)
    turned = features.encode(np.roll(panoramas, shift, axis=2))
    scale = np.abs(features.encode(panoramas)).max()
    np.testing.assert_allclose(turned, features.encode(panoramas), atol=1e-5 * scale)


def test_without_wrapping_around_a_turn_changes_the_features(panoramas):
    features = encoder(wrap=False)
    turned = features.encode(np.roll(panoramas, 5, axis=2))
    assert np.abs(turned - features.encode(panoramas)).max() > 1e-3


@pytest.mark.parametrize("options", [{}, {"orientations": 0}, THESIS])
def test_a_panorama_alone_gives_its_row_in_a_stack_exactly(panoramas, options):
    features = encoder(**options)
    stacked = features.encode(panoramas)
    assert stacked.shape == (len(panoramas), features.dim)
    for panorama, row in zip(panoramas, stacked, strict=True):
        alone = features.encode(panorama)
        assert alone.shape == (features.dim,)
        np.testing.assert_array_equal(alone, row)


@pytest.mark.parametrize("size", [1, 3, 7, 19])
def test_cutting_a_stack_into_pieces_changes_nothing(panoramas, size):
    features = encoder()
    pieces = [features.encode(panoramas[start : start + size]) for start in range(0, len(panoramas), size)]
    np.testing.assert_array_equal(np.concatenate(pieces), features.encode(panoramas))


def test_the_thesis_feature_is_the_magnitude_of_the_transform_of_grey_rows(panoramas):
    features = encoder(n_frequencies=15, **THESIS)
    assert features.dim == HEIGHT * 15
    for panorama in panoramas[[0, 5, -2]]:
        expected = [magnitudes_by_definition(row.tolist(), 15) for row in panorama]
        np.testing.assert_allclose(features.encode(panorama), np.ravel(expected), rtol=1e-4, atol=1e-2)


def test_magnitudes_keep_the_constant_and_the_leading_axes():
    rows = np.full((2, 3, 10), 4.0, dtype=np.float32)
    magnitudes = fourier_magnitudes(rows, 4)
    assert magnitudes.shape == (2, 3, 4)
    np.testing.assert_allclose(magnitudes[..., 0], 40)
    np.testing.assert_allclose(magnitudes[..., 1:], 0, atol=1e-5)


def test_features_have_unit_length_or_are_zero(panoramas):
    for options in ({}, {"orientations": 0}):
        length = np.linalg.norm(encoder(**options).encode(panoramas), axis=1)
        np.testing.assert_allclose(length[:-2], 1, rtol=1e-5)
        np.testing.assert_allclose(length[-2:], 0, atol=1e-6)  # flat and black pictures have no edges


def test_orientations_weigh_as_much_as_configured(panoramas):
    features = encoder(orientation_weight=2.0).encode(panoramas[0])
    grey = HEIGHT * 12
    assert np.linalg.norm(features[grey:]) == pytest.approx(2 * np.linalg.norm(features[:grey]), rel=1e-5)


def test_brightness_and_contrast_hardly_change_normalised_features(panoramas):
    features = encoder()
    pictures = panoramas[:10].astype(np.float64)
    brighter = (pictures * 0.7 + 60).astype(np.uint8)
    other = 1 - (features.encode(panoramas[:10]) * features.encode(panoramas[[1, *range(9)]])).sum(axis=1)
    same = 1 - (features.encode(panoramas[:10]) * features.encode(brighter)).sum(axis=1)
    assert same.max() < 0.1 * other.min()


def test_heading_is_all_that_is_lost(panoramas):
    vectors = encoder().encode(panoramas[:10])
    assert np.linalg.norm(vectors[:, None] - vectors[None], axis=2)[~np.eye(10, dtype=bool)].min() > 0.1


@pytest.mark.parametrize("count", [0, WIDTH // 2 + 2])
def test_more_frequencies_than_the_width_has_are_refused(count):
    with pytest.raises(ConfigError, match=rf"n_frequencies must be in 1\.\.25 for panoramas 48 px wide, got {count}"):
        encoder(n_frequencies=count)
