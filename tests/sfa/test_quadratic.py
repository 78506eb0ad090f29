"""Expansion, and slow features of it (thesis 5.1.1)."""

import warnings

import numpy as np
import pytest

from andante.data import Edges
from andante.errors import ArrayError, LearningError, NotFittedError
from andante.sfa import (
    PCA,
    LinearSFA,
    Moments,
    QuadraticModel,
    QuadraticSFA,
    SlowModel,
    expand_quadratic,
    expanded_dim,
    term_names,
)


def series(seed, n=600, dim=8):
    rng = np.random.default_rng(seed)
    t = np.arange(n)[:, None]
    sources = np.sin(t * 0.011 * 1.9 ** np.arange(dim) + np.arange(dim)) + 0.05 * rng.normal(size=(n, dim))
    return sources @ rng.normal(size=(dim, dim))


def test_expansion_has_the_terms_that_it_names():
    assert expanded_dim(20) == 230
    x = np.random.default_rng(0).normal(size=(7, 4))
    terms, names = expand_quadratic(x.astype(np.float32)), term_names(4)
    assert terms.shape == (7, expanded_dim(4)) == (7, len(names))
    assert terms.dtype == np.float64
    assert names[:6] == ["x0", "x1", "x2", "x3", "x0*x0", "x0*x1"]
    for column, name in zip(expand_quadratic(x).T, names, strict=True):
        factors = [x[:, int(factor[1:])] for factor in name.split("*")]
        np.testing.assert_array_equal(column, np.prod(factors, axis=0))


def test_a_slow_product_of_fast_signals_is_found():
    """Linear combinations cannot find it: sin^2 + cos^2 of a modulated carrier."""
    t = np.arange(4000)
    envelope = 2 + np.sin(0.004 * t)
    x = np.column_stack([envelope * np.sin(1.1 * t), envelope * np.cos(1.1 * t)])
    outputs = QuadraticSFA(1, reduced_dim=2).fit_transform(x)
    assert abs(np.corrcoef(outputs[:, 0], envelope**2)[0, 1]) > 0.999
    assert LinearSFA(1).fit(x).deltas_[0] > 0.5


@pytest.mark.parametrize("graph", [False, True])
def test_it_is_two_linear_analyses_around_an_expansion(graph):
    x, rng = series(1), np.random.default_rng(1)
    edges = Edges.between(rng.integers(0, 600, 3000), rng.integers(0, 600, 3000)) if graph else None
    first = LinearSFA(5).fit(x, edges=edges)
    second = LinearSFA(3).fit(expand_quadratic(first.transform(x)), edges=edges)
    quadratic = QuadraticSFA(3, reduced_dim=5).fit(x, edges=edges)
    np.testing.assert_allclose(quadratic.deltas_, second.deltas_, rtol=1e-9)
    np.testing.assert_allclose(
        quadratic.transform(x), second.transform(expand_quadratic(first.transform(x))), atol=1e-9
    )


def test_outputs_obey_the_constraints_over_episodes():
    episodes = [series(2)[:350], series(2)[350:]]
    quadratic = QuadraticSFA(4, reduced_dim=5).fit(episodes)
    y = quadratic.transform(episodes)
    np.testing.assert_allclose(y.T @ y / 600, np.eye(4), atol=1e-7)
    steps = np.concatenate([np.diff(y[:350], axis=0), np.diff(y[350:], axis=0)])
    np.testing.assert_allclose((steps**2).mean(axis=0), quadratic.deltas_, rtol=1e-8)


def test_a_pca_in_front_becomes_part_of_the_model():
    x = series(3)
    pca = PCA.of(Moments.of(x), 6)
    inner = QuadraticSFA(3, reduced_dim=4).fit(pca.transform(x)).model_
    model = inner.after(pca)
    assert (model.input_dim, model.output_dim) == (8, 3)
    np.testing.assert_allclose(model.transform(x), inner.transform(pca.transform(x)), atol=1e-9)


def test_model_round_trips_through_arrays():
    x = series(4)
    model = QuadraticSFA(3, reduced_dim=4).fit(x).model_
    assert isinstance(model, SlowModel)
    arrays = model.to_arrays()
    assert {"reduce.mean", "reduce.weights", "slow.weights", "slow.deltas"} <= set(arrays)
    again = QuadraticModel.from_arrays(arrays)
    np.testing.assert_array_equal(again.transform(x), model.transform(x))
    np.testing.assert_array_equal(again.deltas, model.deltas)


def test_faults_are_named():
    x = series(5)
    with pytest.raises(LearningError, match="cannot learn 20 slow features: 600 samples of 8 signals"):
        QuadraticSFA().fit(x)
    with pytest.raises(NotFittedError, match="this QuadraticSFA has not learnt yet"):
        QuadraticSFA().transform(x)
    model = QuadraticSFA(3, reduced_dim=4).fit(x).model_
    with pytest.raises(ArrayError, match="4 reduced signals has 14 terms, but its second stage takes 8"):
        QuadraticModel(model.reduce, model.reduce)


def test_scikit_learn_accepts_the_estimator():
    checks = pytest.importorskip("sklearn.utils.estimator_checks")
    with warnings.catch_warnings():
        warnings.filterwarnings("ignore", message=".*does not inherit from.*BaseEstimator", category=UserWarning)
        # The checks hand in series of one or two signals, which have no 20 slow directions.
        checks.check_estimator(QuadraticSFA(1, reduced_dim=1), on_skip=None)
