import hashlib
import subprocess
import sys

import numpy as np
import pytest

from andante.errors import ConfigError
from andante.simulator import GardenSpec, Scene, Wall, make_garden
from andante.simulator.layout import _Planner
from andante.simulator.obstacles import Obstacles
from andante.simulator.trajectories import room_m

FINGERPRINT = """
import hashlib
from andante.simulator import GardenSpec, Scene, make_garden
garden = make_garden(GardenSpec(seed=3, size_x_m=10, size_y_m=10))
print(hashlib.sha256(Scene.of(garden.things).mesh.corners.tobytes()).hexdigest())
"""


def footprints(garden):
    return garden.obstacles.rows


def test_another_process_lays_out_the_same_garden(scene):
    here = hashlib.sha256(scene.mesh.corners.tobytes()).hexdigest()
    there = subprocess.run([sys.executable, "-c", FINGERPRINT], capture_output=True, text=True, check=True)
    assert there.stdout.strip() == here


def test_another_seed_is_another_layout_not_only_other_details(garden):
    other = make_garden(GardenSpec(seed=4))
    assert [thing.kind for thing in garden.things] != [thing.kind for thing in other.things]
    houses = [[f for t in g.things if t.kind == "house" for f in t.footprints] for g in (garden, other)]
    assert {(f.x_m, f.y_m) for f in houses[0]}.isdisjoint((f.x_m, f.y_m) for f in houses[1])
    assert np.abs(garden.border.inside_m(other.border.points_m)).max() > 0.2


@pytest.mark.parametrize("seed", range(4))
@pytest.mark.parametrize("size", [(15.0, 15.0), (30.0, 18.0)])
def test_the_border_is_clear_and_the_camera_never_starts_inside_of_something(seed, size):
    garden = make_garden(GardenSpec(seed=seed, size_x_m=size[0], size_y_m=size[1]))
    assert garden.obstacles.clearance_m(garden.border.inset(0.1).points_m).min() > 0.15
    assert garden.border.length_m > 2.0 * sum(size) * 0.5


def test_a_large_garden_has_landmarks_on_its_lawn_and_a_small_one_has_not():
    def inner(garden):
        rows = footprints(garden)
        return int((garden.border.inside_m(rows[:, :2]) > 2.0).sum())

    assert inner(make_garden(GardenSpec(seed=1))) == 0
    assert inner(make_garden(GardenSpec(seed=1, size_x_m=57, size_y_m=44))) >= 8


def test_the_v_obstacle_stands_in_the_lawn():
    garden = make_garden(GardenSpec(seed=3, v_obstacle=True))
    assert [thing.kind for thing in garden.things].count("obstacle") == 1
    arms = next(thing for thing in garden.things if thing.kind == "obstacle").footprints
    assert len(arms) == 2
    assert room_m(garden, [(arm.x_m, arm.y_m) for arm in arms]).max() < 0.0


def test_walls_stand_where_they_are_told_and_change_nothing_else():
    corner = Wall(points_m=((-1.0, 1.0), (0.0, 0.0), (1.0, 1.0)), height_m=0.8, thickness_m=0.1)
    plain, walled = (make_garden(GardenSpec(seed=3, walls=walls)) for walls in ((), (corner,)))
    assert [thing.kind for thing in walled.things] == [*(thing.kind for thing in plain.things), "wall"]
    for one, other in zip(plain.things, walled.things, strict=False):
        np.testing.assert_array_equal(one.mesh.corners, other.mesh.corners)
    wall = walled.things[-1]
    clear = Obstacles.of(wall.footprints).clearance_m([(-0.5, 0.5), (0.0, 0.0), (1.0, 1.0), (0.0, 1.0)])
    assert clear[:3].max() < 0.01
    assert clear[3] == pytest.approx(np.sqrt(0.5) - 0.05)
    assert wall.mesh.corners[..., 2].max() == pytest.approx(0.8)


def test_a_garden_without_walls_is_told_as_ever():
    assert "walls" not in GardenSpec(seed=3).model_dump()
    spec = GardenSpec(walls=(Wall(points_m=((0.0, 0.0), (1.0, 0.0))),))
    assert GardenSpec.checked(spec.model_dump(), "here") == spec
    with pytest.raises(ConfigError, match=r"points_m = .* is not allowed"):
        Wall(points_m=((0.0, 0.0),))


def test_each_object_draws_from_its_own_generator():
    first, second = _Planner(GardenSpec(seed=7)), _Planner(GardenSpec(seed=7))
    second._generator().random(1000)  # what one object uses up is nothing to the next
    first.add_ground()
    second.add_ground()
    np.testing.assert_array_equal(first.things[1].mesh.corners, second.things[1].mesh.corners)


def test_all_numbers_are_finite_and_all_names_differ(scene):
    assert np.isfinite(scene.mesh.corners).all()
    assert np.isfinite(scene.mesh.uv).all()
    assert 0.0 <= scene.mesh.colour.min() <= scene.mesh.colour.max() <= 1.0
    assert len(set(scene.names)) == len(scene.names)
    assert scene.object_id.max() == len(scene.names) - 1
    assert isinstance(scene, Scene)


def test_a_garden_must_have_a_size():
    with pytest.raises(ConfigError, match=r"size_x_m = '3' is not allowed: input should be greater than or equal to 8"):
        GardenSpec(size_x_m=3)
