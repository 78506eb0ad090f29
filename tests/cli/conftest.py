"""Two short drives past bright posts, seen by a small fisheye, and a map of both; all through the command line."""

import json
import re
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

from andante.cli import app
from andante.data import CameraSpec, Frame, FrameInfo, Pose2D
from andante.recordings import write_recording

SIZE = 120
FRAMES = 40
RADIUS = 57
CAMERA = CameraSpec(centre_px=(59.5, 59.5), radius_px=RADIUS)


@dataclass(frozen=True)
class Answer:
    """What a command said and how it ended."""

    exit_code: int
    stdout: str
    stderr: str

    @property
    def json(self) -> dict[str, Any]:
        """The one object on stdout; NaN and Infinity are no JSON."""

        def refuse(name: str) -> None:
            raise AssertionError(f"{name} in the output")

        values = json.loads(self.stdout, parse_constant=refuse)
        assert isinstance(values, dict)
        return values


Andante = Callable[..., Answer]


@pytest.fixture(scope="session")
def andante() -> Andante:
    """``andante("map", folder, "-o", path)`` runs a command in this process."""

    def run(*arguments: object) -> Answer:
        result = CliRunner().invoke(app, [str(argument) for argument in arguments])
        if result.exception is not None and not isinstance(result.exception, SystemExit):
            raise result.exception
        return Answer(result.exit_code, result.stdout, result.stderr)

    return run


def fisheye_picture(x: float, y: float, light: float, rng: np.random.Generator) -> np.ndarray:
    """Twenty posts around a place of 4 m, wider and taller where they are near; dark beyond the image circle."""
    posts = np.random.default_rng(7).uniform(-4.0, 4.0, (20, 2)) - (x, y)
    distance = np.hypot(*posts.T)[:, None] + 0.3
    azimuth, radius = np.linspace(-np.pi, np.pi, 256, endpoint=False), np.arange(RADIUS + 1)
    turn = np.angle(np.exp(1j * (azimuth - np.arctan2(posts[:, 1:], posts[:, :1]))))
    wide = np.linspace(60, 160, 20)[:, None] * np.exp(-((turn * distance / 0.3) ** 2))
    tall = radius > RADIUS * (1 - 0.6 / distance)
    polar = 60 + np.einsum("pa,pr->ar", wide, tall)
    down, right = np.mgrid[:SIZE, :SIZE] - (SIZE - 1) / 2
    seen = np.hypot(right, down)
    column = ((np.arctan2(-down, right) / (2 * np.pi) + 0.5) * 256).astype(int) % 256
    level = light * polar[column, np.minimum(seen, RADIUS).astype(int)] + rng.normal(0, 2, (SIZE, SIZE))
    return np.where(seen <= RADIUS, np.clip(level, 20, 255), 0).astype(np.uint8)


def write_drive(
    folder: Path, *, light: float = 1.0, seed: int = 0, reference: bool = True, camera: CameraSpec = CAMERA
) -> Path:
    """Write a recording of a small loop."""
    rng = np.random.default_rng(seed)
    angles = np.linspace(0, 2 * np.pi, FRAMES, endpoint=False) + 0.01 * seed

    def frames():  # type: ignore[no-untyped-def]
        for index, angle in enumerate(angles):
            x, y = float(np.cos(angle)), float(np.sin(angle))
            pose = Pose2D(x, y, 0.0) if reference else None
            info = FrameInfo(index, "", index / 5, reference=pose)
            yield Frame(info, fisheye_picture(x, y, light, rng))

    write_recording(folder, frames(), name=folder.name, camera=camera, conditions={"light": light}, image_format="png")
    return folder


@dataclass(frozen=True)
class Garden:
    """Where the recordings and the map lie, and what ``andante map --json`` said."""

    monday: Path
    tuesday: Path
    sunday: Path
    no_poses: Path
    map: Path
    built: Answer


@pytest.fixture(scope="session")
def garden(tmp_path_factory: pytest.TempPathFactory, andante: Andante) -> Garden:
    """A map of monday and tuesday; sunday is another drive, ``no_poses`` one without any position."""
    folder = tmp_path_factory.mktemp("garden")
    drives = [write_drive(folder / name, light=light, seed=seed) for name, light, seed in (
        ("monday", 1.0, 0), ("tuesday", 0.8, 1), ("sunday", 0.9, 2)
    )]  # fmt: skip
    no_poses = write_drive(folder / "no_poses", reference=False)
    path = folder / "garden.andante"
    return Garden(*drives, no_poses, path, andante("map", *drives[:2], "-o", path, "--slow-features", 20, "--json"))


Fails = Callable[[Answer, str], None]


@pytest.fixture
def fails() -> Fails:
    """``fails(answer, pattern)``: exit 1, nothing on stdout, one line on stderr that matches."""

    def check(answer: Answer, pattern: str) -> None:
        assert (answer.exit_code, answer.stdout) == (1, "")
        lines = answer.stderr.splitlines()
        assert len(lines) == 1, answer.stderr
        assert re.match(f"error: .*{pattern}", lines[0]), lines[0]

    return check


@pytest.fixture(name="write_drive")
def write_drive_fixture() -> Callable[..., Path]:
    """The function ``write_drive``, for tests that need a drive of their own."""
    return write_drive
