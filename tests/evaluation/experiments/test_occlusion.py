import numpy as np
import pytest

from andante.camera import rays
from andante.data import CameraSpec
from andante.errors import ConfigError
from andante.evaluation.experiments.occlusion import COVERS, hidden_sector

CAMERA = CameraSpec(centre_px=(39.5, 39.5), radius_px=40.0)


@pytest.fixture
def image():
    return np.full((80, 80), 200, np.uint8)


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5, 1.0])
def test_a_share_of_the_circle_is_hidden_in_one_piece(image, share):
    seen = hidden_sector(image, CAMERA, share, 1.0, rng=np.random.default_rng(3), cover=np.zeros_like(image))
    azimuth, _, valid = rays(CAMERA, image.shape)
    hidden = seen == 0
    assert hidden[valid].mean() == pytest.approx(share, abs=0.01)
    assert not hidden[~valid].any()
    if 0 < share < 1:
        turns = np.sort(azimuth[valid & ~hidden])
        gaps = np.diff(np.append(turns, turns[0] + 2 * np.pi))
        assert (gaps > np.radians(20)).sum() == 1


def test_it_is_hidden_counter_clockwise_from_the_start(image):
    seen = hidden_sector(image, CAMERA, 0.25, 3.0, rng=np.random.default_rng(3), cover=np.zeros_like(image))
    azimuth, _, valid = rays(CAMERA, image.shape)
    np.testing.assert_array_equal((seen == 0)[valid], np.mod(azimuth[valid] - 3.0, 2 * np.pi) < np.pi / 2)


@pytest.mark.parametrize("name", COVERS)
def test_covers_are_not_what_they_hide_and_their_seed_decides(image, name):
    seen = [hidden_sector(image, CAMERA, 0.5, 1.0, rng=np.random.default_rng(3), cover=COVERS[name]) for _ in range(2)]
    np.testing.assert_array_equal(*seen)
    assert (seen[0] != image).mean() > 0.3


def test_bad_input(image):
    with pytest.raises(ConfigError, match=r"from 0 to 1, got 1.5"):
        hidden_sector(image, CAMERA, 1.5, 1.0, rng=np.random.default_rng(0), cover=image)
    with pytest.raises(ConfigError, match=r"a cover of shape \(40, 80\) does not fit a picture of shape \(80, 80\)"):
        hidden_sector(image, CAMERA, 0.5, 1.0, rng=np.random.default_rng(0), cover=image[:40])
