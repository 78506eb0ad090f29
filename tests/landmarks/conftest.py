"""A horizon with posts of random grey, seen from anywhere: what anchors are looked for and followed in."""

import importlib.util
import sys
from pathlib import Path

import cv2
import numpy as np
import pytest

from andante.camera import PanoramaGeometry

WEIGHTS = Path(__file__).parents[3] / "shared" / "weights" / "yolox_nano.onnx"
GEOMETRY = PanoramaGeometry(720, 120, -15.0, 45.0)

if "yolox_files" not in sys.modules:  # tests are imported by path, so their helpers are too
    _spec = importlib.util.spec_from_file_location("yolox_files", Path(__file__).with_name("yolox_files.py"))
    assert _spec is not None
    assert _spec.loader is not None
    _module = importlib.util.module_from_spec(_spec)
    sys.modules["yolox_files"] = _module
    _spec.loader.exec_module(_module)


@pytest.fixture(scope="session")
def weights() -> Path:
    """The weights of YOLOX-nano beside the checkout; tests that need them skip without."""
    if not WEIGHTS.is_file():
        pytest.skip("the weights of the anchor detector (../shared/weights) are not beside this checkout")
    return WEIGHTS


@pytest.fixture
def geometry() -> PanoramaGeometry:
    return GEOMETRY


class Scene:
    """A far background, and near it one speckled thing at a bearing, of a width and a height."""

    def __init__(self, geometry: PanoramaGeometry, seed: int = 0) -> None:
        rng = np.random.default_rng(seed)
        self.geometry = geometry
        self._far = cv2.GaussianBlur(rng.integers(0, 255, (120, 720), np.uint8), (0, 0), 2.0)
        self._far = cv2.normalize(self._far, None, 60, 190, cv2.NORM_MINMAX)
        self._thing = cv2.resize(rng.integers(0, 255, (12, 12), np.uint8), (96, 96), interpolation=cv2.INTER_CUBIC)

    def panorama(self, heading: float, box=None):
        """BGR, the background turned by the robot's heading, the thing drawn into its box."""
        shift = round(heading / (2 * np.pi) * 720)
        grey = np.roll(self._far, shift, axis=1)
        if box is not None:
            per_rad = 720 / (2 * np.pi)
            width, height = round(box.width_rad * per_rad), round(box.height_rad * 120 / np.radians(60))
            left = round((np.pi - box.left_rad) * per_rad)
            top = round((np.radians(45) - box.high_rad) * 120 / np.radians(60))
            thing = cv2.resize(self._thing, (width, height), interpolation=cv2.INTER_AREA)
            low, high = max(top, 0), min(top + height, 120)
            grey[low:high, np.mod(np.arange(left, left + width), 720)] = thing[low - top : high - top]
        return cv2.cvtColor(grey, cv2.COLOR_GRAY2BGR)


@pytest.fixture
def scene(geometry) -> Scene:
    return Scene(geometry)
