"""Drives through the garden of posts and maps of it: small, smooth and made in milliseconds."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from andante.data import Frame
from andante.mapping import MapConfig, SlowMap, build_map
from andante.recordings import FolderRecording, MemoryRecording, write_recording


@pytest.fixture(scope="session")
def other_garden(garden: Any) -> Any:
    return type(garden)(seed=5)


@pytest.fixture(scope="session")
def days(garden: Any) -> list[MemoryRecording]:
    return garden.two_days()


@pytest.fixture(scope="session")
def slowmap(days: list[MemoryRecording]) -> SlowMap:
    """Of two drives with a panorama camera."""
    return build_map(days)


@pytest.fixture(scope="session")
def fisheye_map(garden: Any) -> SlowMap:
    return build_map(garden.two_days(fisheye=True))


@pytest.fixture(scope="session")
def errors_m() -> Callable[[SlowMap, MemoryRecording], np.ndarray]:
    """``errors_m(slowmap, recording)`` -> (n,) distances to the truth, infinite where there is no position."""

    def measure(slowmap: SlowMap, recording: MemoryRecording) -> np.ndarray:
        errors = []
        for info in recording.infos:
            estimate = slowmap.localize(recording.load(info))
            known = estimate.x_m is not None
            truth = info.reference
            errors.append(np.hypot(estimate.x_m - truth.x_m, estimate.y_m - truth.y_m) if known else np.inf)
        return np.array(errors)

    return measure


@pytest.fixture(scope="session")
def copied() -> Callable[..., MemoryRecording]:
    """``copied(recording, place=..., images=...)`` is the recording with some of its values replaced."""

    def copy(recording: MemoryRecording, **changes: Any) -> MemoryRecording:
        infos = recording.infos
        values = {
            "reference": [info.reference for info in infos],
            "odometry": [info.odometry for info in infos],
            "place": [info.place for info in infos],
            "name": recording.name,
        }
        pictures = changes.pop("images", [recording.load(info) for info in infos])
        camera = changes.pop("camera", recording.camera)
        return MemoryRecording(pictures, [info.timestamp_s for info in infos], camera, **(values | changes))

    return copy


@pytest.fixture
def on_disk(tmp_path: Path) -> Callable[[MemoryRecording], FolderRecording]:
    """``on_disk(recording)`` writes it to a folder of its name, losslessly."""

    def write(recording: MemoryRecording, folder: Path | None = None) -> FolderRecording:
        frames = (Frame(info, recording.load(info)) for info in recording.infos)
        target = folder or tmp_path / recording.name
        return write_recording(target, frames, name=recording.name, camera=recording.camera, image_format="png")

    return write


@pytest.fixture(scope="session")
def small_config() -> MapConfig:
    """Few slow features: quick to build where the map itself is not the matter."""
    return MapConfig().with_values({"learning": {"slow_features": 20}})
