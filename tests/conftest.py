"""What all tests share."""

from collections.abc import Callable, Sequence
from functools import cache
from pathlib import Path

import cv2
import numpy as np
import pytest

from andante.angles import wrapped
from andante.camera import rays
from andante.data import CameraSpec, ImageArray, Pose2D
from andante.landmarks.boxes import Box, Detection
from andante.protocols import Recording
from andante.recordings import MemoryRecording

SHARED_DATA = Path(__file__).parents[2] / "shared" / "data"
PANORAMA = CameraSpec(model="panorama")
FISHEYE = CameraSpec(centre_px=(59.5, 59.5), radius_px=58.0)
FISHEYE_PX = 120


class Garden:
    """Posts of random place, width, height and brightness on a ground that is flat; ``seed`` makes another garden."""

    panorama_camera = PANORAMA
    fisheye_camera = FISHEYE

    def __init__(self, seed: int = 0, posts: int = 40) -> None:
        rng = np.random.default_rng(seed)
        self._xy = rng.uniform(-7, 7, (posts, 2))
        self._height = rng.uniform(0.4, 2.5, posts)
        self._width = rng.uniform(0.15, 0.5, posts)
        self._level = rng.uniform(-70, 90, posts)
        self._azimuth, self._elevation, self._inside = rays(FISHEYE, (FISHEYE_PX, FISHEYE_PX))

    def look(self, pose: Sequence[float], height: int, width: int, top_deg: float, gain: float, offset: float):
        """The grey panorama (height, width) from the horizon to ``top_deg`` at a pose (x, y, heading)."""
        azimuth = np.pi - 2 * np.pi * (np.arange(width) + 0.5) / width
        elevation = np.radians(top_deg) * (1 - (np.arange(height) + 0.5) / height)
        to_post = self._xy - pose[:2]
        distance = np.maximum(np.hypot(*to_post.T), 0.3)
        turn = np.arctan2(to_post[:, 1], to_post[:, 0])[:, None] - pose[2] - azimuth
        across = np.exp(-0.5 * (np.angle(np.exp(1j * turn)) / (self._width / distance)[:, None]) ** 2)
        upright = 1 / (1 + np.exp((elevation - np.arctan(self._height / distance)[:, None]) / 0.04))
        grey = 120 + 40 * np.sin(elevation)[:, None] + np.einsum("n,nh,nw->hw", self._level, upright, across)
        return np.clip(gain * grey + offset, 0, 255).astype(np.float32)

    def panorama(self, pose: Sequence[float], gain: float = 1.0, offset: float = 0.0) -> ImageArray:
        """(12, 120) from a panorama camera."""
        return self.look(pose, 12, 120, 35.0, gain, offset).astype(np.uint8)

    def fisheye(self, pose: Sequence[float], gain: float = 1.0, offset: float = 0.0) -> ImageArray:
        """(120, 120) from a camera that looks up, black around its circle."""
        around = self.look(pose, 90, 480, 90.0, gain, offset)
        x = (np.pi - self._azimuth) / (2 * np.pi) * 480 - 0.5
        y = 90 - np.degrees(self._elevation) - 0.5
        picture = cv2.remap(around, x.astype(np.float32), y.astype(np.float32), 1, borderMode=cv2.BORDER_REPLICATE)
        return np.where(self._inside, picture, 0).astype(np.uint8)

    @staticmethod
    def loop(n: int, phase: float = 0.0, radius_m: float = 3.0) -> np.ndarray:
        """(n, 3) poses once around an ellipse."""
        turn = 2 * np.pi * (np.arange(n) + phase) / n
        return np.column_stack([1.2 * radius_m * np.cos(turn), radius_m * np.sin(turn), turn + np.pi / 2])

    def drive(
        self, poses: np.ndarray, *, name: str = "monday", fisheye: bool = False, gain: float = 1.0, offset: float = 0.0
    ) -> MemoryRecording:
        """A recording with reference poses."""
        render = self.fisheye if fisheye else self.panorama
        return MemoryRecording(
            [render(pose, gain, offset) for pose in poses],
            0.2 * np.arange(len(poses)),
            FISHEYE if fisheye else PANORAMA,
            reference=[Pose2D(*pose) for pose in poses.tolist()],
            name=name,
            conditions={"gain": gain},
        )

    def two_days(self, *, fisheye: bool = False) -> list[MemoryRecording]:
        """A dark and a bright drive along nearly the same path."""
        monday = self.drive(self.loop(60), name="monday", fisheye=fisheye)
        tuesday = self.drive(self.loop(60, 0.4, 3.05), name="tuesday", fisheye=fisheye, gain=0.7, offset=20)
        return [monday, tuesday]

    def another_day(self, *, fisheye: bool = False) -> MemoryRecording:
        """A drive between the two, in yet another light."""
        return self.drive(self.loop(37, 0.2, 3.02), name="friday", fisheye=fisheye, gain=1.15, offset=-25)


class AnchorScene:
    """Panoramas of a robot that passes a red bicycle with a blue shed behind it, and who finds the bicycle by heart."""

    names = ("bicycle", "car", "cow")
    frames = 40
    size = (160, 720)

    def __init__(self, found: Sequence[int] | None = None) -> None:
        self.found = range(self.frames) if found is None else found
        self.searched: list[object] = []

    @staticmethod
    def anchor(index: int) -> Box:
        """In the middle of the recording it is nearest; the robot turns, so that it crosses the seam."""
        near = 1 / np.hypot(1.0, (index - 20) / 12)
        return Box(float(wrapped(2.6 + 0.03 * index)), -0.15, 0.35 * near, 0.22 * near)

    @classmethod
    def shed(cls, index: int) -> Box:
        """Above the bicycle and a little to its right."""
        return cls.anchor(index).shifted(0.2, 1.4, 1.6, 1.8)

    def find(
        self, recording: Recording, name: str, progress: Callable[[int, int], None], *, chosen: object = None
    ) -> dict[int, Detection]:
        """As an anchor finder does; a car is never found."""
        self.searched.append(chosen)
        for index in range(len(recording.infos)):
            progress(index + 1, len(recording.infos))
        if name != "bicycle":
            return {}
        return {at: Detection(self.anchor(at), name, 0.6 + 0.001 * at, followed=at % 5 == 1) for at in self.found}

    @classmethod
    @cache
    def recording(cls) -> MemoryRecording:
        """The drive, in colour."""
        return MemoryRecording([cls.picture(at) for at in range(cls.frames)], np.arange(cls.frames) / 5, PANORAMA)

    @classmethod
    def picture(cls, index: int) -> ImageArray:
        """BGR (160, 720): sky, hills, lawn, and the two boxes."""
        height, width = cls.size
        column, row = np.arange(width), np.arange(height)[:, None]
        turned = 2 * np.pi * column / width + 0.03 * index
        ridge = 62 + 6 * np.sin(3 * turned) + 3 * np.sin(11 * turned)
        sky, hill, lawn = np.array([235, 205, 170]), np.array([70, 95, 80]), np.array([60, 130, 95])
        picture = np.where((row < ridge)[..., None], sky - 0.3 * row[..., None], hill)
        picture = np.where((row > height / 2)[..., None], lawn + 8 * np.sin(9 * turned + row / 3)[..., None], picture)
        for box, colour in ((cls.shed(index), (150, 90, 40)), (cls.anchor(index), (40, 40, 200))):
            scale = width / (2 * np.pi)
            off = wrapped(np.pi - column / scale - box.azimuth_rad)
            inside = (abs(off) < box.width_rad / 2) & (
                abs(height / 2 - row - box.elevation_rad * scale) < box.height_rad * scale / 2
            )
            picture[inside] = colour
        return picture.clip(0, 255).astype(np.uint8)


@pytest.fixture(scope="session")
def anchor_scene() -> type[AnchorScene]:
    """The class: ``anchor_scene(found=range(3))`` finds the bicycle in three frames only."""
    return AnchorScene


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """The folder of example recordings beside the checkout; tests that need it skip without it."""
    if not SHARED_DATA.is_dir():
        pytest.skip("the example recordings (../shared/data) are not beside this checkout")
    return SHARED_DATA


@pytest.fixture(scope="session")
def garden() -> Garden:
    return Garden()


@pytest.fixture(scope="session")
def posts() -> Garden:
    """The same by a name that no room gives to a garden of its own."""
    return Garden()
