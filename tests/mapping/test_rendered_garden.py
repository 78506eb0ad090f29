"""The default map on the example recordings: a promise about accuracy."""

import math
import shutil
from pathlib import Path

import numpy as np
import pytest

from andante.data import Status
from andante.mapping import SlowMap, build_map
from andante.recordings import map_frames, open_recording


@pytest.fixture(scope="module")
def summer(shared_data: Path) -> SlowMap:
    return build_map([open_recording(shared_data / "garden_a" / "border_summer")])


def located(slowmap: SlowMap, folder: Path, step: int = 1) -> tuple[np.ndarray, list[Status]]:
    """Errors (n,) over the estimates with a pose, and all statuses."""
    recording = open_recording(folder)
    indices = range(0, len(recording.infos), step)
    pairs = list(map_frames(recording, lambda frame: slowmap.localize(frame.image), indices))
    errors = [
        math.hypot(estimate.x_m - info.reference.x_m, estimate.y_m - info.reference.y_m)
        for info, estimate in pairs
        if estimate.x_m is not None
    ]
    return np.array(errors), [estimate.status for _, estimate in pairs]


def test_summer_finds_its_way_in_autumn(summer, shared_data):
    errors, statuses = located(summer, shared_data / "garden_a" / "border_autumn")
    assert errors.mean() <= 0.30
    assert np.median(errors) <= 0.10
    assert sum(not status.has_pose for status in statuses) <= 0.03 * len(statuses)


def test_summer_knows_which_way_it_looks_in_autumn(summer, shared_data):
    recording = open_recording(shared_data / "garden_a" / "border_autumn")
    off, promised = [], []
    for info, estimate in map_frames(recording, lambda frame: summer.localize(frame.image), range(0, 300, 5)):
        if estimate.heading_rad is not None:
            off.append(abs(math.remainder(estimate.heading_rad - info.reference.heading_rad, 2 * math.pi)))
            promised.append(1.645 * math.sqrt(estimate.covariance[2, 2]))
    assert len(off) > 50
    assert math.degrees(np.median(off)) < 0.3
    assert math.degrees(max(off)) < 2
    assert np.mean(np.array(off) <= promised) >= 0.85


def test_noise_is_never_taken_for_the_garden(summer):
    rng = np.random.default_rng(0)
    found = [summer.localize(rng.integers(0, 256, (480, 480), dtype=np.uint8)).status for _ in range(20)]
    assert sum(status.has_pose for status in found) <= 1


def test_the_image_circle_is_found_where_it_is_not_declared(shared_data, tmp_path):
    source, folder = shared_data / "garden_a" / "border_summer", tmp_path / "border"
    (folder / "images").mkdir(parents=True)
    lines = (source / "frames.csv").read_text(encoding="utf-8").splitlines()
    chosen = lines[1::5]
    for line in chosen:
        image = line.split(",")[1]
        shutil.copy(source / image, folder / image)
    (folder / "frames.csv").write_text("\n".join([lines[0], *chosen]), encoding="utf-8")
    toml = (source / "recording.toml").read_text(encoding="utf-8").splitlines()
    undeclared = [line for line in toml if not line.startswith(("centre_px", "radius_px"))]
    (folder / "recording.toml").write_text("\n".join(undeclared), encoding="utf-8")
    built = build_map([open_recording(folder)])
    declared = open_recording(source).camera
    found = built.front_end.camera
    assert math.dist(found.centre_px, declared.centre_px) < 1
    assert found.radius_px == pytest.approx(declared.radius_px, abs=2)
    errors, _ = located(built, source, step=10)
    assert np.median(errors) < 0.35
