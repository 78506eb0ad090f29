import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.camera import PanoramaGeometry
from andante.landmarks.boxes import Box
from andante.landmarks.windows import clipped, elevations_rad, visible_share, window

GEOMETRY = PanoramaGeometry(360, 60, -30.0, 30.0)
PANORAMA = np.tile(np.arange(360) % 256, (60, 1)).astype(np.uint8)


def test_a_window_around_forward_is_the_middle():
    np.testing.assert_array_equal(window(PANORAMA, 0.0, np.radians(40)), PANORAMA[:, 160:200])


def test_left_is_left():
    np.testing.assert_array_equal(window(PANORAMA, np.radians(90), np.radians(20)), PANORAMA[:, 80:100])


@given(st.integers(-720, 720), st.integers(1, 180))
def test_windows_wrap(degrees, width):
    part = window(PANORAMA, np.radians(degrees), np.radians(2 * width))
    assert part.shape == (60, 2 * width)
    rolled = np.roll(PANORAMA, degrees, axis=1)  # turning left moves everything to the right
    np.testing.assert_array_equal(part, window(rolled, 0.0, np.radians(2 * width)))


def test_colour_and_width():
    colour = np.dstack([PANORAMA] * 3)
    assert window(colour, 3.0, 100.0).shape == (60, 360, 3)
    assert window(colour, 3.0, 0.0).shape == (60, 1, 3)


def test_clipping():
    low, high = elevations_rad(GEOMETRY)
    assert (low, high) == pytest.approx((-np.pi / 6, np.pi / 6))
    inside = Box(1.0, 0.1, 0.2, 0.2)
    assert clipped(inside, GEOMETRY).iou(inside) == pytest.approx(1.0)
    beyond = Box(1.0, high, 0.2, 0.2)
    assert clipped(beyond, GEOMETRY).high_rad == pytest.approx(high)
    assert visible_share(beyond, GEOMETRY) == pytest.approx(0.5)
    assert clipped(Box(1.0, 1.0, 0.2, 0.2), GEOMETRY) is None
    assert visible_share(Box(1.0, 1.0, 0.2, 0.2), GEOMETRY) == 0.0
