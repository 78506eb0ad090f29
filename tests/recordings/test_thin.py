import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.data import FrameInfo, Pose2D
from andante.errors import ConfigError
from andante.recordings import moving_frames


def infos(reference=None, odometry=None):
    poses = [
        [None if x is None else Pose2D(x, 0.0) for x in xs] if xs is not None else None for xs in (reference, odometry)
    ]
    n = len(reference if reference is not None else odometry)
    first, second = (column or [None] * n for column in poses)
    return [
        FrameInfo(i, "", float(i), odometry=o, reference=r) for i, (r, o) in enumerate(zip(first, second, strict=True))
    ]


def test_a_stand_becomes_one_frame():
    assert moving_frames(infos([0, 0, 0.005, 1, 1, 2, 2, 2])).tolist() == [0, 3, 5]
    assert moving_frames(infos(odometry=[0, 0, 1, 1])).tolist() == [0, 2]


def test_slow_creeping_is_movement():
    kept = moving_frames(infos([0.004 * index for index in range(10)]))
    assert kept.tolist() == [0, 3, 6, 9]


def test_unknown_positions_are_kept():
    assert moving_frames(infos([0, None, 0, 0])).tolist() == [0, 1, 2]
    assert moving_frames(infos([None, None])).tolist() == [0, 1]


def test_reference_decides_over_odometry_and_they_are_not_mixed():
    assert moving_frames(infos([0, 0, 0], [0, 5, 9])).tolist() == [0]
    assert moving_frames(infos([0, None], [7, 0])).tolist() == [0, 1]
    assert moving_frames(infos([0, None], [7, 7])).tolist() == [0]


def test_tolerance_is_checked():
    assert moving_frames([]).shape == (0,)
    for wrong in (-1.0, math.nan):
        with pytest.raises(ConfigError, match=r"tolerance_m = .* is not allowed; use 0 or more metres"):
            moving_frames([], wrong)


@given(st.lists(st.floats(-1, 1), min_size=1), st.floats(0, 0.5))
def test_kept_neighbours_are_apart_and_dropped_frames_are_near(xs, tolerance_m):
    kept = moving_frames(infos(xs), tolerance_m).tolist()
    assert kept[0] == 0
    for before, after in zip(kept, [*kept[1:], len(xs)], strict=True):
        assert all(abs(xs[at] - xs[before]) <= tolerance_m for at in range(before, after))
        assert after == len(xs) or abs(xs[after] - xs[before]) > tolerance_m
