"""The thesis' orders: places slow, conditions fast."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.errors import ArrayError, ConfigError
from andante.sequences import (
    loop_closure_edges,
    loop_closure_order,
    restructured_edges,
    restructured_order,
)


def laps(sessions, n, rng):
    """Sessions that drive the same circle of 10 m, each with its own offset of a few centimetres."""
    angle = np.linspace(0, 2 * np.pi, n, endpoint=False) + rng.uniform(0, 0.01, (sessions, 1))
    radius = 10 / (2 * np.pi) + rng.uniform(-0.02, 0.02, (sessions, 1))
    xy = np.stack([radius * np.cos(angle), radius * np.sin(angle)], axis=-1).reshape(-1, 2)
    return xy, np.repeat(np.arange(sessions), n)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000), sessions=st.integers(1, 4), n=st.integers(2, 40), bin_m=st.floats(0.6, 3))
def test_order_is_a_permutation_in_which_places_advance(seed, sessions, n, bin_m):
    rng = np.random.default_rng(seed)
    xy, session = laps(sessions, n, rng)
    xy[rng.random(len(xy)) < 0.1] = np.nan
    order = restructured_order(xy, session, bin_m, rng)
    assert len(np.unique(order)) == len(order)
    assert np.isfinite(xy[order]).all()


def test_every_session_takes_its_turn_at_a_place_before_the_next():
    rng = np.random.default_rng(0)
    xy, session = laps(3, 50, rng)
    order = restructured_order(xy, session, 0.2, rng)
    assert sorted(order) == list(range(150))
    steps = np.hypot(*np.diff(xy[order], axis=0).T)
    assert steps.max() < 0.7
    # In time the condition changes twice in 149 steps, in the new order nearly always.
    assert np.mean(np.diff(session[order]) != 0) > 0.6
    first_session = order[session[order] == 0]
    assert (np.diff(first_session) > 0).all()


def test_sessions_take_turns_within_a_place():
    xy, session = np.zeros((9, 2)), np.repeat([0, 1, 2], 3)
    order = restructured_order(xy, session, 1.0, np.random.default_rng(1))
    for turn in np.split(order, 3):
        assert sorted(session[turn]) == [0, 1, 2]


def test_the_longest_path_leads_and_frames_off_it_are_left_out():
    line = np.column_stack([np.arange(10.0), np.zeros(10)])
    xy = np.concatenate([line[3:6], line, line + np.array([0, 5.0])])
    session = np.repeat([0, 1, 2], [3, 10, 10])
    order = restructured_order(xy, session, 1.0, np.random.default_rng(2))
    assert sorted(order) == list(range(13))
    assert (np.diff(xy[order, 0]) >= 0).all()


def test_the_generator_decides_the_order_of_conditions():
    xy, session = laps(4, 30, np.random.default_rng(3))
    a = restructured_order(xy, session, 0.5, np.random.default_rng(7))
    b = restructured_order(xy, session, 0.5, np.random.default_rng(7))
    c = restructured_order(xy, session, 0.5, np.random.default_rng(8))
    np.testing.assert_array_equal(a, b)
    assert (a != c).any()


def test_edges_follow_the_order():
    xy, session = laps(2, 20, np.random.default_rng(4))
    order = restructured_order(xy, session, 0.5, np.random.default_rng(5))
    edges = restructured_edges(xy, session, 0.5, np.random.default_rng(5))
    np.testing.assert_array_equal(edges.first, order[:-1])
    np.testing.assert_array_equal(edges.second, order[1:])


def test_no_positions_no_order():
    nowhere = np.full((3, 2), np.nan)
    assert len(restructured_edges(nowhere, [0, 0, 1], 1.0, np.random.default_rng(0))) == 0
    assert len(loop_closure_edges(nowhere, 0.1, 1.0)) == 0


def slow_loop_closure_order(xy, radius_m, min_travel_m):
    travelled = np.concatenate([[0], np.cumsum(np.hypot(*np.diff(xy, axis=0).T))])
    groups = []
    for i in range(len(xy)):
        near = [
            (np.hypot(*(xy[i] - xy[group[0]])), group[0], group)
            for group in groups
            if np.hypot(*(xy[i] - xy[group[0]])) <= radius_m and travelled[group[0]] < travelled[i] - min_travel_m
        ]
        if near:
            min(near)[2].append(i)
        else:
            groups.append([i])
    return [i for group in groups for i in group]


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000), n=st.integers(2, 60))
def test_revisits_stand_behind_the_first_visit(seed, n):
    xy = np.random.default_rng(seed).normal(0, 0.3, (n, 2)).cumsum(axis=0)
    order = loop_closure_order(xy, 0.4, 1.0)
    assert order.tolist() == slow_loop_closure_order(xy, 0.4, 1.0)


def test_two_laps_are_interleaved():
    xy, _ = laps(1, 20, np.random.default_rng(6))
    xy = np.concatenate([xy, xy, [[np.nan, np.nan]]])
    order = loop_closure_order(xy, 0.1, 2.0)
    assert order.tolist() == [frame for i in range(20) for frame in (i, i + 20)]
    edges = loop_closure_edges(xy, 0.1, 2.0)
    assert (edges.first[0], edges.second[0]) == (0, 20)


def test_faults_are_named():
    rng = np.random.default_rng(0)
    with pytest.raises(ConfigError, match=r"bin_m=0: has to be a length above 0 m"):
        restructured_order(np.zeros((2, 2)), [0, 0], 0, rng)
    with pytest.raises(ArrayError, match=r"got shapes \(2, 2\), \(3,\)"):
        restructured_order(np.zeros((2, 2)), [0, 0, 0], 1, rng)
    with pytest.raises(ConfigError, match="both have to be lengths above 0 m"):
        loop_closure_order(np.zeros((2, 2)), 0.1, 0)
