from dataclasses import replace

import numpy as np
import pytest

from andante.errors import ArrayError
from andante.mapping.gaze_votes import Gallery, Rules, _by_heading, verdict
from andante.sequences.gaze import region_azimuths

K, FRAMES, DIM = 24, 40, 10
RULES = Rules(width_deg=30)


def angle_between(one, other):
    return abs(np.angle(np.exp(1j * (one - other))))


@pytest.fixture(scope="module")
def gallery():
    """A walk on a line; slow features change from frame to frame and from region to region."""
    rng = np.random.default_rng(0)
    slow = rng.normal(size=(FRAMES + 2, K, DIM))
    slow = (slow[:-2] + slow[1:-1] + slow[2:]).astype(np.float32)
    xy = np.stack([np.arange(FRAMES) * 0.2, np.zeros(FRAMES)], axis=1)
    return Gallery(slow, xy, np.full((FRAMES, K, 2), np.nan))


@pytest.fixture
def seen(gallery):
    """``seen(frame, turn, regions)``: what the robot sees in some regions, headed for region ``turn``, and where."""
    rng = np.random.default_rng(1)

    def see(frame, turn, regions):
        slow = gallery.slow[frame, regions] + rng.normal(0, 0.3, (len(regions), DIM))
        return slow.astype(np.float32), region_azimuths(K)[regions] - region_azimuths(K)[turn]

    return see


@pytest.mark.parametrize(("frame", "turn", "regions"), [(3, 0, [5]), (20, 7, [2, 9, 17]), (33, 23, [*range(0, 24, 3)])])
def test_patches_tell_place_and_heading(gallery, seen, frame, turn, regions):
    told = verdict(gallery, *seen(frame, turn, regions), RULES)
    assert np.linalg.norm(told.xy - gallery.xy[frame]) < 0.3
    assert angle_between(told.heading_rad, region_azimuths(K)[turn]) < np.pi / K
    assert told.margin > 0
    assert (told.support > 0.5).all()


def test_a_hidden_patch_drops_out(gallery, seen):
    slow, azimuth = seen(12, 4, [0, 6, 12, 18])
    clear = verdict(gallery, slow, azimuth, RULES)
    slow[2] = np.random.default_rng(5).normal(0, 4, DIM)
    told = verdict(gallery, slow, azimuth, RULES)
    assert np.linalg.norm(told.xy - clear.xy) < 0.1
    assert told.support[2] < 0.1
    assert (np.delete(told.support, 2) > 0.5).all()
    assert told.clarity[2] < np.delete(told.clarity, 2).min()


def test_two_that_agree_beat_one_that_does_not(gallery, seen):
    slow, azimuth = seen(12, 4, [0, 6, 12])
    other, _ = seen(30, 9, [17])
    slow[1] = other[0]
    told = verdict(gallery, slow, azimuth, RULES)
    assert np.linalg.norm(told.xy - gallery.xy[12]) < 0.3
    assert told.support[1] < 0.1


def test_right_patches_in_wrong_directions_do_not_agree(gallery, seen):
    slow, azimuth = seen(12, 4, [0, 6, 12])
    told = verdict(gallery, slow, azimuth, RULES)
    mixed = verdict(gallery, slow, azimuth[::-1], RULES)
    assert mixed.margin < told.margin
    assert mixed.support.sum() < told.support.sum()


def test_a_turn_of_the_robot_changes_the_heading_alone(gallery, seen):
    slow, azimuth = seen(20, 7, [2, 9, 17])
    told = verdict(gallery, slow, azimuth, RULES)
    for turn in (2 * np.pi / K, -5 * 2 * np.pi / K):
        turned = verdict(gallery, slow, azimuth - turn, RULES)
        np.testing.assert_allclose(turned.xy, told.xy, atol=1e-5)
        assert angle_between(turned.heading_rad, told.heading_rad + turn) < 1e-3


def test_headings_against_a_slow_reference():
    rng = np.random.default_rng(2)
    vote = rng.normal(size=(3, K)).astype(np.float32)
    grid = region_azimuths(K)
    for azimuth in (0.0, 0.3, -2.2, 2 * np.pi / K * 3):
        expected = np.empty((3, K))
        for turn, heading in enumerate(grid):
            at = (np.pi - heading - azimuth) * K / (2 * np.pi) - 0.5
            low = int(np.floor(at))
            expected[:, turn] = vote[:, low % K] * (1 - at + low) + vote[:, (low + 1) % K] * (at - low)
        np.testing.assert_allclose(_by_heading(vote, azimuth), expected, atol=1e-4)


def test_hypotheses_are_the_winner_and_places_beyond_it(gallery, seen):
    told = verdict(gallery, *seen(20, 7, [2, 9]), RULES)
    best, *others = told.hypotheses
    assert (best.x_m, best.y_m) == tuple(told.xy)
    assert sum(one.weight for one in told.hypotheses) == pytest.approx(1)
    assert [one.weight for one in others] == sorted((one.weight for one in others), reverse=True)
    assert all(abs(one.x_m - best.x_m) > RULES.consensus_m / 2 for one in others)
    assert np.log(best.weight / others[0].weight) == pytest.approx(told.margin)


def test_one_place_alone_has_no_rivals(gallery, seen):
    told = verdict(gallery, *seen(20, 7, [2, 9]), replace(RULES, consensus_m=100))
    assert told.margin == np.inf
    assert len(told.hypotheses) == 1


def test_patches_that_overlap_count_for_less(gallery, seen):
    slow, azimuth = seen(20, 7, [*range(K)])
    narrow, wide = (verdict(gallery, slow, azimuth, replace(RULES, width_deg=width)) for width in (15, 60))
    assert wide.margin == pytest.approx(narrow.margin / 4, rel=1e-4)


def test_bad_input(gallery, seen):
    slow, azimuth = seen(20, 7, [2, 9])
    with pytest.raises(ArrayError, match=r"each of at least one patch needs an azimuth, got 0 patches"):
        verdict(gallery, slow[:0], azimuth[:0], RULES)
    with pytest.raises(ArrayError, match=r"got 2 patches and \(1,\)"):
        verdict(gallery, slow, azimuth[:1], RULES)
    with pytest.raises(ArrayError, match=r"a gallery needs slow features \(frames, regions, k\)"):
        Gallery(gallery.slow, gallery.xy[:3], gallery.points_m)
