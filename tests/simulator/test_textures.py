import numpy as np

from andante.simulator.mesh import Layer
from andante.simulator.noise import lookup, tileable_noise
from andante.simulator.textures import texture_atlas


def test_noise_is_standardised_and_meets_itself_at_the_edges():
    noise = tileable_noise(np.random.default_rng(0), 64, 1.5)
    assert abs(noise.mean()) < 1e-9
    assert abs(noise.std() - 1) < 1e-9
    inner = np.abs(np.diff(noise, axis=1)).mean()
    assert np.abs(noise[:, 0] - noise[:, -1]).mean() < 1.5 * inner


def test_lookup_meets_the_grid_and_repeats():
    tile = tileable_noise(np.random.default_rng(0), 16, 1.0)
    row, column = np.mgrid[0:16, 0:16]
    np.testing.assert_allclose(lookup(tile, column / 16, row / 16), tile)
    np.testing.assert_allclose(lookup(tile, column / 16 + 3, row / 16 - 2), tile)


def test_every_texture_keeps_the_brightness_of_a_surface_near_and_far():
    uv = np.random.default_rng(0).uniform(-20, 20, (4000, 2)).astype(np.float32)
    for layer in Layer:
        layers = np.full(len(uv), layer, np.int32)
        near, far = (texture_atlas().sample(layers, uv, np.full(len(uv), size, np.float32)) for size in (0.001, 50.0))
        assert 0.7 < near.mean() < 1.35
        np.testing.assert_allclose(far.mean(axis=0), near.mean(axis=0), atol=0.05)
        assert far.std(axis=0).max() < 0.08
