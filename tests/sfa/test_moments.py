"""Moments against the textbook sums, in any pieces and any order."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.data import Edges
from andante.errors import ArrayError, LearningError
from andante.sfa import PCA, Moments


def slow_moments(x, edges, weight=None):
    """The definition, one sample and one edge at a time."""
    weight = np.ones(len(x)) if weight is None else weight
    mean = sum(w * row for w, row in zip(weight, x, strict=True)) / weight.sum()
    scatter = sum(w * np.outer(row - mean, row - mean) for w, row in zip(weight, x, strict=True))
    edge_scatter = np.zeros_like(scatter)
    for i, j, w in zip(edges.first, edges.second, edges.weight, strict=True):
        edge_scatter += w * np.outer(x[j] - x[i], x[j] - x[i])
    return mean, scatter / weight.sum(), edge_scatter / edges.weight.sum()


def assert_same(a, b, tolerance=1e-9):
    scale = np.abs(a.covariance).max()
    np.testing.assert_allclose(a.mean, b.mean, rtol=tolerance, atol=tolerance)
    np.testing.assert_allclose(a.covariance, b.covariance, rtol=tolerance, atol=tolerance * scale)
    assert (a.n_samples, a.n_edges) == (b.n_samples, b.n_edges)
    assert a.count == pytest.approx(b.count)
    assert a.edge_count == pytest.approx(b.edge_count)
    if a.n_edges:
        scale = np.abs(a.edge_covariance).max()
        np.testing.assert_allclose(a.edge_covariance, b.edge_covariance, rtol=tolerance, atol=tolerance * scale)


def random_edges(rng, n, m):
    return Edges(rng.integers(0, n, m), rng.integers(0, n, m), rng.uniform(0.1, 3, m))


@pytest.mark.parametrize("m", [5, 30, 400], ids=["few edges", "as differences", "as a Laplacian"])
def test_moments_are_the_definition(m):
    rng = np.random.default_rng(1)
    x, edges, weight = rng.normal(3, 2, (40, 4)), random_edges(rng, 40, m), rng.uniform(0, 2, 40)
    moments = Moments.of(x, edges, weight)
    mean, covariance, edge_covariance = slow_moments(x, edges, weight)
    np.testing.assert_allclose(moments.mean, mean, rtol=1e-12)
    np.testing.assert_allclose(moments.covariance, covariance, rtol=1e-12, atol=1e-12)
    np.testing.assert_allclose(moments.edge_covariance, edge_covariance, rtol=1e-12, atol=1e-12)
    assert (moments.n_samples, moments.n_edges) == (40, m)


@settings(max_examples=40, deadline=None)
@given(
    seed=st.integers(0, 1000),
    n=st.integers(2, 60),
    cuts=st.lists(st.integers(1, 59), max_size=6),
    offset=st.sampled_from([0.0, 1.0, -1000.0]),
)
def test_one_series_in_any_pieces_and_merged_parts_are_one(seed, n, cuts, offset):
    rng = np.random.default_rng(seed)
    x = rng.normal(offset, 1.0, (n, 3)).cumsum(axis=0)
    whole = Moments.empty(3)
    whole.add_series(x)
    bounds = [0, *sorted({cut for cut in cuts if cut < n}), n]
    pieces = [x[a:b] for a, b in pairwise(bounds)]
    streamed, merged = Moments.empty(3), Moments.empty(3)
    for number, piece in enumerate(pieces):
        part = Moments.empty(3)
        if number:
            seam = piece[:1] - pieces[number - 1][-1:]
            streamed.add_differences(seam, np.ones(1))
            part.add_differences(seam, np.ones(1))
        streamed.add_series(piece)
        part.add_series(piece)
        merged = part.merge(merged)
    assert_same(whole, streamed)
    assert_same(whole, merged)


@settings(max_examples=30, deadline=None)
@given(seed=st.integers(0, 1000), n=st.integers(2, 40), split=st.integers(0, 40))
def test_weighted_moments_merge_and_a_weight_counts_repetitions(seed, n, split):
    rng = np.random.default_rng(seed)
    x, weight = rng.normal(5, 1, (n, 2)), rng.integers(0, 4, n).astype(float) + (np.arange(n) == 0)
    split = min(split, n)
    merged = Moments.of(x[:split], None, weight[:split]).merge(Moments.of(x[split:], None, weight[split:]))
    assert_same(Moments.of(x, None, weight), merged)
    repeated = Moments.of(np.repeat(x, weight.astype(int), axis=0))
    np.testing.assert_allclose(repeated.covariance, merged.covariance, rtol=1e-9, atol=1e-9)


def test_blocks_do_not_show(monkeypatch):
    rng = np.random.default_rng(3)
    x, edges, weight = rng.normal(size=(100, 5)), random_edges(rng, 100, 90), rng.uniform(0, 1, 100)
    whole = Moments.of(x, edges, weight)
    monkeypatch.setitem(Moments.of.__globals__, "_BLOCK_VALUES", 35)
    assert_same(whole, Moments.of(x, edges, weight), 1e-12)


def test_float32_far_from_zero_loses_no_digits():
    rng = np.random.default_rng(4)
    x32 = (1000 + rng.normal(size=(2000, 6))).astype(np.float32)
    x64 = x32.astype(np.float64)
    moments = Moments.empty(6)
    for start in range(0, 2000, 37):
        moments = moments.merge(Moments.of(x32[start : start + 37], random_edges(rng, 1, 1)))
    np.testing.assert_allclose(moments.covariance, np.cov(x64.T, bias=True), rtol=1e-9, atol=1e-12)
    for m in (1500, 9000):
        edges = random_edges(rng, 2000, m)
        dx = x64[edges.second] - x64[edges.first]
        exact = (dx * edges.weight[:, None]).T @ dx / edges.weight.sum()
        np.testing.assert_allclose(Moments.of(x32, edges).edge_covariance, exact, rtol=1e-9, atol=1e-11)


def test_a_signal_that_never_changes_has_exactly_no_variance():
    x = np.column_stack([np.full(10_000, 0.1), np.arange(10_000.0)])
    moments = Moments.empty(2)
    for start in range(0, 10_000, 777):
        moments.add_series(x[start : start + 777])
    assert moments.covariance[0].tolist() == [0.0, 0.0]
    assert moments.edge_covariance[0].tolist() == [0.0, 0.0]


def test_merge_leaves_its_operands_alone():
    rng = np.random.default_rng(5)
    a, b = Moments.of(rng.normal(size=(9, 2))), Moments.of(rng.normal(size=(7, 2)))
    before = a.copy()
    merged = a.merge(b)
    merged.add_samples(rng.normal(size=(3, 2)))
    assert_same(a, before, 0)
    assert_same(Moments.empty(2).merge(a), a, 0)


def test_projected_moments_are_those_of_projected_samples():
    rng = np.random.default_rng(6)
    x, edges, basis = rng.normal(7, 1, (50, 6)), random_edges(rng, 50, 200), rng.normal(size=(6, 3))
    moments = Moments.of(x, edges)
    assert_same(moments.projected(basis), Moments.of((x - x.mean(axis=0)) @ basis, edges))
    origin = rng.normal(size=6)
    assert_same(moments.projected(basis, origin), Moments.of((x - origin) @ basis, edges))
    pca = PCA.of(Moments.of(x[:20]), 4)
    assert_same(pca.project(moments), Moments.of(pca.transform(x), edges))


def test_moments_without_data_say_so():
    with pytest.raises(LearningError, match="covariance of 0 samples"):
        _ = Moments.empty(2).covariance
    with pytest.raises(LearningError, match="no edges"):
        _ = Moments.of(np.eye(3)).edge_covariance
    moments = Moments.of(np.eye(3), Edges.joined([]))
    assert moments.n_edges == 0


def test_faults_are_named():
    moments, x = Moments.empty(2), np.zeros((4, 2))
    with pytest.raises(ArrayError, match="X has 3 features, but Moments is expecting 2"):
        moments.add_samples(np.zeros((4, 3)))
    with pytest.raises(ArrayError, match=r"NaN or infinity in 1 of 2 rows, first in row 1"):
        moments.add_samples(np.array([[0, 1], [np.nan, 0]]))
    with pytest.raises(ArrayError, match=r"edges join samples 0\.\.4, but there are samples 0\.\.3"):
        moments.add_edges(x, Edges.between([0], [4]))
    with pytest.raises(ArrayError, match=r"edges join samples -1\.\.0"):
        moments.add_edges(x, Edges.between([0], [-1]))
    with pytest.raises(ArrayError, match="weights have to be 4 finite numbers >= 0"):
        moments.add_samples(x, np.array([1.0, 1.0, 1.0, -1.0]))
    with pytest.raises(ArrayError, match="moments of 2 and of 3 signals"):
        moments.merge(Moments.empty(3))
