"""A made world: panoramas that change smoothly along a ring of places."""

from collections.abc import Callable

import cv2
import numpy as np
import pytest

from andante.data import CameraSpec, Pose2D
from andante.mapping import MapConfig, SlowMap, build_map
from andante.recordings import MemoryRecording

CONFIG = MapConfig().with_values(
    {"panorama": {"width_px": 64, "height_px": 12}, "features": {"n_frequencies": 8}, "learning": {"slow_features": 6}}
)
Drive = Callable[..., MemoryRecording]


@pytest.fixture(scope="session")
def make_drive() -> Drive:
    """``make_drive(seed, standing=..., unknown=..., blank=...)``: a round of 40 frames; frames by their index."""

    def make(seed: int = 0, *, standing=(), unknown=(), blank=()) -> MemoryRecording:
        rng = np.random.default_rng(seed)
        bumps = np.random.default_rng(3).normal(size=(10, 12, 16)).astype(np.float32)
        images, poses = [], []
        for index in range(40):
            at = index - 1 if index in standing else index
            apart = (at - np.arange(0, 40, 4) + 20) % 40 - 20
            seen = np.tensordot(np.exp(-((apart / 4) ** 2)), bumps, axes=1)
            image = 128 + 40 * cv2.resize(seen, (64, 12)) + rng.normal(0, 3, (12, 64))
            images.append(
                np.clip(image, 0, 255).astype(np.uint8) if index not in blank else np.zeros((12, 64), np.uint8)
            )
            angle = 2 * np.pi * at / 40
            poses.append(None if index in unknown else Pose2D(6 * np.cos(angle), 6 * np.sin(angle)))
        times = np.arange(40) + 0.5
        return MemoryRecording(images, times, CameraSpec(model="panorama"), reference=poses, name=f"drive {seed}")

    return make


@pytest.fixture(scope="session")
def slowmap(make_drive: Drive) -> SlowMap:
    return build_map([make_drive(1), make_drive(2)], CONFIG)
