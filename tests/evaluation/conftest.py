"""A made world: panoramas that change smoothly with the position, in two lights."""

from collections.abc import Callable
from dataclasses import replace
from html.parser import HTMLParser

import cv2
import numpy as np
import pytest

from andante.data import CameraSpec, Pose2D
from andante.mapping import MapConfig, SlowMap, build_map
from andante.recordings import MemoryRecording

CAMERA = CameraSpec(model="panorama")
CONFIG = MapConfig().with_values(
    {"panorama": {"width_px": 64, "height_px": 12}, "features": {"n_frequencies": 8}, "learning": {"slow_features": 8}}
)
Drive = Callable[..., MemoryRecording]
VOID = {"meta", "img", "link", "br"}


def panorama(place: float, noise: np.random.Generator) -> np.ndarray:
    """What is seen at a place on a ring of 40: bumps that come and go."""
    rng = np.random.default_rng(3)
    bumps = rng.normal(size=(10, 12, 16)).astype(np.float32)
    centres = np.linspace(0, 40, 10, endpoint=False)
    apart = (place - centres + 20) % 40 - 20
    seen = np.tensordot(np.exp(-((apart / 4) ** 2)), bumps, axes=1)
    image = 128 + 40 * cv2.resize(seen, (64, 12)) + noise.normal(0, 3, (12, 64))
    return np.clip(image, 0, 255).astype(np.uint8)


@pytest.fixture(scope="session")
def make_drive() -> Drive:
    """``make_drive(seed, n=..., blank=..., truth=..., places=...)`` -> one round."""

    def make(
        seed: int = 0, *, n: int = 40, blank: tuple[int, ...] = (), truth: float = 1.0, places: bool = False, **more
    ) -> MemoryRecording:
        rng = np.random.default_rng(seed)
        at = np.arange(n) * 40 / n + 0.05 * seed
        images = [panorama(place, rng) for place in at]
        for index in blank:
            images[index] = np.full_like(images[index], 7)
        known = np.arange(n) < truth * n
        angle = 2 * np.pi * at / 40
        poses = [Pose2D(6 * np.cos(a), 6 * np.sin(a)) if k else None for a, k in zip(angle, known, strict=True)]
        numbers = [int(index) if k else None for index, k in enumerate(known)]
        truths = {"place": numbers} if places else {"reference": poses}
        return MemoryRecording(images, 100 + np.arange(n) * 0.5, CAMERA, **truths, **{"name": f"drive {seed}", **more})

    return make


@pytest.fixture(scope="session")
def slowmap(make_drive: Drive) -> SlowMap:
    return build_map([make_drive(1), make_drive(2)], CONFIG, name="ring")


@pytest.fixture(scope="session")
def place_map(make_drive: Drive) -> SlowMap:
    return build_map([make_drive(1, places=True), make_drive(2, places=True)], CONFIG)


@pytest.fixture(scope="session")
def make_ride(make_drive: Drive) -> Drive:
    """``make_drive`` with headings along the way and an odometry that begins elsewhere and turns a little too far."""

    def make(seed: int = 0, *, n: int = 80, truth: bool = True, odometry: bool = True, **more) -> MemoryRecording:
        angle = 2 * np.pi * (np.arange(n) * 40 / n + 0.05 * seed) / 40
        poses = [Pose2D(6 * np.cos(a), 6 * np.sin(a), a + np.pi / 2) for a in angle.tolist()]
        turned = 1.01 * (angle - angle[0])
        believed = [Pose2D(6.05 * np.sin(t), 6.05 * (1 - np.cos(t)), t) for t in turned.tolist()]
        drive = make_drive(seed, n=n, odometry=believed if odometry else None, **more)
        drive.infos = tuple(
            replace(info, reference=pose if truth else None) for info, pose in zip(drive.infos, poses, strict=True)
        )
        return drive

    return make


class Page(HTMLParser):
    """Checks that tags are balanced; collects sources and tags."""

    def __init__(self, text):
        super().__init__()
        self.open, self.tags, self.sources = [], set(), []
        self.feed(text)
        assert self.open == []

    def handle_starttag(self, tag, attributes):
        self.tags.add(tag)
        self.sources += [value for key, value in attributes if key in ("src", "href")]
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        assert self.open.pop() == tag


@pytest.fixture(scope="session")
def page_of() -> Callable[[str], Page]:
    """``page_of(text)`` is a page whose tags are balanced, with its ``tags`` and ``sources``."""
    return Page
