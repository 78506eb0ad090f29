import numpy as np
import pytest

from andante.camera import rays
from andante.errors import ConfigError
from andante.simulator import SimulatedCamera
from andante.simulator.camera import pixel_rays


@pytest.mark.parametrize("projection", ["equidistant", "equisolid", "stereographic"])
def test_fisheye_rays_are_those_of_the_camera_room(projection):
    camera = SimulatedCamera(width_px=32, height_px=24, projection=projection, forward_deg=30, mirrored=True)
    azimuth, elevation, valid = rays(camera.spec, (24, 32))
    made = pixel_rays(camera)
    np.testing.assert_allclose(
        np.arctan2(made.directions[..., 1], made.directions[..., 0])[valid], azimuth[valid], atol=1e-5
    )
    np.testing.assert_allclose(np.arcsin(made.directions[..., 2])[valid], elevation[valid], atol=1e-4)
    np.testing.assert_array_equal(made.valid, valid)


@pytest.mark.parametrize("model", ["fisheye", "panorama", "perspective"])
def test_the_four_parts_of_a_pixel_lie_around_its_centre(model):
    camera = SimulatedCamera(model=model, width_px=48, height_px=48)
    whole, parts = pixel_rays(camera), pixel_rays(camera, 2).directions
    mean = parts.reshape(48, 2, 48, 2, 3).mean(axis=(1, 3))
    inner = whole.valid.copy()
    inner[:2] = inner[-2:] = inner[:, :2] = inner[:, -2:] = False
    inner[22:26, 22:26] = False  # azimuth turns over at the zenith
    mean /= np.linalg.norm(mean, axis=-1, keepdims=True)
    assert np.degrees(np.arccos(np.clip((mean * whole.directions).sum(-1), -1, 1)))[inner].max() < 1.0


def test_the_middle_of_panorama_and_pinhole_looks_forward_and_left_is_left():
    for model in ("panorama", "perspective"):
        directions = pixel_rays(
            SimulatedCamera(model=model, width_px=40, height_px=20, min_deg=-10, max_deg=10)
        ).directions
        np.testing.assert_allclose(directions[9:11, 19:21].mean(axis=(0, 1)), (1, 0, 0), atol=0.02)
        assert directions[10, 10, 1] > 0.3
        assert directions[0, 20, 2] > directions[-1, 20, 2]


def test_the_pinhole_is_as_wide_as_it_says():
    directions = pixel_rays(SimulatedCamera(model="perspective", width_px=400, height_px=300)).directions
    edges = directions[150, [0, -1]]
    assert np.degrees(np.arccos(edges[0] @ edges[1] / np.prod(np.linalg.norm(edges, axis=1)))) == pytest.approx(
        90, abs=0.5
    )


def test_impossible_cameras_are_refused():
    with pytest.raises(ConfigError, match="min_deg 10 must be below max_deg 5"):
        SimulatedCamera(model="panorama", min_deg=10, max_deg=5)
    with pytest.raises(ConfigError, match="mirrored and forward_deg are for a fisheye only"):
        SimulatedCamera(model="panorama", mirrored=True)
