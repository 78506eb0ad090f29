"""Clusters of particles."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.localization.clusters import MAX_CLUSTERS, clusters_of, weighted_radius


def blob(rng, x, y, n, sigma=0.1, heading=0.0):
    return np.column_stack([rng.normal([x, y], sigma, (n, 2)), rng.normal(heading, 0.1, n)])


def test_two_places_are_two_clusters_with_their_moments():
    rng = np.random.default_rng(0)
    pose = np.vstack([blob(rng, 0, 0, 300, heading=np.pi), blob(rng, 4, 0, 100)])
    pose[:, 2] = np.remainder(pose[:, 2] + np.pi, 2 * np.pi) - np.pi
    first, second = clusters_of(pose, np.full(400, 1 / 400), 0.5)
    assert (first.share, second.share) == pytest.approx((0.75, 0.25))
    assert first.member.tolist() == [True] * 300 + [False] * 100
    assert first.mean[:2] == pytest.approx(pose[:300, :2].mean(axis=0))
    assert abs(first.mean[2]) == pytest.approx(np.pi, abs=0.03)  # across the seam of headings
    assert first.covariance[:2, :2] == pytest.approx(np.cov(pose[:300, :2].T, bias=True))
    assert first.covariance[2, 2] == pytest.approx(0.01, rel=0.3)


def test_a_wide_cloud_is_one_cluster_and_dust_joins_nothing():
    rng = np.random.default_rng(0)
    wide = np.column_stack([rng.uniform(0, 3, (800, 2)), np.zeros(800)])
    assert clusters_of(wide, np.full(800, 1 / 800), 0.5)[0].share > 0.99
    bridge = np.column_stack([np.linspace(0, 4, 20), np.zeros(20), np.zeros(20)])
    pose = np.vstack([blob(rng, 0, 0, 50), blob(rng, 4, 0, 50), bridge])
    weight = np.array([1.0] * 100 + [1e-6] * 20)
    assert len(clusters_of(pose, weight / weight.sum(), 0.5)) == 2


@given(st.integers(1, 60), st.integers(0, 100), st.floats(0.01, 1e6))
def test_shares_fall_and_are_no_more_than_all(n, seed, spread):
    rng = np.random.default_rng(seed)
    pose, weight = rng.normal(0, spread, (n, 3)), rng.random(n) + 1e-9
    clusters = clusters_of(pose, weight / weight.sum(), 0.5)
    shares = [one.share for one in clusters]
    assert 1 <= len(clusters) <= MAX_CLUSTERS
    assert shares == sorted(shares, reverse=True)
    assert sum(shares) <= 1 + 1e-9
    assert all(np.isfinite(one.mean).all() for one in clusters)


def test_the_radius_holds_its_share_of_the_weight():
    rng = np.random.default_rng(0)
    xy, weight = rng.normal(size=(2000, 2)), rng.random(2000)
    radius = weighted_radius(xy, weight, np.zeros(2))
    assert weight[np.hypot(*xy.T) <= radius].sum() / weight.sum() == pytest.approx(0.9, abs=0.002)
    assert radius == pytest.approx(2.146, rel=0.05)
