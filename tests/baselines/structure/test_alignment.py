import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from andante.baselines.structure.alignment import Similarity, aligned
from andante.errors import LearningError


def reconstruction(xy: np.ndarray, scale: float, seed: int = 0) -> tuple[np.ndarray, np.ndarray, Similarity]:
    """Camera centres and upward axes in an arbitrary frame, and the similarity back."""
    rotation = Rotation.random(random_state=seed).as_matrix()
    away = np.array([3.0, -2.0, 5.0])
    centres = (np.column_stack([xy, np.zeros(len(xy))]) / scale) @ rotation + away
    up = np.tile(rotation[2], (len(xy), 1))
    return centres, up, Similarity(scale, rotation, -scale * rotation @ away, len(xy))


@pytest.mark.parametrize("seed", range(5))
def test_any_similarity_is_undone_despite_wrong_positions(seed: int) -> None:
    rng = np.random.default_rng(seed)
    xy = rng.uniform(-5, 5, (40, 2))
    centres, up, truth = reconstruction(xy, 2.5, seed)
    wrong = xy.copy()
    wrong[:12] += rng.uniform(2, 5, (12, 2))
    found = aligned(centres, up, wrong, tolerance_m=0.1, rng=rng)
    points = rng.normal(size=(10, 3))
    assert found.inliers == 28
    np.testing.assert_allclose(found.points(points), truth.points(points), atol=1e-9)


def test_a_straight_way_is_enough_because_up_is_known() -> None:
    xy = np.column_stack([np.linspace(0, 8, 12), np.linspace(0, 4, 12)])
    centres, up, truth = reconstruction(xy, 0.3)
    found = aligned(centres, up, xy, tolerance_m=0.1, rng=np.random.default_rng(0))
    points = np.random.default_rng(1).normal(size=(10, 3))
    np.testing.assert_allclose(found.points(points), truth.points(points), atol=1e-9)


def test_a_reconstruction_of_something_else_is_refused() -> None:
    rng = np.random.default_rng(0)
    centres, up, _ = reconstruction(rng.uniform(-50, 50, (10, 2)), 1.0)
    with pytest.raises(
        LearningError, match=r"2 of 10 agree within 0\.001 m, at least 3 are needed; check the positions"
    ):
        aligned(centres, up, rng.uniform(-50, 50, (10, 2)), tolerance_m=0.001, rng=rng)


def test_what_lies_where_it_should_stays_there() -> None:
    points = np.random.default_rng(0).normal(size=(5, 3))
    np.testing.assert_array_equal(Similarity.identity().points(points), points)
