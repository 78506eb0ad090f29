"""Patch normalisation and orientations against loops over windows."""

import numpy as np
import pytest

from andante.features import Surroundings, orientation_channels, patch_normalised
from andante.features.illumination import window_px

WINDOW = (5, 3)
FLOOR = 20.0


def normalised_by_loops(picture: np.ndarray, *, wrap: bool) -> np.ndarray:
    """(value - mean of its window) / sqrt(variance of its window + floor²), pixel by pixel, mirrored at the rim."""
    height, width = picture.shape
    padded = np.pad(picture.astype(np.float64), ((3, 3), (0, 0)), mode="symmetric")
    padded = np.pad(padded, ((0, 0), (3, 3)), mode="wrap" if wrap else "symmetric")
    out = np.empty((height, width))
    for y in range(height):
        for x in range(width):
            window = padded[y + 3 - 1 : y + 3 + 2, x + 3 - 2 : x + 3 + 3]
            out[y, x] = (picture[y, x] - window.mean()) / np.sqrt(window.var() + FLOOR**2)
    return out


@pytest.mark.parametrize("wrap", [True, False])
def test_patch_normalisation_is_mean_and_deviation_of_the_window(panoramas, wrap):
    stack = panoramas[[0, 3, -3]].astype(np.float32)
    fast = patch_normalised(Surroundings.of(stack, WINDOW, wrap=wrap), FLOOR)
    slow = np.stack([normalised_by_loops(picture, wrap=wrap) for picture in stack])
    np.testing.assert_allclose(fast, slow, atol=1e-4)


def gradients_by_loops(picture: np.ndarray, floor: float) -> np.ndarray:
    """(2, height, width) |central difference| along x and y over the local root mean square of both plus a floor."""
    height, width = picture.shape
    padded = np.pad(picture.astype(np.float64), ((3, 3), (0, 0)), mode="symmetric")
    padded = np.pad(padded, ((0, 0), (4, 4)), mode="wrap")
    along = np.zeros((2, *padded.shape))
    along[0, :, 1:-1] = (padded[:, 2:] - padded[:, :-2]) / 2
    along[1, 1:-1] = (padded[2:] - padded[:-2]) / 2
    energy = (along**2).sum(axis=0)
    out = np.empty((2, height, width))
    for y in range(height):
        for x in range(width):
            strength = np.sqrt(energy[y + 2 : y + 5, x + 2 : x + 7].mean()) + floor
            out[:, y, x] = np.abs(along[:, y + 3, x + 4]) / strength
    return out


def test_orientations_are_normalised_gradients(panoramas):
    stack = panoramas[[0, 3]].astype(np.float32)
    fast = orientation_channels(Surroundings.of(stack, WINDOW, wrap=True), 2, 5.0)
    slow = np.stack([gradients_by_loops(picture, 5.0) for picture in stack])
    np.testing.assert_allclose(fast, slow, atol=1e-4)


def test_an_edge_counts_the_same_from_dark_to_light_and_back():
    dark_to_light = np.repeat(np.repeat([[50.0, 200.0]], 24, axis=1), 8, axis=0).astype(np.float32)[None]
    around, inverted = (Surroundings.of(picture, WINDOW, wrap=True) for picture in (dark_to_light, 250 - dark_to_light))
    channels = orientation_channels(around, 4, 5.0)
    np.testing.assert_allclose(channels, orientation_channels(inverted, 4, 5.0), atol=1e-6)
    assert channels[0, 0].max() > 1
    np.testing.assert_allclose(channels[0, 2], 0, atol=1e-6)  # nothing changes along the columns


@pytest.mark.parametrize(
    ("shape", "share", "expected"),
    [((24, 300), (0.043, 0.2), (13, 5)), ((60, 600), (0.043, 0.2), (25, 13)), ((8, 8), (0.01, 0.01), (3, 3))],
)
def test_windows_are_odd_and_at_least_three_pixels(shape, share, expected):
    assert window_px(shape, share) == expected


def test_a_window_as_large_as_the_picture_is_possible(panoramas):
    stack = panoramas[:2].astype(np.float32)
    window = window_px(stack.shape[1:], (1.0, 1.0))
    whole = patch_normalised(Surroundings.of(stack, window, wrap=True), FLOOR)
    assert whole.shape == stack.shape
    assert np.isfinite(whole).all()
