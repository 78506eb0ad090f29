"""Edges along time."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.errors import ArrayError, ConfigError
from andante.sequences import temporal_edges


@given(lengths=st.lists(st.integers(1, 5), min_size=1, max_size=6))
def test_consecutive_frames_of_each_session(lengths):
    session = np.repeat(np.arange(len(lengths)), lengths)
    edges = temporal_edges(session)
    expected = [(i, i + 1) for i in range(len(session) - 1) if session[i] == session[i + 1]]
    assert list(zip(edges.first, edges.second, strict=True)) == expected
    assert (edges.weight == 1).all()


def test_long_gaps_are_left_out():
    edges = temporal_edges([0, 0, 0, 1, 1], timestamp_s=[0.0, 0.5, 3.0, 3.1, 3.2], max_gap_s=0.5)
    assert (edges.first.tolist(), edges.second.tolist()) == ([0, 3], [1, 4])


def test_no_frames_no_edges():
    assert len(temporal_edges([])) == len(temporal_edges([7])) == 0


def test_faults_are_named():
    with pytest.raises(ArrayError, match=r"one number per frame \(n,\), got shape \(2, 1\)"):
        temporal_edges([[0], [1]])
    with pytest.raises(ConfigError, match="needs timestamp_s beside it"):
        temporal_edges([0, 0], max_gap_s=1.0)
    with pytest.raises(ConfigError, match=r"max_gap_s=0: has to be above 0"):
        temporal_edges([0, 0], timestamp_s=[0, 1], max_gap_s=0)
    with pytest.raises(ArrayError, match=r"timestamp_s has shape \(1,\), session \(2,\)"):
        temporal_edges([0, 0], timestamp_s=[0], max_gap_s=1)
