"""Sums over places: against a brute-force loop over all edges, merged, and taken apart again."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.errors import ArrayError, ConfigError, LearningError
from andante.sfa import PlaceMoments, solve_slow
from andante.sfa.moments import Moments


def data(n: int, d: int = 4, places: int = 7, seed: int = 0, offset: float = 0.0):
    rng = np.random.default_rng(seed)
    place = rng.integers(-places, places, (n, 2))
    return rng.normal(size=(n, d)) + offset + 0.3 * place[:, :1], place


def brute_force(x, place, beta):
    """E by its definition: neighbouring places through their means, then every frame against the mean of its place."""
    cells = sorted({tuple(cell) for cell in place.tolist()})
    mean = {cell: x[(place == cell).all(axis=1)].mean(axis=0) for cell in cells}
    total, weights = np.zeros((x.shape[1], x.shape[1])), 0.0
    for one in cells:
        for other in cells:
            apart = np.hypot(one[0] - other[0], one[1] - other[1])
            if one < other and apart <= 1.5:
                step, weight = mean[other] - mean[one], np.exp(-(apart**2) / 2)
                total += weight * np.outer(step, step)
                weights += weight
    rest = x - np.array([mean[tuple(cell)] for cell in place.tolist()])
    return total / weights + beta * rest.T @ rest / len(x)


def same(one: PlaceMoments, other: PlaceMoments, tolerance: float = 1e-10) -> None:
    np.testing.assert_array_equal(one.place, other.place)
    np.testing.assert_array_equal(one.count, other.count)
    np.testing.assert_allclose(one.mean, other.mean, atol=tolerance)
    np.testing.assert_allclose(one.within, other.within, atol=tolerance * max(1, np.abs(other.within).max()))


@pytest.mark.parametrize("beta", [0.0, 1.0, 7.5])
def test_edges_are_those_of_the_definition(beta):
    x, place = data(300)
    moments = PlaceMoments.of(x, place).moments(beta)
    np.testing.assert_allclose(moments.edge_covariance, brute_force(x, place, beta), atol=1e-11)
    np.testing.assert_allclose(moments.covariance, np.cov(x.T, bias=True), atol=1e-11)
    np.testing.assert_allclose(moments.mean, x.mean(axis=0), atol=1e-12)


def test_within_is_half_the_mean_of_all_pairs_of_a_place():
    """Theory 2: the clique of a place over ordered pairs is 2 n S - 2 m m^T, that is 2 n times its scatter."""
    x, place = data(40, places=2)
    pairs = np.zeros((4, 4))
    for cell in np.unique(place, axis=0):
        inside = x[(place == cell).all(axis=1)]
        for one in inside:
            for other in inside:
                pairs += np.outer(other - one, other - one) / (2 * len(inside))
    np.testing.assert_allclose(PlaceMoments.of(x, place).within, pairs, atol=1e-11)


@settings(max_examples=40, deadline=None)
@given(st.lists(st.integers(0, 30), min_size=2, max_size=5), st.integers(0, 1000))
def test_parts_merge_to_the_whole_and_come_out_again(sizes, seed):
    x, place = data(sum(sizes) + 2, seed=seed, offset=50.0)
    cuts = np.cumsum([sizes[0] + 1, *sizes[1:]])
    parts = [PlaceMoments.of(*pair) for pair in zip(np.split(x, cuts[:-1]), np.split(place, cuts[:-1]), strict=True)]
    whole = PlaceMoments.of(x, place)
    same(PlaceMoments.joined(parts), whole)
    same(PlaceMoments.joined(parts[::-1]), whole)
    same(whole.without(parts[0]), PlaceMoments.joined(parts[1:]), 1e-9)


def test_far_from_zero_no_digits_are_lost():
    x, place = data(400, seed=3)
    near, far = PlaceMoments.of(x, place), PlaceMoments.of(x + 1e6, place)
    np.testing.assert_allclose(far.within, near.within, rtol=1e-7, atol=1e-6)


def test_merging_is_learning_from_all_at_once():
    x, place = data(500, d=6)
    whole = solve_slow(PlaceMoments.of(x, place).moments(2.0), 3)
    halves = PlaceMoments.of(x[:200], place[:200]).merge(PlaceMoments.of(x[200:], place[200:]))
    np.testing.assert_allclose(solve_slow(halves.moments(2.0), 3).weights, whole.weights, atol=1e-9)


def test_a_large_beta_ignores_what_differs_between_visits():
    """Two conditions as an offset along one axis: with beta the slow feature is blind to it."""
    rng = np.random.default_rng(5)
    along = np.repeat(np.arange(50), 2)
    condition = np.tile([-1.0, 1.0], 50)
    x = np.column_stack([np.sin(along / 8) + 0.05 * rng.normal(size=100), 3 * condition, rng.normal(size=100)])
    moments = PlaceMoments.of(x, along[:, None]).moments(100.0)
    slow = solve_slow(moments, 1).transform(x)[:, 0]
    assert abs(np.corrcoef(slow, condition)[0, 1]) < 0.05
    assert abs(np.corrcoef(slow, np.sin(along / 8))[0, 1]) > 0.95


def test_density_correction_makes_dwelling_harmless():
    x, place = data(300, places=4)
    stand = np.repeat(x[:1], 400, axis=0) + 1e-3 * np.random.default_rng(1).normal(size=(400, 4))
    dwelt = PlaceMoments.of(np.concatenate([x, stand]), np.concatenate([place, np.repeat(place[:1], 400, axis=0)]))
    plain = PlaceMoments.of(x, place).moments(density_corrected=True).mean
    assert np.abs(dwelt.moments(density_corrected=True).mean - plain).max() < 0.1
    assert np.abs(dwelt.moments().mean - plain).max() > 0.5


def test_the_result_fits_plain_moments():
    x, place = data(100)
    moments = PlaceMoments.of(x, place).moments()
    assert isinstance(moments, Moments)
    assert moments.n_samples == 100
    assert moments.dim == 4


def test_nothing_belongs_together():
    x, _ = data(3)
    alone = PlaceMoments.of(x, np.array([[0, 0], [10, 0], [20, 0]]))
    with pytest.raises(LearningError, match=r"no two of the 3 frames belong together"):
        alone.moments()


def test_faults_have_messages():
    x, place = data(10)
    with pytest.raises(ArrayError, match=r"one whole-numbered cell each"):
        PlaceMoments.of(x, place[:-1])
    with pytest.raises(ArrayError, match=r"one whole-numbered cell each"):
        PlaceMoments.of(x, place + 0.5)
    with pytest.raises(ArrayError, match="NaN"):
        PlaceMoments.of(np.where(x > 1, np.nan, x), place)
    with pytest.raises(ArrayError, match=r"moments of 4 signals .* do not fit those of 3"):
        PlaceMoments.of(x, place).merge(PlaceMoments.of(x[:, :3], place))
    with pytest.raises(ConfigError, match=r"beta=-1"):
        PlaceMoments.of(x, place).moments(-1.0)
    with pytest.raises(LearningError, match=r"part of"):
        PlaceMoments.of(x[:2], place[:2]).without(PlaceMoments.of(x, place))
