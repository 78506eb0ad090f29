import numpy as np

from andante.baselines.structure.pairs import matched_pairs


def test_pairs_are_unique_and_follow_the_drive() -> None:
    xy = np.column_stack([np.arange(30.0), np.zeros(30)])
    pairs = matched_pairs(xy, np.zeros(30, np.int64), neighbours=0, radius_m=1.0)
    gaps = pairs[:, 1] - pairs[:, 0]
    assert set(gaps.tolist()) == {1, 2, 3, 5, 8, 13, 21}
    assert (gaps == 1).sum() == 29
    assert len(np.unique(pairs, axis=0)) == len(pairs)


def test_other_drives_and_other_rounds_are_matched_where_they_are_near() -> None:
    turn = 2 * np.pi * np.arange(80) / 40
    xy = 5 * np.column_stack([np.cos(turn), np.sin(turn)])
    session = np.repeat([0, 1], [60, 20])
    pairs = matched_pairs(xy, session, neighbours=2, radius_m=0.5)
    across = pairs[session[pairs[:, 0]] != session[pairs[:, 1]]]
    again = pairs[(pairs[:, 1] - pairs[:, 0] == 40) & (session[pairs[:, 1]] == 0)]
    assert len(again) == 20
    assert set(across[:, 1].tolist()) == set(range(60, 80))
    assert np.linalg.norm(xy[across[:, 0]] - xy[across[:, 1]], axis=1).max() <= 0.5


def test_fewer_pictures_than_the_largest_gap_are_all_right() -> None:
    assert matched_pairs(np.zeros((2, 2)), np.zeros(2, np.int64), neighbours=3, radius_m=1.0).tolist() == [[0, 1]]
