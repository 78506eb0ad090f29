import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.baselines import NearestNeighbours


def slow_position(features, xy, query, neighbours):
    """Inverse-distance weighting, spelt out."""
    distances = [float(np.linalg.norm(row.astype(np.float64) - query)) for row in features]
    nearest = sorted(range(len(xy)), key=lambda index: distances[index])[:neighbours]
    weights = [1 / max(distances[index], 1e-9) for index in nearest]
    return sum(w * xy[i] for w, i in zip(weights, nearest, strict=True)) / sum(weights)


@given(st.integers(0, 1000), st.integers(1, 8), st.sampled_from([0.0, 1000.0]))
def test_agrees_with_the_slow_reference(seed, neighbours, offset):
    rng = np.random.default_rng(seed)
    features = (rng.normal(size=(20, 6)) + offset).astype(np.float32)
    xy = rng.uniform(-5, 5, (20, 2))
    query = (rng.normal(size=6) + offset).astype(np.float32)
    nearest = NearestNeighbours.fit(None, "m", features, xy, neighbours)
    np.testing.assert_allclose(nearest.position(query), slow_position(features, xy, query, neighbours), atol=1e-3)


@pytest.mark.parametrize("neighbours", [1, 5])
def test_a_mapped_frame_is_found_exactly(neighbours):
    rng = np.random.default_rng(0)
    features, xy = rng.normal(size=(30, 50)).astype(np.float32), rng.uniform(size=(30, 2))
    nearest = NearestNeighbours.fit(None, "m", features, xy, neighbours)
    for row, position in zip(features, xy, strict=True):
        # Centring costs the last digits of single precision, hence not zero for five.
        np.testing.assert_allclose(nearest.position(row), position, atol=1e-6)


def test_it_uses_what_there_is_and_says_so():
    nearest = NearestNeighbours.fit(None, "m", np.eye(3, dtype=np.float32), np.arange(6.0).reshape(3, 2), 5)
    assert nearest.name == "nearest-3"
    assert nearest.position(np.ones(3, np.float32)) == pytest.approx([2, 3])
