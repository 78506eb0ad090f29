"""Pictures of what is not in a map: a covered lens, light that blinds, a house, nothing but noise."""

from __future__ import annotations

from collections.abc import Iterator

import cv2
import numpy as np

from andante.data import FloatArray, ImageArray

_ROUGH = 4  # noise is drawn so many times coarser than a picture before it is blurred


def dark_noise(rng: np.random.Generator, side: int) -> ImageArray:
    """A lens under a tight cap: the sensor's noise on black."""
    return _grey(rng.uniform(3, 15) + rng.normal(0, rng.uniform(2, 12), (side, side)))


def lens_cap(rng: np.random.Generator, side: int) -> ImageArray:
    """A cap that is not tight: light falls in from one side of its rim."""
    rows, columns = np.mgrid[:side, :side] / (side - 1) * 2 - 1
    angle, turn = np.arctan2(-rows, columns), rng.uniform(-np.pi, np.pi)
    glow = np.exp((np.cos(angle - turn) - 1) * rng.uniform(1, 6)) * np.hypot(rows, columns) ** rng.uniform(4, 12)
    return _grey(8 + rng.uniform(40, 200) * glow + rng.normal(0, 2, (side, side)))


def finger(rng: np.random.Generator, side: int, image: ImageArray) -> ImageArray:
    """A hand on the lens: blurred skin with folds over nine tenths of what the camera would see."""
    shade, folds = _smooth_noise(rng, side, 6), _smooth_noise(rng, side, 25)
    skin = rng.uniform(50, 140) + 25 * shade + 8 * folds
    rim = _smooth_noise(rng, side, 3)
    gap = cv2.GaussianBlur((rim > np.quantile(rim, 0.9)).astype(np.float64), (0, 0), side / 60)
    seen = cv2.GaussianBlur(cv2.resize(image, (side, side)).astype(np.float64), (0, 0), side / 60)
    return _grey(skin * (1 - gap) + seen * gap + rng.normal(0, 2, (side, side)))


def white_noise(rng: np.random.Generator, side: int) -> ImageArray:
    """Every pixel for itself."""
    return rng.integers(0, 256, (side, side), dtype=np.uint8)


def smooth_noise(rng: np.random.Generator, side: int) -> ImageArray:
    """Spots of some size: noise that could be something."""
    return _grey(128 + 60 * _smooth_noise(rng, side, float(rng.uniform(4, 30))))


def covered_lenses(rng: np.random.Generator, images: Iterator[ImageArray]) -> Iterator[ImageArray]:
    """Caps and fingers in turn on a camera that would have seen these images."""
    for number, image in enumerate(images):
        side = image.shape[0]
        if number % 3 == 2:
            yield finger(rng, side, image)
        else:
            yield (dark_noise, lens_cap)[number % 3](rng, side)


def blinded(rng: np.random.Generator, images: Iterator[ImageArray]) -> Iterator[ImageArray]:
    """The same images, burnt out: at most every eighth pixel still shows anything."""
    for image in images:
        darkest = float(np.quantile(image[image > 0], rng.uniform(0.02, 0.12))) if (image > 0).any() else 0.0
        gain = rng.uniform(4, 12)
        yield _grey(255 + gain * (image.astype(np.float64) - darkest))


def _smooth_noise(rng: np.random.Generator, side: int, spots: float) -> FloatArray:
    """(side, side) of mean 0 and deviation 1 with about so many spots across."""
    coarse = rng.normal(size=(max(4, side // _ROUGH), max(4, side // _ROUGH)))
    smooth = cv2.GaussianBlur(coarse, (0, 0), coarse.shape[0] / spots / 2, borderType=cv2.BORDER_REFLECT)
    large = np.asarray(cv2.resize(smooth, (side, side), interpolation=cv2.INTER_CUBIC), np.float64)
    spread: FloatArray = (large - large.mean()) / max(float(large.std()), 1e-9)
    return spread


def _grey(values: FloatArray) -> ImageArray:
    return np.clip(np.round(values), 0, 255).astype(np.uint8)
