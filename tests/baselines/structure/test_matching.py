import numpy as np
import pytest

from andante.baselines.structure.cloud import Cloud
from andante.baselines.structure.matching import Matcher, MatchRule


def cloud_of(descriptors: np.ndarray, image: list[int]) -> Cloud:
    n = len(descriptors)
    return Cloud(np.zeros((n, 3), np.float32), descriptors, np.array(image, np.int32), np.arange(n, dtype=np.int32))


@pytest.fixture
def descriptors() -> np.ndarray:
    return np.random.default_rng(0).integers(0, 90, (60, 128)).astype(np.uint8)


def test_every_point_is_found_again_by_its_own_descriptor(descriptors: np.ndarray) -> None:
    matcher = Matcher.of(cloud_of(descriptors, [0] * 60), MatchRule())
    order = np.random.default_rng(1).permutation(60)
    key, point = matcher.match(descriptors[order])
    np.testing.assert_array_equal(key, np.arange(60))
    np.testing.assert_array_equal(point, order)


def test_a_point_that_looks_like_another_is_told_where_the_other_cannot_be_seen(descriptors: np.ndarray) -> None:
    twice = np.concatenate([descriptors, descriptors[:1]])
    image = [0] * 40 + [1] * 21
    ambiguous, local = (Matcher.of(cloud_of(twice, image), MatchRule(images=n)) for n in (2, 1))
    seen = descriptors ^ 1  # nearly the same, as it is when somebody looks again
    assert 0 not in ambiguous.match(seen)[1]
    assert 0 in local.match(seen)[1]


@pytest.mark.parametrize("points", [0, 1])
def test_nothing_is_recognised_among_too_few(descriptors: np.ndarray, points: int) -> None:
    matcher = Matcher.of(cloud_of(descriptors[:points], [0] * points), MatchRule())
    key, point = matcher.match(descriptors)
    assert len(key) == len(point) == 0


def test_a_picture_without_key_points_matches_nothing(descriptors: np.ndarray) -> None:
    key, _ = Matcher.of(cloud_of(descriptors, [0] * 60), MatchRule()).match(descriptors[:0])
    assert len(key) == 0
