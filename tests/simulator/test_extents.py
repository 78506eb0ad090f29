"""What is seen of an object in angles: the same in every camera, across the seam, without what hides it."""

import numpy as np
import pytest

from andante.errors import ConfigError
from andante.simulator import (
    ExtentFinder,
    GardenSpec,
    GivenPoses,
    Placed,
    Plan,
    Session,
    SimulatedCamera,
    SimulatedRecording,
    object_extent,
)
from andante.simulator.camera import pixel_rays

FISHEYE = SimulatedCamera(width_px=300, height_px=300, field_of_view_deg=200.0)
PANORAMA = SimulatedCamera(model="panorama", width_px=720, height_px=120, min_deg=-10.0, max_deg=50.0)


def ids_of_box(camera, azimuth, elevation, width, height):
    """Object 3 wherever a ray is inside of a box, object 0 elsewhere."""
    directions = pixel_rays(camera).directions
    turn = np.angle(np.exp(1j * (np.arctan2(directions[..., 1], directions[..., 0]) - azimuth)))
    rise = np.arcsin(directions[..., 2]) - elevation
    inside = (np.abs(turn) < width / 2) & (np.abs(rise) < height / 2)
    return np.where(inside & pixel_rays(camera).valid, 3, 0).astype(np.int32)


@pytest.mark.parametrize("camera", [FISHEYE, PANORAMA])
@pytest.mark.parametrize("azimuth", [0.0, 1.3, np.pi, -3.0])
def test_a_box_is_found_again_also_across_the_seam(camera, azimuth):
    ids = ids_of_box(camera, azimuth, 0.2, 0.5, 0.3)
    extent = ExtentFinder(camera)(ids, 3)
    assert extent is not None
    assert abs(np.angle(np.exp(1j * (extent.azimuth_rad - azimuth)))) < 0.02
    assert extent.box[1:] == pytest.approx((0.2, 0.5, 0.3), abs=0.03)
    assert extent.pixels == (ids == 3).sum()


def test_of_what_is_hardly_seen_there_is_none():
    ids = np.zeros((120, 720), np.int32)
    ids[3, 3] = 5
    assert ExtentFinder(PANORAMA)(ids, 5) is None
    assert ExtentFinder(PANORAMA)(ids, 5, min_pixels=1) is not None


@pytest.fixture(scope="module")
def placed(embree):
    """A trolley two metres ahead of one pose and behind another."""
    session = Session(
        name="s",
        drive=GivenPoses(poses=((-2.0, 0.0, 0.0), (-2.0, 0.0, 3.0))),
        placed=(Placed(kind="trolley", x_m=0.0, y_m=0.0, heading_rad=np.pi / 2),),
    )
    plan = Plan(garden=GardenSpec(seed=3, size_x_m=10, size_y_m=10), camera=PANORAMA, sessions=(session,))
    return SimulatedRecording(plan, "s")


def test_what_is_put_down_is_seen_where_it_stands(placed):
    ahead, behind = (object_extent(placed, index, "trolley1") for index in (0, 1))
    assert abs(ahead.azimuth_rad) < 0.03
    assert behind.azimuth_rad == pytest.approx(-3.0, abs=0.03)
    assert ahead.width_rad == pytest.approx(2 * np.arctan(0.24 / 1.86), abs=0.06)
    top = ahead.elevation_rad + ahead.height_rad / 2
    assert top == pytest.approx(np.arctan(0.59 / 2.0), abs=0.04)  # 1.09 m high, seen from 0.5 m


def test_an_unknown_object_is_an_error(placed):
    with pytest.raises(ConfigError, match=r"there is no object 'trolley2' in 's'; it has trolley1$"):
        object_extent(placed, 0, "trolley2")
