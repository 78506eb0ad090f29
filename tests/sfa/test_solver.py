"""Slow features solve what the definition says (thesis 3.2), whatever the data."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.data import Edges
from andante.errors import ArrayError, ConfigError, LearningError
from andante.sfa import PCA, AffineModel, Moments, SlowModel, solve_slow


def series(rng, n=400, dim=6):
    """A mixture of sources from slow to fast."""
    t = np.arange(n)[:, None]
    sources = np.sin(t * 0.02 * 1.7 ** np.arange(dim) + np.arange(dim)) + 0.1 * rng.normal(size=(n, dim))
    return sources @ rng.normal(size=(dim, dim)) + rng.normal(size=dim) * 10


def in_time(n):
    return Edges.between(np.arange(n - 1), np.arange(1, n))


def deltas_by_definition(y, edges):
    squares = (y[edges.second] - y[edges.first]) ** 2
    return (squares * edges.weight[:, None]).sum(axis=0) / edges.weight.sum()


def random_edges(rng, n, m):
    return Edges(rng.integers(0, n, m), rng.integers(0, n, m), rng.uniform(0.1, 3, m))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000), dim=st.integers(1, 8), graph=st.booleans())
def test_outputs_obey_the_constraints_and_deltas_the_definition(seed, dim, graph):
    rng = np.random.default_rng(seed)
    x = series(rng, 300, dim)
    edges = random_edges(rng, 300, 900) if graph else in_time(300)
    model = solve_slow(Moments.of(x, edges))
    y = model.transform(x)
    np.testing.assert_allclose(y.mean(axis=0), 0, atol=1e-8)
    np.testing.assert_allclose(y.T @ y / len(y), np.eye(dim), atol=1e-8)
    # Outputs of nearly the same slowness turn into each other by rounding: 2e-9 for one in some hundred random series.
    np.testing.assert_allclose(deltas_by_definition(y, edges), model.deltas, rtol=1e-7)
    assert (np.diff(model.deltas) >= -1e-12).all()


def test_no_linear_output_is_slower_than_the_first():
    rng = np.random.default_rng(1)
    x = series(rng)
    model = solve_slow(Moments.of(x, in_time(400)), 2)
    y = (x - x.mean(axis=0)) @ rng.normal(size=(6, 5000))
    assert (deltas_by_definition(y / y.std(axis=0), in_time(400)) > model.deltas[0]).all()


def test_solution_agrees_with_whitening_and_two_eigendecompositions():
    """The algorithm as thesis 3.3 lists it: sphere, differentiate, smallest components."""
    x = series(np.random.default_rng(2))
    values, vectors = np.linalg.eigh(np.cov(x.T, bias=True))
    sphered = (x - x.mean(axis=0)) @ vectors / np.sqrt(values)
    steps = np.diff(sphered, axis=0)
    deltas, directions = np.linalg.eigh(steps.T @ steps / len(steps))
    model = solve_slow(Moments.of(x, in_time(400)), 3)
    np.testing.assert_allclose(model.deltas, deltas[:3], rtol=1e-9)
    np.testing.assert_allclose(np.abs(model.transform(x)), np.abs(sphered @ directions[:, :3]), atol=1e-8)


def test_the_scale_offset_and_mixture_of_signals_do_not_matter():
    rng = np.random.default_rng(3)
    x, edges = series(rng), in_time(400)
    plain = solve_slow(Moments.of(x, edges), 4)
    scaled = solve_slow(Moments.of(x * 10.0 ** np.arange(-6, 6, 2) + 5, edges), 4)
    mixed = solve_slow(Moments.of(x @ rng.normal(size=(6, 6)), edges), 4)
    np.testing.assert_allclose(scaled.deltas, plain.deltas, rtol=1e-8)
    np.testing.assert_allclose(mixed.deltas, plain.deltas, rtol=1e-8)
    assert scaled.rank == 6


def test_deltas_are_0_for_a_constant_along_edges_and_2_for_noise():
    rng = np.random.default_rng(4)
    group = np.repeat([0.0, 1.0], 5000)
    x = np.column_stack([rng.normal(size=10_000), group])
    edges = Edges.between(rng.integers(0, 5000, 20_000), rng.integers(0, 5000, 20_000))
    model = solve_slow(Moments.of(x, Edges.joined([edges, edges.shifted(5000)])))
    assert model.deltas[0] < 1e-3
    assert model.deltas[1] == pytest.approx(2, abs=0.05)


def test_copies_and_constants_are_dropped_and_reported():
    rng = np.random.default_rng(5)
    x = series(rng, dim=4)
    redundant = np.column_stack([np.full(400, 0.1), x, x[:, 0], x @ rng.normal(size=(4, 3))])
    model = solve_slow(Moments.of(redundant, in_time(400)))
    assert (model.rank, model.dropped, model.output_dim) == (4, 5, 4)
    np.testing.assert_allclose(model.deltas, solve_slow(Moments.of(x, in_time(400))).deltas, rtol=1e-8)
    assert (model.weights[0] == 0).all()


def test_rank_tolerance_is_what_counts():
    rng = np.random.default_rng(6)
    x = series(rng, dim=2)
    nearly = np.column_stack([x, x[:, 0] + 1e-4 * rng.normal(size=400)])
    moments = Moments.of(nearly, in_time(400))
    assert solve_slow(moments).rank == 3
    assert solve_slow(moments, rank_tolerance=1e-6).rank == 2


def test_signs_are_canonical():
    rng = np.random.default_rng(7)
    x = series(rng)
    weights = solve_slow(Moments.of(x, in_time(400))).weights
    assert (weights[np.abs(weights).argmax(axis=0), np.arange(6)] > 0).all()
    backwards = solve_slow(Moments.of(x[::-1], in_time(400))).weights
    np.testing.assert_allclose(weights, backwards, rtol=1e-6, atol=1e-8)


def test_ridge_is_white_noise_on_the_samples():
    rng = np.random.default_rng(8)
    x, edges, ridge = series(rng, 300, 3), in_time(300), 0.3
    moments = Moments.of(x, edges)
    model = solve_slow(moments, 3, ridge=ridge)
    noise = np.sqrt(ridge * np.trace(moments.covariance) / 3)
    noisy = Moments.empty(3)
    for _ in range(3000):
        noisy.add_series(x + noise * rng.normal(size=x.shape))
    expected = solve_slow(noisy, 3).weights
    for k in range(3):
        cosine = model.weights[:, k] @ expected[:, k]
        cosine /= np.linalg.norm(model.weights[:, k]) * np.linalg.norm(expected[:, k])
        assert abs(cosine) > 0.999


def test_ridge_keeps_unit_variance_and_true_deltas_and_shuns_empty_directions():
    rng = np.random.default_rng(9)
    x, edges = series(rng, 60, 4), in_time(60)
    x = np.column_stack([x, 1e-4 * rng.normal(size=(60, 50))])
    model = solve_slow(Moments.of(x, edges), 4, ridge=1e-2)
    y = model.transform(x)
    np.testing.assert_allclose(y.var(axis=0), 1, rtol=1e-9)
    np.testing.assert_allclose(deltas_by_definition(y, edges), model.deltas, rtol=1e-8)
    fitted_to_noise = solve_slow(Moments.of(x, edges), 4)
    # Without a ridge 50 small noises can be combined to something slow; with it the slowest outputs ignore them.
    assert np.abs(fitted_to_noise.weights[4:, :2]).max() > 10
    assert np.abs(model.weights[4:, :2]).max() < 0.1


def test_learning_behind_a_pca_is_one_affine_model():
    rng = np.random.default_rng(10)
    x, edges = series(rng, 300, 8), in_time(300)
    moments = Moments.of(x, edges)
    pca = PCA.of(moments, 5)
    inner = solve_slow(pca.project(moments), 3)
    composed = inner.after(pca)
    assert (composed.input_dim, composed.output_dim, composed.dropped) == (8, 3, 3)
    np.testing.assert_allclose(composed.transform(x), inner.transform(pca.transform(x)), atol=1e-9)
    again = solve_slow(Moments.of(pca.transform(x), edges), 3)
    np.testing.assert_allclose(again.transform(pca.transform(x)), composed.transform(x), atol=1e-7)
    with pytest.raises(ArrayError, match="8 signals cannot follow a PCA to 5 components"):
        composed.after(pca)


def test_model_round_trips_through_arrays():
    model = solve_slow(Moments.of(series(np.random.default_rng(11)), in_time(400)), 3)
    assert isinstance(model, SlowModel)
    again = AffineModel.from_arrays(model.to_arrays())
    x = np.random.default_rng(0).normal(size=(5, 6)).astype(np.float32)
    np.testing.assert_array_equal(again.transform(x), model.transform(x))
    assert again.rank == model.rank
    assert model.transform(x).dtype == np.float64
    with pytest.raises(ArrayError, match="AffineModel lacks the stored arrays mean, weights"):
        AffineModel.from_arrays({})
    with pytest.raises(ArrayError, match="got shapes"):
        AffineModel.from_arrays(model.to_arrays() | {"deltas": np.zeros(9)})
    with pytest.raises(ArrayError, match="X has 5 features, but AffineModel is expecting 6"):
        model.transform(np.zeros((1, 5)))


def test_faults_are_named():
    rng = np.random.default_rng(12)
    moments = Moments.of(series(rng), in_time(400))
    with pytest.raises(ConfigError, match="n_components=0"):
        solve_slow(moments, 0)
    for ridge in (-1.0, np.nan, np.inf):
        with pytest.raises(ConfigError, match="ridge="):
            solve_slow(moments, 1, ridge=ridge)
    with pytest.raises(ConfigError, match="rank_tolerance=1"):
        solve_slow(moments, 1, rank_tolerance=1.0)
    with pytest.raises(LearningError, match=r"n_samples=0: slow features need at least 2"):
        solve_slow(Moments.empty(3), 1)
    with pytest.raises(LearningError, match="there are no edges"):
        solve_slow(Moments.of(series(rng)), 1)
    with pytest.raises(LearningError, match=r"none of the 2 signals varies over the 5 samples"):
        solve_slow(Moments.of(np.ones((5, 2)), in_time(5)), 1)
    few = rng.normal(size=(10, 30))
    with pytest.raises(LearningError, match=r"cannot learn 20 .*10 samples of 30 signals .*only 9 .*ask for at most 9"):
        solve_slow(Moments.of(few, in_time(10)), 20)
    with pytest.raises(LearningError, match="cannot learn 7 slow features"):
        solve_slow(moments, 7)
