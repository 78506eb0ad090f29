import numpy as np
import pytest

from andante.camera import PanoramaGeometry
from andante.data import CameraSpec
from andante.errors import ConfigError
from andante.landmarks.panoramas import PanoramaMaker

GEOMETRY = PanoramaGeometry(64, 16, 5.0, 60.0)


@pytest.mark.parametrize("shape", [(120, 120), (120, 120, 3)])
def test_a_fisheye_becomes_a_panorama_of_that_size(garden, shape):
    image = np.broadcast_to(garden.fisheye((0, 0, 0)).reshape(120, 120, *([1] * (len(shape) - 2))), shape)
    panorama = PanoramaMaker(garden.fisheye_camera, shape, GEOMETRY)(np.ascontiguousarray(image))
    assert panorama.shape == (16, 64, 3)
    assert (panorama[..., 0] == panorama[..., 2]).all()


@pytest.mark.parametrize("shape", [(8, 32), (90, 400), (16, 64), (40, 32)])
def test_a_panorama_of_any_size_becomes_one_of_that_size(shape):
    image = np.random.default_rng(0).integers(0, 255, (*shape, 3)).astype(np.uint8)
    assert PanoramaMaker(CameraSpec(model="panorama"), shape, GEOMETRY)(image).shape == (16, 64, 3)


@pytest.mark.parametrize(
    "camera", [CameraSpec(model="perspective"), CameraSpec(model="panorama", horizontal_field_of_view_deg=180.0)]
)
def test_a_camera_that_does_not_see_all_around_is_refused(camera):
    with pytest.raises(ConfigError, match=f"a {camera.model} camera( of 180 degrees)? does not see it"):
        PanoramaMaker(camera, (48, 64), GEOMETRY)
