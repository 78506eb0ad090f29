"""Principal components: both ways round give the same."""

import numpy as np
import pytest

from andante.errors import ArrayError, ConfigError, LearningError
from andante.sfa import PCA, Moments, pca_of_samples


def spread_samples(rng, n, dim, dtype=np.float64):
    scale = 0.8 ** np.arange(min(n, dim))
    x = rng.normal(size=(n, len(scale))) * scale @ np.linalg.qr(rng.normal(size=(dim, len(scale))))[0].T
    return (x + rng.normal(size=dim)).astype(dtype)


@pytest.mark.parametrize(("n", "dim"), [(200, 12), (15, 40), (12, 12)])
def test_components_are_those_of_the_covariance(n, dim):
    x = spread_samples(np.random.default_rng(0), n, dim)
    pca = pca_of_samples(x, 8)
    values = np.linalg.eigvalsh(np.cov(x.T, bias=True))[::-1]
    np.testing.assert_allclose(pca.variances, values[:8], rtol=1e-9)
    np.testing.assert_allclose(pca.components.T @ pca.components, np.eye(8), atol=1e-12)
    y = pca.transform(x)
    np.testing.assert_allclose(y.mean(axis=0), 0, atol=1e-12)
    np.testing.assert_allclose(np.cov(y.T, bias=True), np.diag(pca.variances), atol=1e-12)
    assert pca.explained == pytest.approx(values[:8].sum() / values.sum())


@pytest.mark.parametrize("k", [3, 14, 100])
def test_dual_form_gives_the_same_components_and_signs(k):
    x = spread_samples(np.random.default_rng(1), 15, 40)
    dual, primal = pca_of_samples(x, k), PCA.of(Moments.of(x), k)
    assert dual.output_dim == primal.output_dim == min(k, 14)
    np.testing.assert_allclose(dual.components, primal.components, atol=1e-7)
    np.testing.assert_allclose(dual.variances, primal.variances, rtol=1e-9)
    np.testing.assert_allclose(dual.mean, primal.mean)
    assert dual.explained == pytest.approx(primal.explained)


def test_signs_are_canonical_even_where_entries_tie():
    x = np.array([[1.0, -1.0], [-1.0, 1.0], [0.1, 0.1], [-0.1, -0.1]])
    rng = np.random.default_rng(2)
    for _ in range(20):
        pca = pca_of_samples(rng.permutation(x) * (1 + 1e-13 * rng.normal(size=(4, 2))), 2)
        np.testing.assert_allclose(pca.components, np.array([[1, 1], [-1, 1]]) / np.sqrt(2), atol=1e-9)


def test_rank_is_cut_by_a_stated_share():
    rng = np.random.default_rng(3)
    x = rng.normal(size=(100, 4)) * [1, 1e-2, 1e-4, 0]
    assert pca_of_samples(x, 4).output_dim == 3
    assert pca_of_samples(x, 4, rank_tolerance=1e-6).output_dim == 2


def test_float32_far_from_zero():
    x = spread_samples(np.random.default_rng(4), 20, 50) + 1000
    exact, rounded = pca_of_samples(x, 5), pca_of_samples(x.astype(np.float32), 5)
    np.testing.assert_allclose(rounded.variances, exact.variances, rtol=1e-4)


def test_arrays_round_trip():
    pca = pca_of_samples(np.random.default_rng(5).normal(size=(30, 6)), 3)
    again = PCA.from_arrays(pca.to_arrays())
    for name, array in pca.to_arrays().items():
        np.testing.assert_array_equal(array, again.to_arrays()[name])
        assert array.flags.c_contiguous


@pytest.mark.parametrize("shape", [(5, 3), (3, 5)])
def test_faults_are_named(shape):
    with pytest.raises(LearningError, match="all samples are the same"):
        pca_of_samples(np.full(shape, 0.1), 1)
    with pytest.raises(ConfigError, match="n_components=0"):
        pca_of_samples(np.random.default_rng(0).normal(size=shape), 0)
    pca = pca_of_samples(np.random.default_rng(0).normal(size=shape), 2)
    with pytest.raises(ArrayError, match=r"X has 9 features, but PCA is expecting \d features"):
        pca.transform(np.zeros((2, 9)))
    arrays = pca.to_arrays()
    with pytest.raises(ArrayError, match="PCA lacks the stored arrays mean, variances"):
        PCA.from_arrays({key: arrays[key] for key in ("components", "total_variance", "rank_tolerance")})
    with pytest.raises(ArrayError, match="got shapes"):
        PCA.from_arrays(arrays | {"mean": np.zeros(9)})
