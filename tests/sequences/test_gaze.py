import numpy as np
import pytest

from andante.errors import ArrayError, ConfigError
from andante.sequences.gaze import gaze_edges, region_azimuths, region_towards

K = 24


@pytest.fixture
def drives():
    """Two drives around a circle, and the points that their regions look at: a round wall 9 m from its middle."""
    turn = np.concatenate([np.arange(20), np.arange(15) + 0.5]) * 0.3
    xy = 3 * np.stack([np.cos(turn), np.sin(turn)], axis=1)
    session = np.repeat([0, 1], [20, 15])
    ray = np.stack([np.cos(region_azimuths(K)), np.sin(region_azimuths(K))], axis=1)
    along = xy @ ray.T
    distance = -along + np.sqrt(along**2 + 81 - (xy**2).sum(axis=1)[:, None])
    return xy, xy[:, None] + distance[..., None] * ray, session


def parts(edges):
    """Frames and regions of both ends, (m, 2) each."""
    return np.stack(np.divmod(edges.first, K), axis=1), np.stack(np.divmod(edges.second, K), axis=1)


def test_a_region_looks_where_it_says():
    spot = np.array([2.0, -1.0])
    azimuth = region_azimuths(K)
    ahead = spot + 5 * np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    assert region_towards(spot, ahead, K).tolist() == list(range(K))
    assert (np.diff(azimuth) < 0).all()


def test_the_whole_horizon_of_every_frame_is_covered(drives):
    xy, gaze, session = drives
    edges = gaze_edges(xy, gaze, session)
    assert np.unique(np.concatenate([edges.first, edges.second])).tolist() == list(range(len(xy) * K))


def test_gazes_step_once_around_every_frame(drives):
    xy, gaze, session = drives
    steps = gaze_edges(xy, np.full_like(gaze, np.nan), session, step_weight=0.7)
    first, second = parts(steps)
    assert len(steps) == len(xy) * K
    assert (first[:, 0] == second[:, 0]).all()
    assert ((second[:, 1] - first[:, 1]) % K == 1).all()
    assert (steps.weight == 0.7).all()


def test_a_followed_gaze_stays_on_its_point(drives):
    xy, gaze, session = drives
    edges = gaze_edges(xy, gaze, session, strides=(1, 7), radius_m=1.0, step_weight=0)
    first, second = parts(edges)
    towards = gaze[first[:, 0], first[:, 1]] - xy[second[:, 0]]
    off = np.arctan2(towards[:, 1], towards[:, 0]) - region_azimuths(K)[second[:, 1]]
    assert (np.abs(np.angle(np.exp(1j * off))) <= np.pi / K + 1e-9).all()
    assert (edges.weight == 1).all()


@pytest.mark.parametrize("stride", [1, 4, 30])
def test_gazes_are_followed_within_a_drive_alone(drives, stride):
    xy, gaze, session = drives
    first, second = parts(gaze_edges(xy, gaze, session, strides=(stride,), step_weight=0))
    assert (second[:, 0] - first[:, 0] == stride).all()
    assert (session[first[:, 0]] == session[second[:, 0]]).all()
    assert len(first) == K * (max(0, 20 - stride) + max(0, 15 - stride))


def test_another_drive_is_joined_at_the_nearest_frame(drives):
    xy, gaze, session = drives
    first, second = parts(gaze_edges(xy, gaze, session, strides=(), radius_m=0.6, step_weight=0))
    assert len(first)
    assert (session[first[:, 0]] != session[second[:, 0]]).all()
    for one, other in {tuple(pair) for pair in np.stack([first[:, 0], second[:, 0]], axis=1).tolist()}:
        others = np.flatnonzero(session == session[other])
        away = np.linalg.norm(xy[others] - xy[one], axis=1)
        assert np.linalg.norm(xy[other] - xy[one]) == away.min() <= 0.6


def test_what_is_infinitely_far_away_stays_in_its_region(drives):
    xy, gaze, session = drives
    far = xy[:, None] + (gaze - xy[:, None]) * 1e6
    first, second = parts(gaze_edges(xy, far, session, strides=(3,), step_weight=0))
    assert (first[:, 1] == second[:, 1]).all()


def test_nothing_is_followed_from_where_the_gaze_is_unknown(drives):
    xy, gaze, session = drives
    gaze[4, 5] = np.nan
    first, _ = parts(gaze_edges(xy, gaze, session, step_weight=0))
    assert not ((first[:, 0] == 4) & (first[:, 1] == 5)).any()
    assert ((first[:, 0] == 4) & (first[:, 1] == 6)).any()


def test_bad_input(drives):
    xy, gaze, session = drives
    with pytest.raises(ArrayError, match=r"gaze_m has to hold a point .* \(35, K, 2\), got shape \(35, 24\)"):
        gaze_edges(xy, gaze[..., 0], session)
    with pytest.raises(ArrayError, match=r"session has shape \(3,\), but there are 35 frames"):
        gaze_edges(xy, gaze, session[:3])
    with pytest.raises(ArrayError, match=r"one known position per frame"):
        gaze_edges(np.where(xy > 2.9, np.nan, xy), gaze, session)
    with pytest.raises(ConfigError, match=r"strides=\(0,\): a gaze is followed over 1 frame or more"):
        gaze_edges(xy, gaze, session, strides=(0,))
    with pytest.raises(ConfigError, match=r"radius_m=-1"):
        gaze_edges(xy, gaze, session, radius_m=-1)
    with pytest.raises(ConfigError, match=r"step_weight=inf"):
        gaze_edges(xy, gaze, session, step_weight=np.inf)
