"""From labels to a map that goes by landmarks, all through the command line, past a striped tower in a garden."""

import shutil
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest
from safetensors import safe_open
from safetensors.numpy import save

from andante.camera import PanoramaGeometry, rays
from andante.data import CameraSpec, Frame, FrameInfo
from andante.landmarks.boxes import Box
from andante.landmarks.labels import Labels
from andante.mapping import SlowMap
from andante.recordings import open_recording, write_recording

HIGH_RAD, WIDE_M = np.radians(32), 3.0
SIDE = 120


def box_of_tower(pose) -> Box:
    """The tower stands in the middle of the garden."""
    away = -np.array([pose.x_m, pose.y_m])
    azimuth = np.angle(np.exp(1j * (np.arctan2(away[1], away[0]) - pose.heading_rad)))
    return Box(float(azimuth), HIGH_RAD / 2, float(2 * np.arctan(WIDE_M / 2 / np.hypot(*away))), HIGH_RAD)


def with_tower(image, pose, camera):
    box = box_of_tower(pose)
    azimuth, elevation, inside = rays(camera, (SIDE, SIDE))
    across = np.angle(np.exp(1j * (azimuth - box.azimuth_rad))) / box.width_rad
    stripes = np.where(np.floor(5 * (across + 0.5)) % 2 == 0, 235, 15)
    return np.where(inside & (np.abs(across) < 0.5) & (elevation < HIGH_RAD), stripes, image).astype(np.uint8)


def write(folder: Path, recording) -> Path:
    camera = recording.camera
    # An image a second: at five, as these drives have, the robot would be faster than trackers believe.
    infos = (
        replace(one.info, odometry=one.info.reference, timestamp_s=5 * one.info.timestamp_s)
        for one in recording.frames()
    )
    pictures = (with_tower(one.image, one.info.reference, camera) for one in recording.frames())
    frames = (Frame(*both) for both in zip(infos, pictures, strict=True))
    write_recording(folder, frames, name=folder.name, camera=camera, image_format="png")
    return folder


def write_labels(folder: Path, recording: Path, name: str = "tower", frames=None) -> Path:
    """What teaching would have written."""
    opened = open_recording(recording)
    boxes = {one.index: box_of_tower(one.reference) for one in opened.infos[:frames]}
    folder.mkdir(exist_ok=True)
    Labels(name, opened.name, boxes, content_hash=opened.content_hash()).save(folder / f"{name}.json")
    return folder


@pytest.fixture(scope="module")
def drives(posts, tmp_path_factory):
    folder = tmp_path_factory.mktemp("drives")
    monday, tuesday = posts.two_days(fisheye=True)
    friday = posts.another_day(fisheye=True)
    days = [write(folder / one.name, one) for one in (monday, tuesday, friday)]
    for day in days[:2]:
        write_labels(day.with_name(f"{day.name}.landmarks"), day)
    return SimpleNamespace(folder=folder, monday=days[0], tuesday=days[1], friday=days[2])


@pytest.fixture(scope="module")
def tiny():
    """Learning on a small panorama, in seconds."""
    for package in ("torch", "onnx", "onnxruntime"):
        pytest.importorskip(package, reason=f"learning landmarks needs {package}")
    from andante.landmarks import training

    with pytest.MonkeyPatch.context() as patched:
        geometry = PanoramaGeometry(128, 32, 0.0, 60.0)
        made = partial(training.TrainingConfig, geometry=geometry, batch=6, learning_rate=0.01, check_every=20)
        patched.setattr(training, "TrainingConfig", made)
        yield


@pytest.fixture(scope="module")
def learnt(drives, tiny, andante):
    """The detector's file, and what the command said."""
    path = drives.folder / "tower.onnx"
    folders = [f"{day}.landmarks" for day in (drives.monday, drives.tuesday)]
    return path, andante("learn-landmarks", *folders, "-o", path, "--steps", 100, "--json")


@pytest.fixture(scope="module")
def mapped(drives, learnt, andante):
    path = drives.folder / "garden.andante"
    return path, andante("map", drives.monday, drives.tuesday, "--landmarks", learnt[0], "-o", path, "--json")


def test_learning(learnt, drives):
    path, answer = learnt
    assert answer.exit_code == 0, answer.stderr
    values = answer.json
    (tower,) = values["landmarks"]
    assert (tower["name"], tower["labels"]) == ("tower", 120)
    assert tower["found"] > 0.5
    assert tower["false_positives"] < 0.2
    assert 0.25 <= tower["threshold"] <= 1.0
    assert values["bytes"] == path.stat().st_size
    assert values["steps"] == 100
    assert values["recordings"] == [str(drives.monday), str(drives.tuesday)]
    assert values["next"] == (f"andante map {drives.monday} {drives.tuesday} --landmarks {path} -o tower.andante")


def test_tables(drives, tiny, andante, tmp_path):
    options = ("--elsewhere", drives.friday, "--steps", 60, "--seed", 3)
    answer = andante("learn-landmarks", f"{drives.monday}.landmarks", "-o", tmp_path / "a.onnx", *options)
    assert answer.exit_code == 0, answer.stderr
    for words in ("landmark", "labels used", "found [%]", "false positives [%]", "threshold", "tower", "60 steps in"):
        assert words in " ".join(answer.stdout.split())  # however long the path is
    assert f"hint: next: andante map {drives.monday} --landmarks" in answer.stderr


def test_the_map_carries_what_it_needs(mapped, learnt):
    path, answer = mapped
    assert answer.exit_code == 0, answer.stderr
    assert [one["name"] for one in answer.json["landmarks"]] == ["tower"]
    assert answer.json["seconds"]["landmarks"] > 0
    assert SlowMap.load(path).landmarks.detector == learnt[0].read_bytes()


def test_localizing_needs_the_map_alone(mapped, drives, andante, tmp_path):
    alone = shutil.copy(mapped[0], tmp_path / "a.andante")
    image = drives.friday / open_recording(drives.friday).infos[0].image
    assert "from tower (" in andante("localize", alone, image, "--json").json["reason"]
    estimates = andante("localize", alone, drives.friday, "--json").json["estimates"]
    assert np.mean(["from tower (" in one["reason"] for one in estimates]) > 0.5
    figures = andante("evaluate", alone, drives.friday, "--json").json
    assert figures["median_m"] < 0.5
    track = andante("track", alone, drives.friday, "--json")
    assert track.exit_code == 0, track.stderr
    assert track.json["median_m"] < 0.5


def test_a_recording_that_was_taught_in_is_not_elsewhere(drives, tiny, andante, fails, tmp_path):
    options = ("-o", tmp_path / "a.onnx", "--elsewhere", drives.monday)
    fails(
        andante("learn-landmarks", f"{drives.monday}.landmarks", *options),
        "landmarks were taught in recording 'monday', so it is not one that shows none of them; leave it out",
    )


def test_labels_of_a_newer_version(drives, andante, fails, tmp_path):
    labels = (Path(f"{drives.monday}.landmarks") / "tower.json").read_text()
    (tmp_path / "tower.json").write_text(labels.replace('"schema": 1', '"schema": 7'))
    options = ("--recordings", drives.monday, "-o", tmp_path / "a.onnx")
    message = "labels .*tower.json cannot be used: they have schema 7, this version of andante reads 1; upgrade andante"
    fails(andante("learn-landmarks", tmp_path, *options), message)


@pytest.fixture(scope="module")
def of_oak(learnt):
    """A whole detector of another landmark, for the same panoramas."""
    from andante.landmarks.detector import LandmarkDetector
    from andante.landmarks.detector_file import DetectorHeader, Landmark, written
    from andante.landmarks.network import LandmarkNetwork

    oak = Landmark(name="oak", slope=1.0, offset=0.0, threshold=0.99)
    header = DetectorHeader.of(LandmarkDetector.load(learnt[0]).geometry, (oak,), {})
    return written(header, LandmarkNetwork(1).folded())


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda good, oak: bytes([*good[:900], good[900] ^ 1, *good[901:]]), "was changed after it was written"),
        (lambda good, oak: good[:-1000], "does not end with a checksum as landmark detectors do"),
        (lambda good, oak: oak, "finds oak, but not tower; give the detector that was taught these"),
    ],
)
def test_a_map_whose_detector_was_altered(change, message, mapped, of_oak, drives, andante, fails, tmp_path):
    with safe_open(mapped[0], framework="numpy") as file:
        metadata, arrays = file.metadata(), {name: file.get_tensor(name) for name in file.keys()}  # noqa: SIM118
    good = arrays["landmarks.detector"].tobytes()
    arrays["landmarks.detector"] = np.frombuffer(change(good, of_oak), np.uint8)
    path = tmp_path / "a.andante"
    path.write_bytes(save(arrays, metadata=metadata))
    fails(andante("localize", path, drives.friday), f"the landmark detector in a.andante {message}")


def test_detector_files_that_are_none(learnt, of_oak, drives, andante, fails, tmp_path):
    good, path = learnt[0].read_bytes(), tmp_path / "a.onnx"
    for data, message in [
        (b"", "a.onnx does not end with a checksum as landmark detectors do; it is another file or was cut short"),
        (good[: len(good) // 2], "a.onnx does not end with a checksum"),
        (good[:900] + b"xx" + good[902:], "a.onnx was changed after it was written: its checksum does not fit"),
        (of_oak, "no landmark is seen in any frame with a position|no landmark is seen in 20 frames or more"),
    ]:
        path.write_bytes(data)
        fails(andante("map", drives.monday, drives.tuesday, "--landmarks", path, "-o", tmp_path / "a.andante"), message)
        assert not (tmp_path / "a.andante").exists()


def test_what_a_map_cannot_learn_is_told(learnt, drives, andante, fails, monkeypatch, tmp_path):
    command = ("map", drives.monday, drives.tuesday, "--landmarks", learnt[0], "-o", tmp_path / "a.andante")
    message = "landmarks need reference poses in metres, a map with positions = 'odometry' goes without; ask for"
    fails(andante(*command, "--positions", "odometry"), message)
    monkeypatch.setattr("andante.landmarks.detector.LandmarkDetector.names", ("tower", "oak"))
    answer = andante(*command, "--json")
    assert answer.json["hints"] == ["seen too seldom to be learnt and tried, so the map goes without: oak"]


def test_localizing_without_onnxruntime(mapped, drives, andante, fails, monkeypatch):
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    message = r"onnxruntime is not installed; install it with: pip install 'andante\[landmarks\]'"
    fails(andante("localize", mapped[0], drives.friday), message)
    assert andante("info", mapped[0]).exit_code == 0


def test_what_is_known_of_landmarks(mapped, andante, tmp_path):
    values = andante("info", mapped[0], "--json").json
    (tower,) = values["landmarks"]
    assert np.hypot(tower["x_m"], tower["y_m"]) < 0.3
    assert 0 < tower["error_m"] < 1
    assert all(set(one) == {"x_m", "y_m", "radius_m", "frames"} for one in values["weak_places"])
    picture = tmp_path / "landmarks.png"
    answer = andante("info", mapped[0], "--picture", picture)
    assert answer.exit_code == 0
    assert "landmarks.png shows where the landmarks stand" in answer.stderr
    assert picture.read_bytes().startswith(b"\x89PNG")
    told = andante("info", mapped[0]).stdout
    for words in ("Landmarks", "expected error [m]", "tower"):
        assert words in told


def test_where_another_one_would_help(mapped, andante, tmp_path):
    slowmap = SlowMap.load(mapped[0])
    slowmap.landmarks.places[:60, 2] = np.inf
    slowmap.save(tmp_path / "a.andante")
    places = andante("info", tmp_path / "a.andante", "--json").json["weak_places"]
    assert places
    assert places[0]["radius_m"] is None
    told = andante("info", tmp_path / "a.andante").stdout
    for words in ("Teach another landmark near", "none is seen"):
        assert words in told


def test_a_map_can_be_shown_without_onnxruntime_but_not_used(mapped, drives, andante, fails, monkeypatch):
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    assert andante("info", mapped[0]).exit_code == 0
    image = drives.friday / open_recording(drives.friday).infos[0].image
    fails(andante("localize", mapped[0], image), r"onnxruntime is not installed; .*'andante\[landmarks\]'")


def test_an_updated_map_keeps_its_landmarks(mapped, drives, andante, tmp_path):
    path = tmp_path / "a.andante"
    shutil.copy(mapped[0], path)
    answer = andante("update", path, drives.friday, "--force", "--json")
    assert answer.exit_code == 0, answer.stderr
    assert SlowMap.load(path).landmarks.detector == SlowMap.load(mapped[0]).landmarks.detector
    image = drives.monday / open_recording(drives.monday).infos[0].image
    assert "tower" in andante("localize", path, image, "--json").json["reason"]


def test_an_exported_map_says_what_it_leaves_out(mapped, andante, tmp_path):
    answer = andante("export", mapped[0], "-o", tmp_path / "a.onnx", "--json")
    assert answer.exit_code == 0, answer.stderr
    assert "hint: the landmarks of this map are left out" in answer.stderr


def test_a_recording_that_moved(drives, tiny, andante, fails, tmp_path):
    labels = write_labels(tmp_path / "labels", drives.monday)
    options = (labels, "-o", tmp_path / "a.onnx", "--steps", 40)
    fails(andante("learn-landmarks", *options), "recording 'monday', which is not beside .* --recordings REC")
    other = (*options, "--recordings", drives.tuesday)
    fails(andante("learn-landmarks", *other), "recording 'monday', which is not beside .* --recordings REC")
    moved = shutil.copytree(drives.monday, tmp_path / "elsewhere" / "renamed")
    answer = andante("learn-landmarks", *options, "--recordings", moved, "--json")
    assert answer.exit_code == 0, answer.stderr
    assert answer.json["recordings"] == [str(moved)]


def test_another_recording_of_the_same_name_is_not_taken(drives, andante, fails, tmp_path):
    labels = write_labels(tmp_path / "monday.landmarks", drives.monday)
    shutil.copytree(drives.tuesday, tmp_path / "monday")
    fails(andante("learn-landmarks", labels, "-o", tmp_path / "a.onnx"), "not beside them with the same content")


def test_folders_that_hold_no_labels(drives, andante, fails, tmp_path):
    out = ("-o", tmp_path / "a.onnx")
    fails(andante("learn-landmarks", tmp_path / "no", *out), "no is no folder of labels; .*andante teach")
    fails(andante("learn-landmarks", tmp_path, *out), r"holds no labels \(NAME.json\); make one with: andante teach")
    fails(andante("learn-landmarks", drives.monday, *out), r"holds no labels .*; give .*monday.landmarks")
    (tmp_path / "shed.json").write_text("{}")
    fails(andante("learn-landmarks", tmp_path, *out), "labels .*shed.json cannot be used: .*; teach the landmark again")


def test_labels_given_twice(drives, andante, fails, tmp_path):
    folder = f"{drives.monday}.landmarks"
    answer = andante("learn-landmarks", folder, folder, "-o", tmp_path / "a.onnx")
    fails(answer, "landmark 'tower' of recording 'monday' has labels twice")


def test_too_few_labels(drives, tiny, andante, fails, tmp_path):
    labels = write_labels(tmp_path / "labels", drives.monday, frames=5)
    answer = andante("learn-landmarks", labels, "-o", tmp_path / "a.onnx", "--recordings", drives.monday)
    fails(answer, "landmark 'tower' has 5 labels in 'monday', at least 20 are needed")
    assert not (tmp_path / "a.onnx").exists()


def test_without_torch(drives, tiny, andante, fails, tmp_path, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    answer = andante("learn-landmarks", f"{drives.monday}.landmarks", "-o", tmp_path / "a.onnx")
    fails(answer, r"torch is not installed; .*'andante\[torch\]'")


def test_detectors_and_drives_that_no_map_can_use(drives, learnt, andante, fails, write_drive, tmp_path):
    out, monday = ("-o", tmp_path / "a.andante"), drives.monday
    folder = f"{monday}.landmarks"
    fails(andante("map", monday, "--landmarks", folder, *out), "is a folder; .*andante learn-landmarks .*monday")
    fails(andante("map", monday, "--landmarks", tmp_path / "no", *out), "no cannot be read: No such file")
    (tmp_path / "bad.onnx").write_bytes(b"no network")
    fails(andante("map", monday, "--landmarks", tmp_path / "bad.onnx", *out), "does not end with a checksum")
    blind = write_drive(tmp_path / "blind", reference=False)
    fails(andante("map", blind, "--landmarks", learnt[0], *out), "landmarks need reference poses in metres, 'blind'")
    flat = tmp_path / "flat"
    frames = (Frame(FrameInfo(i, "", i / 5, reference=None), np.full((30, 120), 9, np.uint8)) for i in range(3))
    write_recording(flat, frames, name="flat", camera=CameraSpec(model="panorama"), image_format="png")
    fails(andante("map", flat, "--landmarks", learnt[0], *out), "the camera of 'flat' is a panorama")
    assert not (tmp_path / "a.andante").exists()


def test_a_damaged_detector_in_a_map_is_refused(mapped, andante, fails, tmp_path):
    slowmap = SlowMap.load(mapped[0])
    data = bytearray(slowmap.landmarks.detector)
    data[len(data) // 2] ^= 1
    object.__setattr__(slowmap.landmarks, "detector", bytes(data))
    slowmap.save(tmp_path / "a.andante")
    fails(
        andante("info", tmp_path / "a.andante"), "the landmark detector in a.andante was changed after it was written"
    )
