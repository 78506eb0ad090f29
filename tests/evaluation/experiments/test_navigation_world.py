import numpy as np
import pytest

from andante.errors import ConfigError
from andante.evaluation.experiments import Scale
from andante.evaluation.experiments.navigation_world import (
    CLEAR_M,
    MAPPED,
    Lawn,
    fixed_errands,
    navigation_plan,
    random_errands,
    v_wall,
)
from andante.simulator import GardenSpec, make_garden
from andante.simulator.trajectories import room_m

SCALE = Scale(frames=70, image_px=60)


@pytest.fixture(scope="module")
def lawns():
    return {
        obstacle: Lawn(make_garden(navigation_plan(5, SCALE, obstacle=obstacle).garden)) for obstacle in (False, True)
    }


def test_both_plans_are_one_garden_with_and_without_the_obstacle(lawns):
    np.testing.assert_array_equal(lawns[False].garden.border.points_m, lawns[True].garden.border.points_m)
    assert len(lawns[False].wall.rows) == 0
    assert len(lawns[True].wall.rows) == 2


def test_the_training_drive_keeps_clear_of_everything(lawns):
    plan = navigation_plan(5, SCALE)
    way = plan.session(MAPPED).truth(lawns[True].garden)
    assert room_m(lawns[True].garden, way.xy_m).min() > 0.25


def test_in_the_open_the_shortest_way_is_straight(lawns):
    lawn = lawns[False]
    goal = lawn.xy_m[len(lawn.xy_m) // 2]
    straight = np.linalg.norm(lawn.xy_m - goal, axis=1)
    ratio = lawn.travel_m(goal)[straight > 0.5] / straight[straight > 0.5]
    assert ratio.min() > 0.999
    assert ratio.max() < 1.06  # sixteen directions, and a border that bends


def test_around_the_obstacle_it_is_longer(lawns):
    errand = fixed_errands(lawns[True], 1, 5)[0]
    straight = np.hypot(errand.goal[0] - errand.start[0], errand.goal[1] - errand.start[1])
    assert lawns[True].divided(np.array(errand.start[:2]), np.array(errand.goal))
    assert errand.shortest_m > 1.1 * straight


@pytest.mark.parametrize("obstacle", [False, True])
def test_errands_have_room_and_are_the_same_again(lawns, obstacle):
    lawn = lawns[obstacle]
    errands = fixed_errands(lawn, 2, 5) + random_errands(lawn, 10, 5)
    assert len(errands) == 18
    assert errands == fixed_errands(lawn, 2, 5) + random_errands(lawn, 10, 5)
    points = [point for errand in errands for point in (errand.start[:2], errand.goal)]
    assert room_m(lawn.garden, points).min() >= CLEAR_M - 1e-9
    if obstacle:
        assert all(lawn.divided(np.array(e.start[:2]), np.array(e.goal)) for e in errands[8:])
    assert all(np.isfinite(errand.shortest_m) for errand in errands)


def test_repeats_start_with_other_headings(lawns):
    first, second = fixed_errands(lawns[False], 2, 5)[:2]
    assert first.start[:2] == second.start[:2]
    assert first.start[2] != second.start[2]


def test_the_wall_moves_as_told():
    garden = GardenSpec(seed=5, size_x_m=8.0, size_y_m=14.0)
    here, there = v_wall(garden), v_wall(garden, shift_m=(0.5, -0.8))
    np.testing.assert_allclose(np.array(there.points_m) - np.array(here.points_m), [[0.5, -0.8]] * 3)


def test_a_lawn_without_such_pairs_says_so(lawns, monkeypatch):
    monkeypatch.setattr("andante.evaluation.experiments.navigation_world._LEAST_M", 1e3)
    with pytest.raises(ConfigError, match=r"only 0 of 1 pairs of places found"):
        random_errands(lawns[False], 1, 5)
