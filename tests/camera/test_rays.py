"""Pixels and rays are inverse to each other for every camera; directions follow the convention."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.camera import project, rays, rays_of_pixels, scaled
from andante.data import CameraSpec
from andante.errors import ConfigError

LENSES = [
    CameraSpec(projection="equidistant", field_of_view_deg=220.0, radius_px=40.0),
    CameraSpec(projection="equisolid", field_of_view_deg=300.0, radius_px=40.0),
    CameraSpec(projection="stereographic", field_of_view_deg=240.0, radius_px=40.0),
    CameraSpec(projection="kannala-brandt", field_of_view_deg=200.0, radius_px=40.0, coefficients=(0.02, -0.004)),
    CameraSpec(projection="ocam", field_of_view_deg=210.0, coefficients=(20.0, 0.0, -0.012)),
]

cameras = st.builds(
    replace,
    st.sampled_from(LENSES),
    centre_px=st.tuples(st.floats(20.0, 50.0), st.floats(20.0, 50.0)),
    forward_deg=st.floats(-360.0, 360.0),
    mirrored=st.booleans(),
    facing=st.sampled_from(["up", "down-mirror"]),
)


@given(spec=cameras)
@settings(max_examples=60)
def test_projecting_the_ray_of_a_pixel_gives_the_pixel(spec: CameraSpec) -> None:
    azimuth, elevation, valid = rays(spec, (64, 72))
    x_px, y_px = project(spec, azimuth, elevation)
    rows, columns = np.nonzero(valid)
    assert valid.any()
    np.testing.assert_allclose(x_px[valid], columns, atol=1e-6)
    np.testing.assert_allclose(y_px[valid], rows, atol=1e-6)
    assert (azimuth >= -np.pi).all()
    assert (azimuth < np.pi).all()


@given(spec=cameras, x=st.floats(0.0, 71.0), y=st.floats(0.0, 63.0))
@settings(max_examples=60)
def test_places_between_pixels_have_rays_of_their_own(spec: CameraSpec, x: float, y: float) -> None:
    azimuth, elevation, valid = rays_of_pixels(spec, x, y)
    if valid:
        np.testing.assert_allclose(project(spec, azimuth, elevation), (x, y), atol=1e-6)


@given(
    spec=cameras, scale=st.sampled_from([0.25, 0.5, 2.0]), azimuth=st.floats(-3.1, 3.1), elevation=st.floats(-0.2, 0.2)
)
def test_a_scaled_camera_sees_the_same_at_the_scaled_place(
    spec: CameraSpec, scale: float, azimuth: float, elevation: float
) -> None:
    full = np.array(project(spec, azimuth, elevation))
    small = np.array(project(scaled(spec, scale), azimuth, elevation))
    np.testing.assert_allclose(small, (full + 0.5) * scale - 0.5, atol=1e-6)


def test_directions_follow_the_convention() -> None:
    spec = CameraSpec(centre_px=(50.0, 50.0), radius_px=45.0)
    horizon = np.array([0.0, np.pi / 2, np.pi])
    x_px, y_px = project(spec, horizon, 0.0)  # forward is image right, left is image top
    np.testing.assert_allclose(x_px, [95.0, 50.0, 5.0], atol=1e-9)
    np.testing.assert_allclose(y_px, [50.0, 5.0, 50.0], atol=1e-9)
    x_px, y_px = project(replace(spec, forward_deg=90.0), horizon, 0.0)  # forward is image top, left is image left
    np.testing.assert_allclose(x_px, [50.0, 5.0, 50.0], atol=1e-9)
    np.testing.assert_allclose(y_px, [5.0, 50.0, 95.0], atol=1e-9)
    _, y_px = project(replace(spec, mirrored=True), np.pi / 2, 0.0)  # left is image bottom
    assert y_px == pytest.approx(95.0)


def test_the_optical_axis_is_zenith_or_nadir() -> None:
    spec = CameraSpec(centre_px=(50.0, 50.0), radius_px=45.0)
    assert np.array(project(spec, 1.0, np.pi / 2)) == pytest.approx([50.0, 50.0])
    down = replace(spec, facing="down-mirror")
    assert np.array(project(down, 1.0, -np.pi / 2)) == pytest.approx([50.0, 50.0])
    x_px, _ = project(replace(down, field_of_view_deg=270.0), 0.0, np.radians(45.0))
    assert x_px == pytest.approx(95.0)


def test_rays_outside_of_the_field_of_view_are_nowhere() -> None:
    spec = CameraSpec(centre_px=(50.0, 50.0), radius_px=45.0)
    x_px, y_px = project(spec, [0.0, 0.0], [-0.01, 0.01])
    assert np.isnan([x_px[0], y_px[0]]).all()
    assert np.isfinite([x_px[1], y_px[1]]).all()
    _, elevation, valid = rays(spec, (100, 100))
    assert not valid[0, 0]
    assert elevation[0, 0] == pytest.approx(0.0)


def test_a_hood_narrower_than_the_lens_hides_the_rest() -> None:
    spec = CameraSpec(centre_px=(50.0, 50.0), focal_px=30.0, radius_px=15.0)
    x_px, _ = project(spec, 0.0, np.pi / 2 - np.array([0.49, 0.51]))
    assert x_px[0] == pytest.approx(50.0 + 0.49 * 30.0)
    assert np.isnan(x_px[1])


def test_incomplete_cameras_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"no centre_px.*with_found_circle"):
        rays(CameraSpec(radius_px=45.0), (10, 10))
    with pytest.raises(ConfigError, match="two finite numbers"):
        rays(CameraSpec(radius_px=45.0, centre_px=(float("nan"), 1.0)), (10, 10))
    with pytest.raises(ConfigError, match=r"scale must be positive.*got 0"):
        scaled(CameraSpec(), 0.0)
