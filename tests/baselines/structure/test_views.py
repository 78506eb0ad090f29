import numpy as np
import pytest

from andante.baselines.structure.views import FisheyeView, PinholeView, colmap_camera
from andante.camera import rays_of_pixels
from andante.data import CameraSpec
from andante.errors import ConfigError

pytestmark = pytest.mark.usefixtures("colmap")

PLACED = {"centre_px": (118.0, 121.0), "radius_px": 110.0}
SPECS = [
    CameraSpec(**PLACED),
    CameraSpec(**PLACED, forward_deg=70.0, mirrored=True),
    CameraSpec(**PLACED, projection="equisolid", field_of_view_deg=220.0),
    CameraSpec(**PLACED, projection="stereographic", forward_deg=-40.0),
    CameraSpec(**PLACED, projection="kannala-brandt", coefficients=(-0.02, 0.001), field_of_view_deg=190.0),
    CameraSpec(**PLACED, facing="down-mirror", forward_deg=20.0),
    CameraSpec(**PLACED, facing="down-mirror", mirrored=True),
]


def directions(spec: CameraSpec, xy: np.ndarray) -> np.ndarray:
    """Unit vectors (k, 3) in the frame of the robot."""
    azimuth, elevation, _ = rays_of_pixels(spec, xy[:, 0], xy[:, 1])
    return np.column_stack(
        [np.cos(elevation) * np.cos(azimuth), np.cos(elevation) * np.sin(azimuth), np.sin(elevation)]
    )


@pytest.mark.parametrize("spec", SPECS)
def test_colmap_sees_key_points_along_the_rays_of_the_lens(spec: CameraSpec) -> None:
    view = FisheyeView.of(spec, 88.0)
    xy = np.random.default_rng(0).uniform(0, 240, (500, 2))
    moved, kept = view.points(xy)
    seen = colmap_camera(view).cam_ray_from_img(moved[kept]) @ view.robot_from_camera.T
    assert kept.sum() > 200
    np.testing.assert_allclose(seen, directions(spec, xy[kept]), atol=1e-9)


@pytest.mark.parametrize("spec", SPECS)
def test_a_pinhole_view_shows_the_rays_of_the_lens(spec: CameraSpec) -> None:
    view = PinholeView.of(spec, 90.0)
    rows, columns = np.random.default_rng(0).integers(0, view.size[0], (2, 300))
    colmap_xy, kept = view.points(np.column_stack([columns, rows]).astype(float))
    seen = colmap_camera(view).cam_ray_from_img(colmap_xy) @ view.robot_from_camera.T
    there = np.column_stack([view.map_x[rows, columns], view.map_y[rows, columns]]).astype(float)
    assert kept.all()
    np.testing.assert_allclose(seen, directions(spec, there), atol=1e-5)


@pytest.mark.parametrize("spec", SPECS)
def test_the_axes_of_a_camera_are_those_of_a_solid_body(spec: CameraSpec) -> None:
    axes = FisheyeView.of(spec, 80.0).robot_from_camera
    np.testing.assert_allclose(axes @ axes.T, np.eye(3))
    assert np.linalg.det(axes) == pytest.approx(1.0)


def test_a_pinhole_view_is_as_wide_as_asked() -> None:
    view = PinholeView.of(SPECS[0], 90.0)
    corner = colmap_camera(view).cam_ray_from_img(np.array([view.size[0], view.size[1] / 2]))
    assert np.degrees(np.arctan2(corner[0], corner[2])) == pytest.approx(45.0)
    assert view.picture(np.full((240, 240), 7, np.uint8)).shape == view.size[::-1]


def test_nothing_beyond_the_limit_or_outside_of_the_lens_is_kept() -> None:
    view = FisheyeView.of(SPECS[0], 60.0)
    xy = np.random.default_rng(1).uniform(0, 240, (500, 2))
    _, kept = view.points(xy)
    assert np.hypot(*(xy[kept] - PLACED["centre_px"]).T).max() < 110.0 * 60 / 90


@pytest.mark.parametrize("limit_deg", [0.0, 90.0])
def test_limits_that_colmap_has_no_lens_for_are_refused(limit_deg: float) -> None:
    with pytest.raises(ConfigError, match=r"limit_deg must be above 0 and at most 89\.5, got"):
        FisheyeView.of(SPECS[0], limit_deg)


def test_cameras_and_fields_of_view_without_a_lens_are_refused() -> None:
    with pytest.raises(ConfigError, match=r"only a camera of model 'fisheye'"):
        FisheyeView.of(CameraSpec(model="panorama"), 80.0)
    with pytest.raises(ConfigError, match=r"field_of_view_deg must be above 0 and at most 170, got 175"):
        PinholeView.of(SPECS[0], 175.0)
