"""Alignment of two drives: shifts, paces and directions that are known."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.errors import ArrayError, ConfigError
from andante.sequences import Correspondences, align_sequences
from andante.sequences.alignment import _best_path


def apart_frames(found, expected, m):
    return np.abs((found - expected + m / 2) % m - m / 2)


@settings(max_examples=20, deadline=None)
@given(shift=st.integers(0, 149), season=st.integers(1, 20))
def test_a_lap_that_begins_elsewhere(drives, shift, season):
    truth = drives.border(n=150)
    query = np.roll(truth, -shift, axis=0)
    found = align_sequences(drives.features(query, season=season), drives.features(truth))
    np.testing.assert_array_equal(found.first, np.arange(150))
    assert apart_frames(found.second, np.arange(150) + shift, 150).max() <= 2
    assert found.confidence.min() > 0.8
    assert not found.reverse


def test_another_pace_and_another_rate(drives):
    truth = drives.border(n=150)
    warped = np.cumsum(1.0 + 0.6 * np.sin(np.linspace(0, 9, 190)))
    at = warped / warped[-1] * 149
    query = np.column_stack([np.interp(at, np.arange(150), column) for column in truth.T])
    found = align_sequences(drives.features(query, season=1), drives.features(truth), cyclic=False)
    assert apart_frames(found.second + found.offset, at, 150).max() < 2
    assert (np.diff(found.second) >= 0).all()


def test_offsets_find_places_between_frames(drives):
    truth = drives.border(n=150)
    half = drives.border(n=150, start=0.4 / 150)
    found = align_sequences(drives.features(half, noise=0.05), drives.features(truth, noise=0.05))
    assert (np.abs(found.offset) <= 0.5).all()
    whole = apart_frames(found.second, np.arange(150) + 0.4, 150)
    fine = apart_frames(found.second + found.offset, np.arange(150) + 0.4, 150)
    assert np.median(fine) < 0.5 * np.median(whole)


def test_several_laps_against_one(drives):
    found = align_sequences(
        drives.features(drives.border(n=330, laps=2.2), season=4), drives.features(drives.border(n=150))
    )
    assert apart_frames(found.second, np.arange(330), 150).max() <= 2


def test_a_place_that_the_reference_visits_often_counts_as_one(drives):
    reference, query = drives.border(n=1500, laps=10.0), drives.border(n=150)
    seen = drives.features(query, season=3), drives.features(reference)
    assert align_sequences(*seen).confidence.mean() < 0.5
    found = align_sequences(*seen, reference_xy_m=reference[:, :2])
    assert found.confidence.mean() > 0.9
    assert np.hypot(*(query - reference[found.second])[:, :2].T).max() < 0.7


def test_the_opposite_direction_is_noticed(drives):
    truth = drives.border(n=150)
    query = np.roll(truth[::-1], -40, axis=0)
    found = align_sequences(drives.features(query, season=2), drives.features(truth))
    assert found.reverse
    assert apart_frames(found.second, 109 - np.arange(150), 150).max() <= 2
    forced = align_sequences(drives.features(query, season=2), drives.features(truth), both_directions=False)
    assert not forced.reverse


def test_a_path_carries_over_frames_that_show_nothing(drives):
    truth = drives.border(n=150)
    query = drives.features(truth, season=5)
    rng = np.random.default_rng(0)
    query[60:75] = rng.standard_normal((15, query.shape[1])) * np.abs(query).mean()
    found = align_sequences(query, drives.features(truth))
    assert apart_frames(found.second, np.arange(150), 150).max() <= 6
    assert found.confidence[67] < 0.5 < found.confidence[30]


def test_another_garden_gets_no_confidence(drives):
    truth = drives.border(n=150)
    found = [align_sequences(drives.features(truth, garden=one), drives.features(truth)) for one in range(1, 9)]
    assert max(one.confidence.mean() for one in found) < 0.35


@pytest.mark.parametrize("cyclic", [False, True])
def test_the_path_is_the_best_of_all(cyclic):
    rng = np.random.default_rng(1)
    for _ in range(5):
        score = rng.normal(0, 1, (4, 5)).astype(np.float32)

        def total(path, score=score):
            value = sum(score[row, column] for row, column in enumerate(path))
            for a, b in itertools.pairwise(path):
                step = (b - a) % 5 if cyclic else b - a
                value -= min(0.25 * abs(step - 1) if 0 <= step <= 2 else np.inf, 1.5)
            return value

        path, found = _best_path(score, cyclic, 2, 1.5)
        assert found == pytest.approx(max(map(total, itertools.product(range(5), repeat=4))), abs=1e-5)
        assert total(path) == pytest.approx(found, abs=1e-5)


def test_deterministic(drives):
    query, reference = drives.features(drives.border(n=80), season=1), drives.features(drives.border(n=90))
    first, second = align_sequences(query, reference), align_sequences(query, reference)
    for name in ("first", "second", "confidence", "offset"):
        np.testing.assert_array_equal(getattr(first, name), getattr(second, name))


def test_features_that_are_all_the_same_do_no_harm():
    found = align_sequences(np.ones((5, 3)), np.ones((6, 3)))
    assert len(found) == 5
    assert np.isfinite(found.confidence).all()


def test_faults(drives):
    good = np.eye(5)
    with pytest.raises(ArrayError, match=r"query has to be one feature vector .* \(n, d\), got \(2, 5\)"):
        align_sequences(good[:2], good)
    with pytest.raises(ArrayError, match="reference holds NaN or infinity in 5 of 5 frames"):
        align_sequences(good, good * np.nan)
    with pytest.raises(ArrayError, match="equally long, got 5 and 4; use one encoder"):
        align_sequences(good, good[:, :4])
    with pytest.raises(ArrayError, match=r"one position per reference frame \(5, 2\), got \(3, 2\)"):
        align_sequences(good, good, reference_xy_m=np.zeros((3, 2)))
    with pytest.raises(ConfigError, match="max_step=0"):
        align_sequences(good, good, max_step=0)
    with pytest.raises(ArrayError, match=r"arrays \(k,\) of one length"):
        Correspondences(np.arange(3), np.arange(3), np.ones(3), np.zeros(2))
