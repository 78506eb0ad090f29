"""Edges between frames of one place, against loops over all pairs."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.errors import ArrayError, ConfigError
from andante.sequences import label_edges, place_edges


def as_dict(edges):
    pairs = list(zip(edges.first.tolist(), edges.second.tolist(), strict=True))
    assert len(set(pairs)) == len(pairs)
    assert all(i < j for i, j in pairs)
    return dict(zip(pairs, edges.weight.tolist(), strict=True))


def made_frames(seed, n, sessions):
    rng = np.random.default_rng(seed)
    xy = rng.uniform(0, 3, (n, 2))
    xy[rng.random(n) < 0.1] = np.nan
    return xy, rng.integers(0, sessions, n)


def slow_choices(xy, session, radius, quota):
    """Every frame's nearest frames of every session, one frame at a time."""
    pairs = set()
    for i in range(len(xy)):
        for one in np.unique(session):
            others = [(np.hypot(*(xy[i] - xy[j])), j) for j in range(len(xy)) if j != i and session[j] == one]
            near = sorted((distance, j) for distance, j in others if distance <= radius)
            pairs |= {(min(i, j), max(i, j)) for _, j in near[:quota]}
    return pairs


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 1000),
    n=st.integers(0, 25),
    sessions=st.integers(1, 4),
    radius=st.floats(0.05, 5),
    most=st.integers(1, 12),
)
def test_each_frame_is_joined_with_its_nearest_of_every_session(seed, n, sessions, radius, most):
    xy, session = made_frames(seed, n, sessions)
    edges = as_dict(place_edges(xy, radius, session, max_neighbours=most, across_weight=0.5))
    present = len(np.unique(session[np.isfinite(xy).all(axis=1)]))
    assert set(edges) == slow_choices(xy, session, radius, max(1, most // max(1, present)))
    assert len(edges) <= n * max(most, present)
    for (i, j), weight in edges.items():
        assert weight == (1.0 if session[i] == session[j] else 0.5)


def test_a_generous_limit_joins_all_pairs_within_the_radius():
    xy, session = made_frames(1, 40, 3)
    edges = as_dict(place_edges(xy, 0.5, session, max_neighbours=200))
    assert set(edges) == {(i, j) for j in range(40) for i in range(j) if np.hypot(*(xy[i] - xy[j])) <= 0.5}


def test_the_radius_is_inclusive():
    assert len(place_edges([[0, 0], [0.5, 0]], 0.5, [0, 1])) == 1


def test_weights_choose_the_kind_of_pairs():
    xy, session = made_frames(2, 40, 2)
    within = place_edges(xy, 1.0, session, across_weight=0)
    assert len(within)
    assert (session[within.first] == session[within.second]).all()


def test_density_correction_divides_by_the_weights_at_both_ends():
    xy, session = made_frames(3, 30, 2)
    plain = as_dict(place_edges(xy, 1.0, session, across_weight=3.0))
    corrected = as_dict(place_edges(xy, 1.0, session, across_weight=3.0, density_corrected=True))
    degree = {i: sum(w for pair, w in plain.items() if i in pair) for i in range(30)}
    assert corrected == pytest.approx({(i, j): w / np.sqrt(degree[i] * degree[j]) for (i, j), w in plain.items()})


def test_a_robot_that_stands_still_does_not_explode_and_counts_less_when_corrected():
    rng = np.random.default_rng(4)
    drive = np.column_stack([np.linspace(0, 100, 2000), np.zeros(2000)])
    xy = np.concatenate([drive, rng.normal(50, 0.01, (8000, 2)) * [1, 0]])
    session = np.zeros(10_000, dtype=int)
    edges = place_edges(xy, 0.35, session, density_corrected=True)
    assert len(edges) <= 10_000 * 32
    again = place_edges(xy, 0.35, session, density_corrected=True)
    np.testing.assert_array_equal(edges.first, again.first)
    np.testing.assert_array_equal(edges.weight, again.weight)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 1000), n=st.integers(0, 25), neighbourhood=st.integers(0, 3))
def test_labels_join_equal_and_neighbouring_places(seed, n, neighbourhood):
    rng = np.random.default_rng(seed)
    place, session = rng.integers(-5, 6, n).astype(float), rng.integers(0, 2, n)
    place[rng.random(n) < 0.1] = np.nan
    edges = as_dict(label_edges(place, neighbourhood, session, max_neighbours=200))
    assert set(edges) == {(i, j) for j in range(n) for i in range(j) if abs(place[i] - place[j]) <= neighbourhood}


def test_frames_without_positions_have_no_edges():
    assert len(place_edges(np.full((3, 2), np.nan), 1.0, [0, 0, 1])) == 0
    assert len(place_edges(np.empty((0, 2)), 1.0, [])) == 0


def test_faults_are_named():
    xy = np.zeros((3, 2))
    with pytest.raises(ConfigError, match=r"radius_m=0: has to be a distance above 0 m"):
        place_edges(xy, 0, [0, 0, 0])
    with pytest.raises(ArrayError, match=r"xy_m has to hold one position per frame \(n, 2\), got shape \(3,\)"):
        place_edges(np.zeros(3), 1, [0, 0, 0])
    with pytest.raises(ArrayError, match=r"session has shape \(2,\), but there are 3 frames"):
        place_edges(xy, 1, [0, 0])
    with pytest.raises(ConfigError, match="across_weight=-1"):
        place_edges(xy, 1, [0, 0, 0], across_weight=-1)
    with pytest.raises(ConfigError, match="max_neighbours=0: has to be at least 1"):
        place_edges(xy, 1, [0, 0, 0], max_neighbours=0)
    with pytest.raises(ConfigError, match="neighbourhood=-1"):
        label_edges([1, 2], -1, [0, 0])
    with pytest.raises(ArrayError, match=r"one label per frame \(n,\), got shape \(3, 2\)"):
        label_edges(xy, 1, [0, 0, 0])
