"""One drive in the frame of another: transforms that are known, correspondences that are wrong."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.errors import ArrayError, ConfigError, RecordingError
from andante.sequences import fit_similarity


def moved(points, angle, shift, scale):
    matrix = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return scale * points @ matrix.T + shift


@settings(max_examples=25, deadline=None)
@given(angle=st.floats(-3.1, 3.1), scale=st.floats(0.96, 1.04), x=st.floats(-100, 100), seed=st.integers(0, 50))
def test_a_known_transform_is_found_and_wrong_ones_are_counted(angle, scale, x, seed):
    rng = np.random.default_rng(seed)
    source = rng.uniform(0, 15, (100, 2))
    target = moved(source, angle, np.array([x, 2.0]), scale)
    wrong = rng.choice(100, 30, replace=False)
    target[wrong] += rng.choice([-1, 1], (30, 2)) * rng.uniform(3, 9, (30, 2))
    found = fit_similarity(source, target)
    assert (found.n_kept, found.n_rejected) == (70, 30)
    assert not found.kept[wrong].any()
    assert found.scale == pytest.approx(scale, abs=1e-6)
    assert np.cos(found.rotation_rad - angle) == pytest.approx(1.0)
    assert found.residual_m < 1e-6
    np.testing.assert_allclose(found.apply(source), moved(source, angle, np.array([x, 2.0]), scale), atol=1e-6)


def test_poses_turn_along():
    source = np.random.default_rng(0).uniform(0, 9, (30, 2))
    found = fit_similarity(source, moved(source, 0.5, np.ones(2), 1.0))
    poses = found.apply(np.column_stack([source, np.zeros(30)]))
    np.testing.assert_allclose(poses[:, 2], 0.5, atol=1e-9)


def test_without_scale_it_is_rigid():
    source = np.random.default_rng(0).uniform(-5, 5, (50, 2))
    found = fit_similarity(source, 1.03 * source, with_scale=False)
    assert found.scale == 1.0
    assert 0.0 < found.residual_m < 0.3


def test_confidence_weighs():
    source = np.random.default_rng(0).uniform(0, 9, (60, 2))
    target = source.copy()
    target[:30] += 0.5
    sure = np.where(np.arange(60) < 30, 0.02, 1.0)
    found = fit_similarity(source, target, sure, with_scale=False)
    assert np.abs(found.translation_m).max() < 0.1


def test_deterministic():
    rng = np.random.default_rng(0)
    source, target = rng.uniform(0, 9, (2, 60, 2))
    target[:40] = source[:40]
    first, second = (fit_similarity(source, target, seed=4) for _ in range(2))
    np.testing.assert_array_equal(first.translation_m, second.translation_m)
    np.testing.assert_array_equal(first.kept, second.kept)


def test_places_that_do_not_belong_together_are_refused():
    source, target = np.random.default_rng(0).uniform(0, 12, (2, 200, 2))
    with pytest.raises(RecordingError, match=r"does not fit: \d+ of 200 .* within 0.6 m, at least 10 and 50% of all"):
        fit_similarity(source, target)
    with pytest.raises(RecordingError, match="does not fit: 9 of 9"):
        fit_similarity(source[:9], source[:9])
    # A drive of twice the size is another drive.
    with pytest.raises(RecordingError, match="does not fit"):
        fit_similarity(source, 2 * source)
    # From one spot no rotation can be told.
    with pytest.raises(RecordingError, match="does not fit"):
        fit_similarity(np.zeros((50, 2)), np.zeros((50, 2)))


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        ({"target_m": np.zeros((3, 2))}, ArrayError, r"got shapes \(20, 2\), \(3, 2\), \(20,\)"),
        ({"confidence": np.ones(3)}, ArrayError, r"one of each per correspondence"),
        ({"confidence": -np.ones(20)}, ArrayError, "confidence not below 0"),
        ({"source_m": np.full((20, 2), np.nan)}, ArrayError, "finite"),
        ({"inlier_m": 0}, ConfigError, "inlier_m=0"),
        ({"max_scale_error": 0.7}, ConfigError, "max_scale_error=0.7"),
    ],
)
def test_faults(change, error, message):
    given = {"source_m": np.zeros((20, 2)), "target_m": np.zeros((20, 2)), **change}
    with pytest.raises(error, match=message):
        fit_similarity(**given)
