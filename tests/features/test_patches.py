import numpy as np
import pytest

from andante.errors import ArrayError, ConfigError
from andante.features import PatchEncoder

HEIGHT, WIDTH = 12, 120


@pytest.fixture(scope="module")
def encoder():
    return PatchEncoder(HEIGHT, WIDTH)


@pytest.fixture(scope="module")
def panoramas(garden):
    return np.stack([garden.panorama(pose) for pose in garden.loop(5)])


def test_patches_are_vectors_of_length_one(encoder, panoramas):
    patches = encoder.cut(encoder.fields(panoramas), np.linspace(-3, 3, 35).reshape(5, 7))
    assert patches.shape == (5, 7, encoder.dim)
    assert encoder.dim == 12 * 8 * 3
    np.testing.assert_allclose(np.linalg.norm(patches, axis=2), 1, atol=1e-5)


@pytest.mark.parametrize("columns", [1, 30, 77])
def test_a_robot_that_turns_sees_the_same_patch_elsewhere(encoder, panoramas, columns):
    """Turning left moves everything to the right, to smaller azimuths."""
    azimuth = np.tile([0.1, 2.0, -2.9], (5, 1))
    turned = encoder.cut(encoder.fields(np.roll(panoramas, columns, axis=2)), azimuth - 2 * np.pi * columns / WIDTH)
    np.testing.assert_allclose(turned, encoder.cut(encoder.fields(panoramas), azimuth), atol=1e-4)


def test_cells_are_read_from_left_to_right_where_they_lie(panoramas):
    encoder = PatchEncoder(HEIGHT, WIDTH, width_deg=9, cell_deg=3)
    fields = encoder.fields(panoramas)
    column = 40
    azimuth = np.pi - 2 * np.pi * (column + 0.5) / WIDTH
    patch = encoder.cut(fields, np.full((5, 1), azimuth))[:, 0]
    expected = fields[:, column - 1 : column + 2].reshape(5, -1)
    np.testing.assert_allclose(patch, expected / np.linalg.norm(expected, axis=1, keepdims=True), atol=1e-4)


def test_a_patch_crosses_the_seam(encoder, panoramas):
    fields = encoder.fields(panoramas)
    behind = [encoder.cut(fields, np.full((5, 1), angle)) for angle in (np.pi, -np.pi)]
    np.testing.assert_allclose(*behind, atol=1e-5)


def test_another_light_changes_little(encoder, garden):
    pose = garden.loop(5)[1]
    one, other, elsewhere = (
        encoder.cut(encoder.fields(panorama[None]), np.array([[0.4, 1.9]]))[0]
        for panorama in (garden.panorama(pose), garden.panorama(pose, 0.7, 20), garden.panorama(garden.loop(5)[3]))
    )
    same, foreign = ((one * patches).sum(axis=1) for patches in (other, elsewhere))
    assert (same > 0.95).all()
    assert (same > foreign).all()


def test_what_lies_far_outside_does_not_matter(encoder, panoramas):
    hidden = panoramas.copy()
    hidden[:, :, :40] = 90
    azimuth = np.full((5, 1), -np.pi / 2)
    patches = [encoder.cut(encoder.fields(which), azimuth) for which in (panoramas, hidden)]
    np.testing.assert_allclose(*patches, atol=1e-3)


def test_a_low_panorama_has_one_band_a_row():
    assert PatchEncoder(3, 60).bands == 3
    assert PatchEncoder(60, 600).bands == 8


def test_a_uniform_panorama_gives_finite_patches(encoder):
    patches = encoder.cut(encoder.fields(np.full((1, HEIGHT, WIDTH), 80, np.uint8)), np.zeros((1, 1)))
    assert np.isfinite(patches).all()


def test_bad_input(encoder, panoramas):
    with pytest.raises(ConfigError, match=r"a patch of 48 degrees cannot be cut into cells of 60"):
        PatchEncoder(HEIGHT, WIDTH, cell_deg=60)
    with pytest.raises(ConfigError, match=r"a patch of 400 degrees"):
        PatchEncoder(HEIGHT, WIDTH, width_deg=400)
    with pytest.raises(ConfigError, match=r"takes grey uint8 panoramas \(12, 120\)"):
        encoder.fields(panoramas[:, :, :50])
    with pytest.raises(ArrayError, match=r"one row per panorama \(5, m\), got shape \(3,\)"):
        encoder.cut(encoder.fields(panoramas), np.zeros(3))
