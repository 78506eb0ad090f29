import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from andante.simulator.obstacles import Footprint, Obstacles

BOX = Footprint(1.0, 2.0, np.pi / 6, 2.0, 0.5)


def world(along: float, across: float) -> list[tuple[float, float]]:
    cos, sin = np.cos(BOX.heading_rad), np.sin(BOX.heading_rad)
    return [(BOX.x_m + cos * along - sin * across, BOX.y_m + sin * along + cos * across)]


@given(along=st.floats(-5, 5), across=st.floats(-5, 5))
def test_clearance_is_the_distance_to_a_dense_outline(along, across):
    clearance = Obstacles.of([BOX]).clearance_m(world(along, across))[0]
    u, v = np.linspace(-2.0, 2.0, 401), np.linspace(-0.5, 0.5, 101)
    outline = np.concatenate([[(a, s * 0.5) for a in u for s in (-1, 1)], [(s * 2.0, b) for b in v for s in (-1, 1)]])
    distance = np.linalg.norm(outline - (along, across), axis=1).min()
    assert abs(abs(clearance) - distance) < 0.006
    assert (clearance < 0) == (abs(along) < 2.0 and abs(across) < 0.5) or abs(clearance) < 1e-9


def test_the_nearest_of_many_counts_and_without_any_there_is_room_everywhere():
    far = Footprint(100.0, 100.0, 0.0, 1.0, 1.0)
    np.testing.assert_allclose(Obstacles.of([BOX, far]).clearance_m([(100.0, 102.5)]), [1.5])
    assert Obstacles.of([]).clearance_m([(0.0, 0.0), (1.0, 1.0)]).tolist() == [np.inf, np.inf]


@given(x=st.floats(-4, 6), y=st.floats(-4, 6), heading=st.floats(-3.2, 3.2))
def test_the_free_way_of_a_disc_ends_where_it_touches(x, y, heading):
    obstacles = Obstacles.of([BOX])
    if obstacles.clearance_m([(x, y)])[0] < 0.35:
        return
    way = obstacles.free_way_m((x, y), heading, radius_m=0.3, reach_m=5.0)
    ahead = np.arange(0.0, 5.0, 0.005)
    room = obstacles.clearance_m(np.column_stack([x + ahead * np.cos(heading), y + ahead * np.sin(heading)]))
    assert room[ahead <= way].min() >= 0.3  # nothing is jumped over
    assert way == 5.0 or room[ahead <= way + 0.01].min() < 0.33


def test_a_disc_that_touches_something_may_leave_it():
    obstacles = Obstacles.of([Footprint(0.0, 0.0, 0.0, 1.0, 1.0)])
    assert obstacles.free_way_m((1.1, 0.0), 0.0, radius_m=0.3, reach_m=2.0) == 2.0
    assert obstacles.free_way_m((1.1, 0.0), np.pi, radius_m=0.3, reach_m=2.0) < 0.03
    assert Obstacles.of([]).free_way_m((0.0, 0.0), 0.0, radius_m=0.3, reach_m=2.0) == 2.0
