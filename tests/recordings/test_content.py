import numpy as np
import pytest

from andante.recordings import picture_fingerprint


@pytest.fixture
def picture():
    return np.random.default_rng(0).integers(0, 256, (480, 640), dtype=np.uint8)


def test_a_picture_is_known_by_its_pixels_alone(picture):
    assert picture_fingerprint(picture) == picture_fingerprint(np.asfortranarray(picture))
    assert len(picture_fingerprint(picture)) == 16


def test_noise_of_one_grey_level_makes_another_picture(picture):
    assert picture_fingerprint(picture) != picture_fingerprint(picture ^ 1)


@pytest.mark.parametrize("shape", [(1, 1), (3, 500), (480, 641), (480, 640, 3)])
def test_the_shape_counts(shape):
    same, other = np.zeros(shape, np.uint8), np.zeros((shape[0] + 1, *shape[1:]), np.uint8)
    assert picture_fingerprint(same) == picture_fingerprint(same.copy()) != picture_fingerprint(other)
