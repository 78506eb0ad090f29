"""A made world of points, each with a descriptor of its own, and a robot that drives around in the middle of it."""

from dataclasses import dataclass

import numpy as np
import pytest

from andante.baselines.structure import Keypoints
from andante.baselines.structure.views import FisheyeView, colmap_camera
from andante.data import CameraSpec, FloatArray

SPEC = CameraSpec(centre_px=(119.5, 119.5), radius_px=120.0, forward_deg=30.0)


@dataclass(frozen=True)
class PointWorld:
    """``xyz`` (m, 3) metres and ``descriptors`` (m, 128) uint8."""

    xyz: FloatArray
    descriptors: np.ndarray
    view: FisheyeView

    def keypoints(self, pose: FloatArray, rng: np.random.Generator, noise_px: float = 0.1) -> Keypoints:
        """What a robot at (x, y, heading) with its camera at height zero sees, in a random order."""
        robot = (self.xyz - [pose[0], pose[1], 0.0]) @ _about_vertical(pose[2])
        xy = colmap_camera(self.view).img_from_cam(robot @ self.view.robot_from_camera)
        order = rng.permutation(np.flatnonzero(np.isfinite(xy).all(axis=1)))
        return Keypoints(
            (xy[order] + rng.normal(0, noise_px, (len(order), 2))).astype(np.float32), self.descriptors[order]
        )


def _about_vertical(angle: float) -> FloatArray:
    cos, sin = np.cos(angle), np.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


@pytest.fixture(scope="session")
def colmap():
    return pytest.importorskip("pycolmap", reason="COLMAP needs the extra: pip install 'andante[structure]'")


@pytest.fixture(scope="session")
def world(colmap) -> PointWorld:
    rng = np.random.default_rng(5)
    bearing, distance = rng.uniform(0, 2 * np.pi, 160), rng.uniform(5, 9, 160)
    xyz = np.column_stack([distance * np.cos(bearing), distance * np.sin(bearing), rng.uniform(0.3, 4, 160)])
    units = np.abs(rng.normal(size=(160, 128)))
    descriptors = np.round(512 * units / np.linalg.norm(units, axis=1, keepdims=True)).astype(np.uint8)
    return PointWorld(xyz, descriptors, FisheyeView.of(SPEC, 88.0))


@pytest.fixture(scope="session")
def loop() -> FloatArray:
    """(16, 3) poses around an ellipse."""
    turn = 2 * np.pi * np.arange(16) / 16
    return np.column_stack([3 * np.cos(turn), 2 * np.sin(turn), turn + np.pi / 2])
