"""Views of landmarks: centred on them, the same however the robot is turned."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.camera import PanoramaGeometry, Unwrapper, rays
from andante.data import CameraSpec
from andante.errors import ConfigError, ImageError
from andante.landmarks.boxes import Box
from andante.landmarks.views import THESIS_PX, ViewCutter, ViewWindow, largest_window

PX = 200
CAMERA = CameraSpec(centre_px=(99.5, 99.5), radius_px=98.0)
WINDOW = ViewWindow(np.radians(60), 0.05, np.radians(40), 48, 24)
AZIMUTH, ELEVATION, INSIDE = rays(CAMERA, (PX, PX))


def scene(heading: float) -> np.ndarray:
    """A smooth picture of the world from a robot with this heading."""
    turn = AZIMUTH + heading
    grey = 120 + 60 * np.sin(3 * turn) * np.cos(2 * ELEVATION) + 40 * np.cos(turn + 4 * ELEVATION)
    return np.where(INSIDE, np.clip(grey, 0, 255), 0).astype(np.uint8)


@settings(max_examples=30, deadline=None)
@given(st.floats(-np.pi, np.pi), st.floats(-np.pi, np.pi))
def test_a_view_does_not_change_when_the_robot_turns(direction, heading):
    cut = ViewCutter(CAMERA, (PX, PX))
    box = Box(direction, 0.2, 0.2, 0.3)
    turned = Box(float(np.angle(np.exp(1j * (direction - heading)))), 0.2, 0.2, 0.3)
    before, after = cut(scene(0.0), box, WINDOW), cut(scene(heading), turned, WINDOW)
    assert np.abs(before.astype(int) - after).max() <= 6
    assert np.abs(before.astype(int) - after).mean() <= 1.5


def test_a_view_is_a_part_of_the_panorama():
    """Slow reference: the panorama is unwrapped, and the columns around the box are taken out of it."""
    geometry = PanoramaGeometry(288, 24, np.degrees(WINDOW.low_rad), 40.0)
    panorama = Unwrapper(CAMERA, (PX, PX), geometry)(scene(0.3))
    azimuth = float(geometry.azimuths_rad()[100] - np.pi / 288)  # between two columns, as the middle of 48 is
    view = ViewCutter(CAMERA, (PX, PX))(scene(0.3), Box(azimuth, 0.1, 0.1, 0.1), WINDOW)
    assert np.abs(view.astype(int) - panorama[:, 77:125]).max() <= 4


def test_rays_fall_from_left_to_right_and_from_top_to_bottom_around_the_box():
    azimuth, elevation = WINDOW.rays(Box(3.0, 0.5, 0.1, 0.1))
    assert azimuth.shape == (1, 48)
    assert elevation.shape == (24, 1)
    assert azimuth.mean() == pytest.approx(3.0)
    assert (np.diff(azimuth[0]) < 0).all()
    assert (np.diff(elevation[:, 0]) < 0).all()
    assert WINDOW.low_rad < elevation.min() < elevation.max() < WINDOW.high_rad


def test_a_window_on_the_horizon_does_not_care_for_the_height_of_a_box():
    cut, image = ViewCutter(CAMERA, (PX, PX)), scene(0.0)
    views = [cut(image, Box(1.0, *rest), WINDOW) for rest in ((0.1, 0.2, 0.3), (0.6, 0.9, 0.1))]
    np.testing.assert_array_equal(*views)


def test_the_thesis_takes_the_largest_box_around_the_middle_of_each():
    boxes = [Box(0.0, 0.4, 0.2, 0.5), Box(1.0, 0.3, 0.6, 0.1)]
    window = largest_window(boxes)
    assert (window.width_rad, window.high_rad - window.low_rad) == (0.6, 0.5)
    assert window.shape == (THESIS_PX, THESIS_PX)
    _, elevation = window.rays(boxes[0])
    assert elevation.mean() == pytest.approx(0.4)
    with pytest.raises(ConfigError, match=r"there is no box to take the largest size of"):
        largest_window([])


def test_what_the_camera_does_not_see_repeats_its_rim():
    low = ViewWindow(0.5, -0.6, 0.0, 16, 16)
    view = ViewCutter(CAMERA, (PX, PX))(scene(0.0), Box(0.0, 0.0, 0.1, 0.1), low)
    assert (view == view[:1]).all()
    assert view.min() > 0


def test_colour_and_other_sizes_of_the_same_picture_give_the_same_view():
    box, image = Box(0.7, 0.2, 0.1, 0.1), scene(0.0)
    grey = ViewCutter(CAMERA, (PX, PX))(image, box, WINDOW)
    colour = ViewCutter(CAMERA, (PX, PX))(np.repeat(image[:, :, None], 3, axis=2), box, WINDOW)
    np.testing.assert_allclose(colour, grey, atol=1)
    half = cv2.resize(image, (PX // 2, PX // 2), interpolation=cv2.INTER_AREA)
    small = ViewCutter(CAMERA, (PX // 2, PX // 2), scale=0.5)(half, box, WINDOW)
    assert np.abs(small[:-2].astype(int) - grey[:-2]).mean() < 3


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ((0.0, 0.0, 0.5, 48, 24), r"a window needs a width_rad above 0 and up to 2 pi"),
        ((7.0, 0.0, 0.5, 48, 24), r"a window needs a width_rad above 0 and up to 2 pi"),
        ((1.0, 0.5, 0.5, 48, 24), r"low_rad below high_rad"),
        ((1.0, 0.0, 0.5, 48, 2), r"a view needs at least 4 x 4 px, got 48 x 2"),
    ],
)
def test_windows_that_hold_nothing_are_refused(values, message):
    with pytest.raises(ConfigError, match=message):
        ViewWindow(*values)


def test_cameras_and_images_that_do_not_fit_are_refused():
    with pytest.raises(ConfigError, match=r"cut out of fisheye images, this camera is a panorama"):
        ViewCutter(CameraSpec(model="panorama"), (PX, PX))
    with pytest.raises(ConfigError, match=r"the camera declares neither radius_px nor focal_px"):
        ViewCutter(CameraSpec(), (PX, PX))
    with pytest.raises(ImageError, match=r"this camera takes \(200, 200\)"):
        ViewCutter(CAMERA, (PX, PX))(np.zeros((10, 10), np.uint8), Box(0, 0, 1, 1), WINDOW)
