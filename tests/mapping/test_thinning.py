"""Thinning keeps a bounded number of frames, from every session and all over the place."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from andante.mapping.thinning import thinned_by_place

POSITIONS = hnp.arrays(
    np.float64,
    st.tuples(st.integers(1, 60), st.just(2)),
    elements=st.floats(-1e6, 1e6) | st.sampled_from([0.0, 1.0, 2.5]),
)


@given(POSITIONS, st.integers(1, 4), st.integers(1, 70))
def test_a_bounded_sorted_subset_with_every_session(xy, sessions, at_most):
    session = np.arange(len(xy)) % sessions
    kept = thinned_by_place(xy, session, at_most)
    assert len(kept) <= at_most
    assert len(kept) >= 1
    assert (np.diff(kept) > 0).all()
    assert set(kept) <= set(range(len(xy)))
    if at_most >= sessions:
        assert set(session[kept]) == set(session)


def test_few_frames_are_all_kept():
    np.testing.assert_array_equal(thinned_by_place(np.zeros((5, 2)), np.zeros(5), 5), np.arange(5))


@pytest.mark.parametrize("at_most", [10, 37, 100])
def test_what_is_kept_covers_the_path_evenly(at_most):
    xy = np.column_stack([np.linspace(0, 50, 1000), np.zeros(1000)])
    kept = thinned_by_place(xy, np.zeros(1000, np.int64), at_most)
    assert len(kept) > at_most / 2
    assert np.diff(xy[kept, 0]).max() < 2.5 * 50 / at_most


def test_more_sessions_on_one_spot_than_are_allowed_are_dropped_evenly():
    kept = thinned_by_place(np.ones((30, 2)), np.arange(30), 10)
    assert len(kept) == 10
    assert kept[0] == 0
    assert kept[-1] == 29
