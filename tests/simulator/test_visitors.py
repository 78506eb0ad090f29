import numpy as np
import pytest

from andante.errors import ConfigError
from andante.simulator import BorderRun, GardenSpec, Placed, Plan, Session, make_garden
from andante.simulator.movables import MOVABLE_KINDS
from andante.simulator.obstacles import Obstacles
from andante.simulator.visitors import placed_movables, put_down


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


def test_things_stand_where_they_are_put_down_and_visitors_keep_clear_of_them(garden):
    placed = [Placed(kind="bicycle", x_m=0.5, y_m=-1.0, heading_rad=0.7), Placed(kind="hatchback", x_m=3.0, y_m=2.0)]
    first, second = put_down(placed, 4)
    assert (first.kind, second.kind) == ("bicycle", "hatchback")
    assert first.footprints == (placed[0].footprint,)
    middle = first.mesh.corners.reshape(-1, 3)[:, :2].mean(axis=0)
    np.testing.assert_allclose(middle, (0.5, -1.0), atol=0.15)
    for seed in range(5):
        (cow,) = placed_movables(garden, ["cow"], seed, np.empty((0, 2)), placed)
        corners = np.array([[f.x_m, f.y_m] for f in cow.footprints])
        assert Obstacles.of([one.footprint for one in placed]).clearance_m(corners).min() > 0.4


def test_the_shapes_of_what_can_only_be_put_down_fit_their_footprints():
    for number, kind in enumerate(("hatchback", "trolley")):
        for seed in range(3):
            (thing,) = put_down([Placed(kind=kind, x_m=number, y_m=0.0)], seed)
            corners = thing.mesh.corners.reshape(-1, 3)
            assert Obstacles.of(thing.footprints).clearance_m(corners[:, :2]).max() < 0.12
            assert corners[:, 2].min() > -0.05


def test_sessions_that_share_objects_find_them_in_the_same_places_with_an_anchor_and_without():
    def session(name, **more):
        return Session(name=name, objects=("cow", "car"), objects_seed=9, **more)

    anchor = Placed(kind="bicycle", x_m=1.0, y_m=1.0)
    plan = Plan(garden=GardenSpec(seed=3), sessions=(session("taught", placed=(anchor,)), session("mapped")))
    taught, mapped = (plan.scene(name) for name in ("taught", "mapped"))
    np.testing.assert_array_equal(taught.obstacles.rows[-2:], mapped.obstacles.rows[-2:])
    assert "bicycle1" in taught.names
    assert "bicycle1" not in mapped.names


def test_what_cannot_be_put_down_is_an_error():
    with pytest.raises(ConfigError, match="kind = 'boat' is not allowed"):
        Placed(kind="boat", x_m=0.0, y_m=0.0)
