"""Several positions become one: the formulas, and that none of them claims to know too much."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.errors import ArrayError
from andante.mapping.landmark_fusion import by_covariance, by_inverse_error, correlation_of, inflation

QUICK = settings(max_examples=60, deadline=None)


def positions(rng: np.random.Generator, count: int) -> tuple[np.ndarray, np.ndarray]:
    factors = rng.normal(size=(count, 2, 2)) * np.exp(rng.normal(size=(count, 1, 1)))
    return rng.normal(size=(count, 2)) * 3, factors @ factors.transpose(0, 2, 1) + 0.01 * np.eye(2)


def test_inverse_error_is_a_weighted_mean():
    fused = by_inverse_error(np.array([[0.0, 0.0], [3.0, 6.0]]), np.array([0.1, 0.2]))
    np.testing.assert_allclose(fused, [1.0, 2.0])


def test_independent_gaussians_multiply():
    xy, covariance = np.array([[0.0, 0.0], [1.0, 2.0]]), np.array([np.diag([1.0, 4.0]), np.diag([3.0, 4.0])])
    mean, fused = by_covariance(xy, covariance)
    np.testing.assert_allclose(mean, [0.25, 1.0])
    np.testing.assert_allclose(fused, np.diag([0.75, 2.0]))


def test_full_correlation_is_covariance_intersection_with_equal_weights():
    xy, covariance = positions(np.random.default_rng(0), 3)
    information = np.linalg.inv(covariance).mean(axis=0)
    mean, fused = by_covariance(xy, covariance, correlation=1.0)
    np.testing.assert_allclose(fused, np.linalg.inv(information))
    np.testing.assert_allclose(information @ mean, np.einsum("mij,mj->i", np.linalg.inv(covariance), xy) / 3)


@QUICK
@given(st.integers(0, 2**32), st.floats(0, 1))
def test_a_single_estimate_stays_as_it_is(seed, correlation):
    xy, covariance = positions(np.random.default_rng(seed), 1)
    mean, fused = by_covariance(xy, covariance, correlation)
    np.testing.assert_allclose(mean, xy[0])
    np.testing.assert_allclose(fused, covariance[0], rtol=1e-8)
    np.testing.assert_allclose(by_inverse_error(xy, np.array([0.3])), xy[0])


@QUICK
@given(st.integers(0, 2**32), st.integers(2, 6), st.floats(0, 1))
def test_the_order_does_not_matter(seed, count, correlation):
    rng = np.random.default_rng(seed)
    xy, covariance = positions(rng, count)
    order = rng.permutation(count)
    for one, other in zip(
        by_covariance(xy, covariance, correlation),
        by_covariance(xy[order], covariance[order], correlation),
        strict=True,
    ):
        np.testing.assert_allclose(one, other, rtol=1e-6, atol=1e-9)


@QUICK
@given(st.integers(0, 2**32), st.integers(1, 6), st.floats(0, 1))
def test_never_more_certain_than_correlated_errors_allow(seed, count, correlation):
    """Slow reference: the covariance that the weighted mean really has where errors have this correlation."""
    xy, covariance = positions(np.random.default_rng(seed), count)
    _, claimed = by_covariance(xy, covariance, correlation)
    information = np.linalg.inv(covariance)
    total = np.linalg.inv(information.sum(axis=0))
    # Symmetric roots: each landmark's errors in units of its own deviation, along the same axes.
    values, vectors = np.linalg.eigh(covariance)
    roots = np.einsum("mij,mj,mkj->mik", vectors, np.sqrt(values), vectors)
    pulls = total @ information @ roots
    real = np.einsum("mij,mkj->ik", pulls, pulls) * (1 - correlation)
    real += correlation * pulls.sum(axis=0) @ pulls.sum(axis=0).T
    assert np.linalg.eigvalsh(claimed - real).min() >= -1e-8 * np.trace(claimed)


def test_equal_landmarks_are_exactly_as_certain_as_their_correlation_says():
    _, fused = by_covariance(np.zeros((4, 2)), np.tile(np.eye(2), (4, 1, 1)), 0.2)
    np.testing.assert_allclose(fused, np.eye(2) * (1 + 3 * 0.2) / 4)
    assert inflation(4, 0.2) == pytest.approx(1.6)


@pytest.mark.parametrize("correlation", [0.0, 0.4, 0.9])
def test_correlation_is_found_in_errors(correlation):
    rng = np.random.default_rng(1)
    shared, own = rng.normal(size=(3000, 1, 2)), rng.normal(size=(3000, 3, 2))
    white = np.sqrt(correlation) * shared + np.sqrt(1 - correlation) * own
    white[rng.random((3000, 3)) < 0.3] = np.nan
    assert correlation_of(white) == pytest.approx(correlation, abs=0.05)


def test_landmarks_that_never_meet_have_no_correlation():
    white = np.full((10, 2, 2), np.nan)
    white[:5, 0] = white[5:, 1] = 1.0
    assert correlation_of(white) == 0.0
    assert correlation_of(np.full((3, 2, 2), np.nan)) == 0.0


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda: by_inverse_error(np.empty((0, 2)), np.empty(0)), r"at least one row, got \(0, 2\)"),
        (lambda: by_inverse_error(np.zeros((2, 2)), np.array([1.0, 0.0])), r"as many errors in metres above zero"),
        (lambda: by_covariance(np.zeros((2, 2)), np.eye(2)), r"need covariances \(2, 2, 2\), got shape \(2, 2\)"),
        (lambda: by_covariance(np.zeros((1, 2)), np.eye(2)[None], 1.1), r"a correlation of errors is from 0 to 1"),
    ],
)
def test_what_cannot_be_fused_is_refused(call, message):
    with pytest.raises(ArrayError, match=message):
        call()
