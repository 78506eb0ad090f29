"""A learnt network as an encoder."""

import numpy as np
import pytest

from andante.errors import ConfigError
from andante.features import NetworkEncoder
from andante.protocols import Encoder
from andante.sfa import HierarchicalSFA, Layer


@pytest.fixture(scope="module")
def model():
    pictures = np.random.default_rng(0).integers(0, 255, (60, 8, 16)).astype(np.uint8)
    return HierarchicalSFA([Layer(3, (4, 4), (2, 2), 5), Layer(2, reduced_dim=6)], wrap=True).fit(pictures).model_


def test_outputs_of_all_or_the_first_layers(model):
    panoramas = np.random.default_rng(1).integers(0, 255, (4, 8, 16)).astype(np.uint8)
    for encoder, dim in ((NetworkEncoder(model), 2), (NetworkEncoder(model.first(1)), 3 * 3 * 8)):
        assert isinstance(encoder, Encoder)
        assert encoder.dim == dim
        many = encoder.encode(panoramas)
        assert (many.shape, many.dtype) == ((4, dim), np.float32)
        np.testing.assert_array_equal(encoder.encode(panoramas[2]), many[2])


def test_unit_length_whatever_the_contrast(model):
    panoramas = np.random.default_rng(1).integers(0, 255, (4, 8, 16)).astype(np.uint8)
    plain, unit = NetworkEncoder(model).encode(panoramas), NetworkEncoder(model, unit=True).encode(panoramas)
    np.testing.assert_allclose(np.linalg.norm(unit, axis=1), 1, atol=1e-6)
    np.testing.assert_allclose(plain / np.linalg.norm(plain, axis=1, keepdims=True), unit, atol=1e-6)
    np.testing.assert_array_equal(NetworkEncoder(model, unit=True).encode(panoramas[2]), unit[2])


def test_encoders_are_alike_by_their_network(model):
    assert NetworkEncoder(model) == NetworkEncoder(model)
    assert NetworkEncoder(model) != NetworkEncoder(model, unit=True)
    assert NetworkEncoder(model) != NetworkEncoder(model.first(1))


def test_a_picture_gives_the_same_whatever_else_is_in_the_stack(model):
    panoramas = np.random.default_rng(3).integers(0, 255, (13, 8, 16)).astype(np.uint8)
    encoder = NetworkEncoder(model)
    many = encoder.encode(panoramas)
    for size in (1, 5, 12):
        np.testing.assert_array_equal(encoder.encode(panoramas[-size:]), many[-size:])


def test_other_pictures_are_refused(model):
    for wrong in (np.zeros((8, 15), np.uint8), np.zeros((8, 16)), np.zeros(128, np.uint8)):
        with pytest.raises(ConfigError, match=r"grey uint8 panoramas \(8, 16\), one or a stack of them"):
            NetworkEncoder(model).encode(wrong)
