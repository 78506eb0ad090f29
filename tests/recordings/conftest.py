"""Small recordings on the disk, made anew for every test."""

from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import pytest

TOML = 'schema = 1\nname = "monday"\n[camera]\nmodel = "panorama"\n'

MakeFolder = Callable[..., Path]


def picture(seed: int, height: int = 12, width: int = 20) -> np.ndarray:
    """A smooth BGR picture that JPEG keeps recognisable."""
    rng = np.random.default_rng(seed)
    return cv2.resize(rng.integers(0, 256, (3, 4, 3), dtype=np.uint8), (width, height))


@pytest.fixture
def make_folder(tmp_path: Path) -> MakeFolder:
    """``make_folder(n, toml=..., table=..., suffix=...)`` -> the path of a recording with n frames."""

    def make(n: int = 3, *, toml: str = TOML, table: str | None = None, suffix: str = "png") -> Path:
        folder = tmp_path / f"recording_{len(list(tmp_path.iterdir()))}"
        (folder / "images").mkdir(parents=True)
        rows = [f"{index}.5,images/{index:03d}.{suffix}" for index in range(n)]
        for index in range(n):
            cv2.imwrite(str(folder / "images" / f"{index:03d}.{suffix}"), picture(index))
        (folder / "recording.toml").write_text(toml, encoding="utf-8")
        text = "\n".join(["timestamp_s,image", *rows]) if table is None else table
        (folder / "frames.csv").write_text(text, encoding="utf-8", newline="")
        return folder

    return make
