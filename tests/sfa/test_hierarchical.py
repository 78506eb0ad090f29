"""What a network must not learn from, and how pictures may be handed in."""

import numpy as np
import pytest

from andante.errors import ArrayError
from andante.sfa import HierarchicalSFA, Layer


def test_fields_that_always_see_the_same_teach_nothing():
    """Burnt-out sky above: float32 rounding of what is constant must not be learnt from."""
    rng = np.random.default_rng(4)
    pictures = waves_with_sky(rng, 120)
    layers = [Layer(4, field=(4, 4), stride=(2, 2), reduced_dim=6), Layer(3, field=(3, 2), reduced_dim=8), Layer(2)]
    model = HierarchicalSFA(layers, deviation_floor=10.0).fit(pictures).model_
    together = model.transform(pictures)
    alone = np.stack([model.transform(picture) for picture in pictures[:10]])
    np.testing.assert_allclose(alone, together[:10], atol=1e-2)
    np.testing.assert_allclose(model.transform(pictures, dtype=np.float64), together, atol=1e-2)


def waves_with_sky(rng: np.random.Generator, n: int) -> np.ndarray:
    time = np.arange(n)[:, None, None]
    pictures = 120 + 80 * np.sin(time * rng.uniform(0.01, 0.4, (12, 16)) + rng.uniform(0, 6, (12, 16)))
    pictures[:, :6] = 255
    return pictures.astype(np.uint8)


def test_a_stream_has_to_be_handed_in_as_a_function():
    pictures = np.zeros((10, 8, 8), np.uint8)
    with pytest.raises(ArrayError, match=r"got generator: hand in a function"):
        HierarchicalSFA([Layer(2)]).fit(pictures[at : at + 5] for at in (0, 5))
