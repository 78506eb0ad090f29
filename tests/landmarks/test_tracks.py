"""Which detections are the one anchor."""

from dataclasses import replace

import numpy as np
import pytest

from andante.errors import InputError
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.tracks import Chosen, one_anchor

FRAMES = 40
TURNS = 0.2 * np.arange(FRAMES)


def seen(start, n, score=0.8, drift=0.02):
    azimuth = start - TURNS[n] + drift * n
    return Detection(Box(float(np.angle(np.exp(1j * azimuth))), 0.1, 0.3, 0.4), "bicycle", score)


def test_one_thing_is_one_chain_while_the_robot_turns_around_itself():
    detections = {n: [seen(1.0, n)] for n in range(FRAMES)}
    assert one_anchor(detections, TURNS) == {n: one for n, (one,) in detections.items()}


def test_outliers_beside_the_chain_are_left_out():
    rng = np.random.default_rng(1)
    detections = {n: [seen(1.0, n)] for n in range(FRAMES)}
    for n in (5, 17, 30):
        detections[n].append(Detection(Box(rng.uniform(-3, 3), 0.1, 0.2, 0.2), "bicycle", 0.9))
    kept = one_anchor(detections, TURNS)
    assert all(kept[n] == detections[n][0] for n in range(FRAMES))


def test_an_outlier_in_a_gap_is_left_out():
    detections = {n: [seen(1.0, n)] for n in range(FRAMES) if n != 12}
    detections[12] = [seen(-1.5, 12, 0.9)]
    assert 12 not in one_anchor(detections, TURNS)


def test_a_thing_that_comes_into_view_again_is_the_same():
    detections = {n: [seen(1.0, n)] for n in [*range(5), *range(30, 40)]}
    assert len(one_anchor(detections, TURNS)) == 15


def test_a_part_taken_for_the_whole_is_left_out():
    detections = {n: [seen(1.0, n)] for n in range(FRAMES)}
    for n in (0, 8, 9, 39):
        (one,) = detections[n]
        detections[n] = [replace(one, box=replace(one.box, width_rad=0.15))]
    assert sorted(one_anchor(detections, TURNS)) == [n for n in range(FRAMES) if n not in (0, 8, 9, 39)]
    growing = {n: replace(seen(1.0, n), box=Box(0.0, 0.1, 0.1 * 1.09**n, 0.1 * 1.09**n)) for n in range(FRAMES)}
    assert len(one_anchor({n: [one] for n, one in growing.items()}, 0.0 * TURNS)) == FRAMES


def test_two_things_of_a_kind_are_an_error_that_says_how_to_choose():
    detections = {n: [seen(1.0, n), seen(-1.5, n, 0.7)] for n in range(FRAMES)}
    with pytest.raises(
        InputError,
        match=r"two things called 'bicycle' .* frame 0 at azimuths 57 and -86 .* \(--which 0,57\)",
    ):
        one_anchor(detections, TURNS)
    kept = one_anchor(detections, TURNS, Chosen(20, detections[20][1].box.azimuth_rad))
    assert kept == {n: both[1] for n, both in detections.items()}


def test_choosing_where_nothing_is_is_an_error():
    with pytest.raises(InputError, match=r"no such thing .* in frame 39, it was in 5 others, as 2; choose a frame"):
        one_anchor({n: [seen(1.0, n)] for n in range(5)}, TURNS, Chosen(39, 0.0))


def test_nothing_found_is_nothing():
    assert one_anchor({0: [], 1: []}, TURNS) == {}


def past(things, drive, frames):
    """What a robot sees at ``drive`` (n, 3) of things at places: in each frame the one of its half of the drive."""
    detections = {}
    for n in frames:
        away = things[2 * n // len(drive)] - drive[n, :2]
        azimuth = np.arctan2(away[1], away[0]) - drive[n, 2]
        box = Box(float(np.angle(np.exp(1j * azimuth))), 0.1, 1.0 / np.hypot(*away), 0.4)
        detections[n] = [Detection(box, "bicycle", 0.8)]
    return detections


@pytest.fixture
def lap():
    """Around a circle of 3 m, facing along it."""
    turn = 2 * np.pi * np.arange(FRAMES) / FRAMES
    return np.column_stack([3 * np.cos(turn), 3 * np.sin(turn), turn + np.pi / 2])


SEEN = [*range(1, 9), *range(31, 39)]


def test_things_that_are_never_seen_at_once_are_told_apart_by_where_they_stand(lap):
    turns = lap[:, 2] - lap[0, 2]
    detections = past(np.array([(5.0, 2.0), (4.0, -4.5)]), lap, SEEN)
    assert len(one_anchor(detections, turns)) == 16
    with pytest.raises(
        InputError, match=r"'bicycle' stand in different places, one in .* \(--which 5,-?\d+\), or take"
    ):
        one_anchor(detections, turns, None, lap)
    assert list(one_anchor(detections, turns, Chosen(35, 0.0), lap)) == list(range(31, 39))
    lost = np.where(np.arange(FRAMES)[:, None] > 20, np.nan, lap)
    assert len(one_anchor(detections, turns, None, lost)) == 16


def test_a_thing_that_is_seen_again_where_it_stood_is_the_same(lap):
    detections = past(np.array([(5.0, 0.0), (5.0, 0.0)]), lap, SEEN)
    assert len(one_anchor(detections, lap[:, 2] - lap[0, 2], None, lap)) == 16
