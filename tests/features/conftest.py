"""Panoramas that look like nothing in particular but are smooth, as pictures are."""

import cv2
import numpy as np
import pytest

HEIGHT, WIDTH = 8, 48


@pytest.fixture(scope="session")
def panoramas() -> np.ndarray:
    """(20, 8, 48) uint8 that wrap around in azimuth; the last ones are dark, flat and black."""
    rng = np.random.default_rng(7)
    rough = rng.integers(0, 256, (20, 4, 12)).astype(np.float32)
    wrapped = np.concatenate([rough, rough, rough], axis=2)
    smooth = np.stack([cv2.resize(one, (3 * WIDTH, HEIGHT), interpolation=cv2.INTER_CUBIC) for one in wrapped])
    stack = np.clip(smooth[:, :, WIDTH : 2 * WIDTH], 0, 255)
    stack[-3] *= 0.02
    stack[-2], stack[-1] = 90, 0
    return stack.astype(np.uint8)
