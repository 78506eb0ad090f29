import numpy as np
import pytest

from andante.data import CameraSpec
from andante.errors import ConfigError
from andante.landmarks.surroundings import Surroundings, surrounding_geometry
from andante.recordings import MemoryRecording


def recording(camera, shape):
    rng = np.random.default_rng(0)
    return MemoryRecording([rng.integers(0, 255, (*shape, 3), np.uint8) for _ in range(2)], [0.0, 1.0], camera)


def test_a_fisheye_is_unwrapped_from_where_it_begins_to_see():
    camera = CameraSpec(centre_px=(99.5, 99.5), radius_px=100.0, field_of_view_deg=200.0)
    around = Surroundings(recording(camera, (200, 200)))
    assert (around.geometry.min_deg, around.geometry.max_deg) == (-10.0, 55.0)
    assert around(1).shape == (around.geometry.height_px, around.geometry.width_px, 3)
    assert around.geometry.height_px / 65 == pytest.approx(around.geometry.width_px / 360, rel=0.01)


def test_a_panorama_has_square_pixels_and_the_horizon_in_the_middle():
    around = Surroundings(recording(CameraSpec(model="panorama"), (60, 360)))
    assert (around.geometry.min_deg, around.geometry.max_deg) == (-30.0, 30.0)
    assert around(0).shape == (60, 360, 3)


def test_cameras_that_do_not_see_all_around_the_horizon_are_refused():
    with pytest.raises(ConfigError, match=r"anchors stand near the horizon; this camera sees elevations of 60 degrees"):
        surrounding_geometry(CameraSpec(field_of_view_deg=60.0), (100, 100))
    mirror = CameraSpec(field_of_view_deg=60.0, facing="down-mirror")
    with pytest.raises(ConfigError, match=r"elevations up to -60 degrees only"):
        surrounding_geometry(mirror, (100, 100))
    with pytest.raises(ConfigError, match=r"looked for all around the horizon"):
        Surroundings(recording(CameraSpec(model="perspective"), (60, 90)))
