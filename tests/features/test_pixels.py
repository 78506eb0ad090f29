"""Pixels as features: they keep the heading."""

import numpy as np
import pytest

from andante.errors import ConfigError
from andante.features import FourierEncoder, PixelEncoder

HEIGHT, WIDTH = 8, 48


def test_plain_pixels_are_the_grey_levels_row_by_row(panoramas):
    encoder = PixelEncoder(HEIGHT, WIDTH, normalise=False)
    assert encoder.dim == HEIGHT * WIDTH
    np.testing.assert_array_equal(encoder.encode(panoramas), panoramas.reshape(len(panoramas), -1))


@pytest.mark.parametrize("normalise", [True, False])
def test_a_panorama_alone_gives_its_row_in_a_stack_exactly(panoramas, normalise):
    encoder = PixelEncoder(HEIGHT, WIDTH, normalise=normalise)
    stacked = encoder.encode(panoramas)
    for panorama, row in zip(panoramas, stacked, strict=True):
        np.testing.assert_array_equal(encoder.encode(panorama), row)


def test_normalised_pixels_have_unit_length(panoramas):
    vectors = PixelEncoder(HEIGHT, WIDTH).encode(panoramas)
    np.testing.assert_allclose(np.linalg.norm(vectors, axis=1)[:-2], 1, rtol=1e-5)


def test_a_turn_shifts_the_pixels(panoramas):
    encoder = PixelEncoder(HEIGHT, WIDTH)
    straight = encoder.encode(panoramas[:5]).reshape(5, HEIGHT, WIDTH)
    turned = encoder.encode(np.roll(panoramas[:5], 7, axis=2)).reshape(5, HEIGHT, WIDTH)
    np.testing.assert_allclose(turned, np.roll(straight, 7, axis=2), atol=1e-6)
    assert np.abs(turned - straight).max() > 0.01


def test_a_perspective_picture_is_not_continued_on_its_other_side(panoramas):
    around, ahead = (PixelEncoder(HEIGHT, WIDTH, wrap=wrap).encode(panoramas[0]) for wrap in (True, False))
    rows_around, rows_ahead = around.reshape(HEIGHT, WIDTH), ahead.reshape(HEIGHT, WIDTH)
    assert np.abs(rows_around[:, 0] - rows_ahead[:, 0]).max() > 1e-3


@pytest.mark.parametrize("encoder", [FourierEncoder(HEIGHT, WIDTH, 12), PixelEncoder(HEIGHT, WIDTH)])
@pytest.mark.parametrize(
    "wrong",
    [
        np.zeros((HEIGHT, WIDTH + 1), np.uint8),
        np.zeros((WIDTH,), np.uint8),
        np.zeros((HEIGHT, WIDTH, 3), np.uint8),
        np.zeros((2, 2, HEIGHT, WIDTH), np.uint8),
        np.zeros((0, HEIGHT, WIDTH), np.uint8),
        np.full((HEIGHT, WIDTH), np.nan),
    ],
)
def test_anything_but_grey_panoramas_of_the_right_size_is_refused(encoder, wrong):
    with pytest.raises(ConfigError, match=r"takes grey uint8 panoramas \(8, 48\), one or a stack of them, got \w+ of"):
        encoder.encode(wrong)
