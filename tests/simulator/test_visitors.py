import numpy as np
import pytest

from andante.errors import ConfigError
from andante.simulator import BorderRun, GardenSpec, Plan, Session, make_garden
from andante.simulator.movables import MOVABLE_KINDS
from andante.simulator.obstacles import Obstacles
from andante.simulator.visitors import placed_movables


@pytest.mark.parametrize("seed", range(3))
def test_visitors_keep_clear_of_the_way_of_things_and_of_each_other(garden, seed):
    way = BorderRun().drive(garden, np.random.default_rng(0)).xy_m
    things = placed_movables(garden, MOVABLE_KINDS, seed, way)
    assert [thing.kind for thing in things] == list(MOVABLE_KINDS)
    for number, thing in enumerate(things):
        own = Obstacles.of(thing.footprints)
        assert own.clearance_m(way).min() >= 1.2
        others = [f for n, other in enumerate(things) if n != number for f in other.footprints]
        middle = [(thing.footprints[0].x_m, thing.footprints[0].y_m)]
        assert Obstacles.of(others).clearance_m(middle).min() > 0
        assert garden.obstacles.clearance_m(middle)[0] > 0


def test_every_shape_fits_its_footprint_roughly(garden):
    for thing in placed_movables(garden, MOVABLE_KINDS, 0, np.empty((0, 2))):
        corners = thing.mesh.corners.reshape(-1, 3)
        low = corners[corners[:, 2] < 0.9]  # the canopy of an umbrella is above the robot
        assert Obstacles.of(thing.footprints).clearance_m(low[:, :2]).max() < 0.35
        assert corners[:, 2].min() > -0.05


def test_sessions_with_one_objects_seed_find_them_in_the_same_places_others_elsewhere():
    def session(name, seed, objects_seed, **drive):
        return Session(
            name=name, seed=seed, objects=("car", "cow"), objects_seed=objects_seed, drive=drive or BorderRun()
        )

    plan = Plan(
        garden=GardenSpec(seed=3),
        sessions=(
            session("a", 1, 9),
            session("b", 2, 9, kind="infield", frames=80),
            session("c", 3, 10),
        ),
    )
    a, b, c = (plan.scene(name).obstacles.rows[-2:] for name in "abc")
    np.testing.assert_array_equal(a, b)
    assert not np.allclose(a, c)


def test_no_room_is_an_error(garden):
    everywhere = np.stack(np.meshgrid(np.linspace(-13, 13, 27), np.linspace(-13, 13, 27)), -1).reshape(-1, 2)
    with pytest.raises(ConfigError, match="there is no room for a car in this garden; use fewer objects or a larger"):
        placed_movables(garden, ["car"], 0, everywhere)


def test_a_garden_is_not_changed_by_its_visitors(garden):
    before = len(garden.things)
    placed_movables(make_garden(garden.spec), ["cow"], 0, np.empty((0, 2)))
    assert len(garden.things) == before
