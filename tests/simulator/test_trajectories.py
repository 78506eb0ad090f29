import numpy as np
import pytest

from andante.errors import ConfigError
from andante.simulator import BorderRun, GardenSpec, GivenPoses, GridRun, InfieldRun, make_garden
from andante.simulator.trajectories import room_m


def rng(seed=0):
    return np.random.default_rng(seed)


def test_a_border_run_keeps_its_distance_from_the_border_and_its_speed(garden):
    drive = BorderRun(inset_m=0.4, wobble_m=0.02)
    truth = drive.drive(garden, rng())
    np.testing.assert_allclose(garden.border.inside_m(truth.xy_m), 0.4, atol=0.15)
    steps = np.linalg.norm(np.diff(truth.xy_m, axis=0), axis=1)
    assert np.median(steps) == pytest.approx(0.134, rel=0.05)
    np.testing.assert_allclose(np.diff(truth.timestamp_s), 0.2)


def test_a_border_run_closes_and_looks_where_it_goes(garden):
    truth = BorderRun(wobble_m=0.0).drive(garden, rng())
    assert np.linalg.norm(truth.xy_m[-1] - truth.xy_m[0]) < 0.2
    way = np.diff(truth.xy_m, axis=0)
    ahead = np.stack([np.cos(truth.heading_rad), np.sin(truth.heading_rad)], 1)[:-1]
    assert ((way * ahead).sum(1) / np.linalg.norm(way, axis=1)).min() > 0.97


def test_laps_direction_and_wobble(garden):
    once, twice = (BorderRun(laps=laps).drive(garden, rng()) for laps in (1, 2))
    assert len(twice) == pytest.approx(2 * len(once), abs=2)
    again = BorderRun().drive(garden, rng(1))
    apart = np.linalg.norm(again.xy_m - once.xy_m, axis=1)
    assert 0.005 < apart.mean() < 0.06  # never twice exactly the same
    back = BorderRun(clockwise=True, wobble_m=0).drive(garden, rng())
    turned = np.unwrap(back.heading_rad)
    assert turned[-1] - turned[0] < -5.0


@pytest.mark.parametrize("spec", [GardenSpec(seed=2), GardenSpec(seed=3, v_obstacle=True)])
def test_an_infield_run_stays_clear_goes_straight_and_turns_on_the_spot(spec):
    garden = make_garden(spec)
    truth = InfieldRun(frames=600).drive(garden, rng())
    assert len(truth) == 600
    assert room_m(garden, truth.xy_m).min() >= 0.3
    steps = np.linalg.norm(np.diff(truth.xy_m, axis=0), axis=1)
    turns = np.abs(np.mod(np.diff(truth.heading_rad) + np.pi, 2 * np.pi) - np.pi)
    assert turns[steps > 0.01].max() < 0.06
    assert (steps > 0.1).mean() > 0.4
    low, high = garden.border.points_m.min(0), garden.border.points_m.max(0)
    cells = np.unique(((truth.xy_m - low) / (high - low) * 3).astype(int), axis=0)
    assert len(cells) >= 6  # it gets about


def test_a_grid_is_regular_and_free():
    garden = make_garden(GardenSpec(seed=3, v_obstacle=True))
    truth = GridRun(spacing_m=1.0, clearance_m=0.3).drive(garden, rng())
    assert room_m(garden, truth.xy_m).min() >= 0.3
    offsets = np.mod(truth.xy_m - truth.xy_m[0], 1.0)
    assert np.minimum(offsets, 1.0 - offsets).max() < 1e-9
    assert len(np.unique(truth.xy_m, axis=0)) == len(truth)
    assert set(GridRun(spacing_m=1.0, headings="along").drive(garden, rng()).heading_rad) <= {0.0, -np.pi}


def test_given_poses_are_driven_as_they_are(garden):
    truth = GivenPoses(poses=((1, 2, 0.5), (3, 4, 7.0))).drive(garden, rng())
    np.testing.assert_array_equal(truth.xy_m, [(1, 2), (3, 4)])
    np.testing.assert_allclose(truth.heading_rad, (0.5, 7.0 - 2 * np.pi))


def test_the_same_seed_drives_the_same_way(garden):
    for drive in (BorderRun(), InfieldRun(frames=50), GridRun(headings="random")):
        first, second = drive.drive(garden, rng(4)), drive.drive(garden, rng(4))
        np.testing.assert_array_equal(first.xy_m, second.xy_m)
        np.testing.assert_array_equal(first.heading_rad, second.heading_rad)


def test_no_room_is_an_error(garden):
    with pytest.raises(ConfigError, match="no place in this garden is 5 m clear of all things"):
        InfieldRun(clearance_m=5).drive(make_garden(GardenSpec(seed=3, size_x_m=9, size_y_m=9)), rng())
    with pytest.raises(ConfigError, match="a grid of 20 m finds no free place"):
        GridRun(spacing_m=20, clearance_m=5).drive(garden, rng())
