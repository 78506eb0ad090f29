"""What is held out together: sessions, groups of them, or blocks of a single one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.mapping.config import CalibrationConfig
from andante.mapping.folds import Folds
from andante.mapping.learning import Ground

CONFIG = CalibrationConfig()


def ground(sessions: list[int], step_m: float = 0.2) -> Ground:
    """Straight drives of so many frames each."""
    xy = np.concatenate([np.column_stack([step_m * np.arange(n), np.zeros(n)]) for n in sessions])
    return Ground(xy, np.repeat(np.arange(len(sessions)), sessions), np.arange(len(xy)), 0.5)


def test_sessions_are_left_out_whole():
    where = ground([40, 30, 20])
    folds = Folds.of(where, ["a", "b", "c"], CONFIG)
    assert (folds.kind, folds.labels, folds.members) == ("sessions", ("a", "b", "c"), ((0,), (1,), (2,)))
    assert [int(test.sum()) for _, test in folds] == [40, 30, 20]
    for train, test in folds:
        assert not (train & test).any()
        assert (train | test).all()
        assert not set(where.session[train]) & set(where.session[test])


def test_many_sessions_share_folds():
    folds = Folds.of(ground([12] * 7), list("abcdefg"), CalibrationConfig(folds=3))
    assert folds.labels == ("a + d + g", "b + e", "c + f")
    assert folds.members == ((0, 3, 6), (1, 4), (2, 5))
    assert [int(test.sum()) for _, test in folds] == [36, 24, 24]


@given(st.lists(st.integers(0, 9), min_size=1, max_size=12), st.integers(2, 20), st.floats(0.01, 5))
def test_every_frame_is_held_out_once_and_with_those_it_belongs_to(lengths, most, step_m):
    """Sessions without frames included, as thinning leaves them out."""
    where = ground([*lengths, 2], step_m)
    names = [f"s{number}" for number in range(len(lengths) + 1)]
    folds = Folds.of(where, names, CalibrationConfig(folds=most))
    pairs = list(folds)
    assert len(pairs) == len(folds.labels) == len(folds.members) <= most
    np.testing.assert_array_equal(np.sum([test for _, test in pairs], axis=0), 1)
    for (train, test), members, label in zip(pairs, folds.members, folds.labels, strict=True):
        np.testing.assert_array_equal(train, ~test)
        assert set(where.session[test].tolist()) <= set(members) or folds.kind == "blocks"
        if folds.kind == "sessions":
            np.testing.assert_array_equal(test, np.isin(where.session, members))
            assert label == " + ".join(names[member] for member in members)
            assert train.any()


def test_one_session_is_left_out_in_blocks():
    where = ground([200])
    folds = Folds.of(where, ["a"], CONFIG)
    assert folds.kind == "blocks"
    assert folds.labels[0] == "blocks 1 of 10"
    assert set(folds.members) == {(0,)}
    pairs = list(folds)
    np.testing.assert_array_equal(np.sum([test for _, test in pairs], axis=0), 1)
    starts = np.flatnonzero(np.diff(pairs[0][1].astype(int)))
    assert np.diff(where.xy[starts, 0]).max() >= 4 * 0.5 - 0.2  # blocks of four radii


@pytest.mark.parametrize("block_m", [1.0, 3.0])
def test_blocks_are_as_long_as_configured(block_m):
    folds = Folds.of(ground([200]), ["a"], CalibrationConfig(block_m=block_m))
    lengths = np.diff(np.flatnonzero(np.diff(folds.fold_of)))
    assert set(lengths.tolist()) <= {round(block_m / 0.2) + slack for slack in (-1, 0, 1)}


def test_a_drive_shorter_than_a_block_is_all_in_one():
    assert [int(test.sum()) for _, test in Folds.of(ground([10], step_m=0.01), ["a"], CONFIG)] == [10] + [0] * 9
