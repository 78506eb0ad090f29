import json
import sys
from dataclasses import replace

import cv2
import numpy as np
import pytest

from andante.camera import PanoramaGeometry
from andante.data import CameraSpec
from andante.errors import ConfigError, InputError, LearningError, MissingExtraError
from andante.landmarks.boxes import Box
from andante.landmarks.detector import LandmarkDetector
from andante.landmarks.detector_file import DetectorHeader, Landmark, written
from andante.landmarks.examples import Examples
from andante.landmarks.heatmaps import Grid
from andante.landmarks.labels import Labels
from andante.landmarks.training import TrainingConfig, train_detector
from andante.recordings import MemoryRecording

torch = pytest.importorskip("torch", reason="learning landmarks needs the extra torch")
pytest.importorskip("onnx", reason="landmark detectors are written with the extra onnx")
pytest.importorskip("onnxruntime", reason="landmark detectors run with onnxruntime")

from andante.landmarks import training  # noqa: E402
from andante.landmarks.augmentation import _greyed, _occluded, augmented  # noqa: E402
from andante.landmarks.learning import learnt  # noqa: E402
from andante.landmarks.network import LandmarkNetwork  # noqa: E402

GEOMETRY = PanoramaGeometry(128, 32, -10.0, 50.0)
GRID = Grid(GEOMETRY, 8)
PANORAMA = CameraSpec(model="panorama")


def scene(column: int, shift: int = 0) -> np.ndarray:
    """A striped landmark before a random background that stays the same."""
    rng = np.random.default_rng(0)
    image = cv2.GaussianBlur(rng.integers(60, 200, (32, 128, 3)).astype(np.uint8), (5, 5), 0)
    image = np.roll(image, shift, axis=1)
    stripes = np.where(np.arange(20)[None, :, None] % 4 < 2, 20, 235) * np.ones((14, 1, 3))
    columns = (column + np.arange(20)) % 128
    image[12:26, columns] = stripes
    return image


def box_at(column: int) -> Box:
    return GRID.box_of((np.array([column + 10.0, 19.0, 20.0, 14.0]) - [4, 4, 0, 0]) / 8.0)


def drive(frames: int) -> tuple[MemoryRecording, Labels]:
    columns = [9 * i % 128 for i in range(frames)]
    images = [scene(column, 5 * i) for i, column in enumerate(columns)]
    recording = MemoryRecording(images, np.arange(frames) * 0.5, PANORAMA, name="monday")
    return recording, Labels("stripes", "monday", {i: box_at(column) for i, column in enumerate(columns)})


CONFIG = TrainingConfig(GEOMETRY, steps=60, batch=6, learning_rate=0.01, held_out=0.3, check_every=20, least_labels=6)


@pytest.fixture(scope="module")
def detector() -> LandmarkDetector:
    recording, labels = drive(6)
    return train_detector([(recording, [labels])], CONFIG)


def test_six_pictures_are_learnt_in_seconds(detector):
    recording, labels = drive(6)
    for info in recording.infos:
        (found,) = detector.detect(recording.load(info, colour=True), PANORAMA)
        assert found.name == "stripes"
        assert found.box.iou(labels.boxes[info.index]) > 0.5
        assert 0.5 <= found.score <= 1.0
    notes = detector.header.notes
    assert notes["steps"] == 60
    assert notes["stopped"] == "all steps done"
    assert notes["held_out"]["stripes"]["found"] > 0.5


def test_the_file_does_what_torch_does(detector):
    with torch.random.fork_rng():
        torch.manual_seed(3)
        network = LandmarkNetwork(2)
        network(255 * torch.rand(4, 3, 32, 128))  # so that there is something to normalise by
    network.eval()
    landmarks = tuple(Landmark(name=name, slope=1.0, offset=0.0, threshold=0.5) for name in "ab")
    copied = LandmarkDetector(written(DetectorHeader.of(GEOMETRY, landmarks, {}), network.folded()))
    panorama = scene(30)
    with torch.no_grad():
        told = network(torch.from_numpy(panorama[None]).permute(0, 3, 1, 2).float())[0].numpy()
    heat, shape = copied.maps(panorama)
    assert np.allclose(heat, told[:, 0], atol=1e-4)
    assert np.allclose(shape, told[:, 1:], atol=1e-4)


def test_one_that_cannot_be_told_does_not_spoil_the_others(monkeypatch):
    recording, labels = drive(6)
    hidden = replace(labels, name="hidden")
    score = training._score

    def judged(name, *rest):
        if name == "hidden":
            raise LearningError("landmark 'hidden': 1 right and 9 wrong places")
        return score(name, *rest)

    monkeypatch.setattr(training, "_score", judged)
    detector = train_detector([(recording, [labels, hidden])], CONFIG)
    assert set(detector.names) == {"stripes", "hidden"}
    assert detector.header.notes["never_found"] == {"hidden": "landmark 'hidden': 1 right and 9 wrong places"}
    assert detector.header.notes["held_out"]["hidden"]["found"] == 0.0
    found = [one.name for info in recording.infos for one in detector.detect(recording.load(info), PANORAMA)]
    assert set(found) == {"stripes"}


@pytest.mark.parametrize("turns", [1, 3, 7])
def test_a_turned_robot_sees_the_same_turned(detector, turns):
    panorama = scene(30)
    heat, shape = detector.maps(panorama)
    turned = detector.maps(np.roll(panorama, 16 * turns, axis=1))
    assert np.allclose(turned[0], np.roll(heat, 2 * turns, axis=-1), atol=1e-3)
    assert np.allclose(turned[1], np.roll(shape, 2 * turns, axis=-1), atol=1e-3)


def test_grey_pictures_will_do(detector):
    grey = cv2.cvtColor(scene(50), cv2.COLOR_BGR2GRAY)
    assert detector.detect(grey, PANORAMA)[0].box.iou(box_at(50)) > 0.4


def test_the_same_seed_learns_the_same():
    short = TrainingConfig(GEOMETRY, steps=8, batch=6)
    first, second = (learnt(examples(12), examples(6), GRID, short, None)[0].state_dict() for _ in range(2))
    assert all(torch.equal(values, second[name]) for name, values in first.items())


def examples(count: int, *, anchor: Box | None = None) -> Examples:
    cells = np.repeat(GRID.cells_of([box_at(40)])[None], count, axis=0)
    anchors = np.repeat(GRID.cells_of([anchor])[None], count, axis=0)
    panoramas = np.repeat(scene(40)[None], count, axis=0)
    return Examples(panoramas, cells, np.ones((count, 1), bool), np.zeros(count, np.int64), anchors)


def test_augmentation_moves_boxes_with_what_is_in_them():
    batch = augmented(examples(24), GRID, np.random.default_rng(0))
    assert batch.pictures.shape == (24, 3, 32, 128)
    assert 0 <= float(batch.pictures.min()) <= float(batch.pictures.max()) <= 255
    seen = 0
    for picture, (box,), (counts,) in zip(batch.pictures.numpy(), batch.cells, batch.counts, strict=True):
        if not (counts and np.isfinite(box[0])):
            continue
        x, y = (box[:2] + 0.5) * 8
        middle = picture.mean(0)[np.clip(int(y), 1, 30), (int(x) + np.arange(-8, 8)) % 128]
        seen += np.abs(np.diff(middle)).max() > 0.25 * np.ptp(picture.mean(0))
    assert seen > 12


def test_half_of_the_pictures_have_no_colour():
    pictures = torch.rand((40, 3, 4, 5), generator=torch.Generator().manual_seed(1))
    greyed = _greyed(pictures, torch.Generator().manual_seed(2)).numpy()
    grey = np.ptp(greyed, axis=1).max(axis=(1, 2)) < 1e-6
    assert 10 < grey.sum() < 30
    assert np.array_equal(greyed[~grey], pictures.numpy()[~grey])
    of_camera = cv2.cvtColor(pictures[int(np.flatnonzero(grey)[0])].numpy().transpose(1, 2, 0), cv2.COLOR_BGR2GRAY)
    assert greyed[grey][0, 0] == pytest.approx(of_camera, abs=1e-3)


def test_the_anchor_comes_and_goes():
    """Its colour, which nothing else has, is where it was in about half of the pictures, and elsewhere in half."""
    column, colour = 100, np.array([255, 0, 255])
    given = examples(200, anchor=box_at(column))
    given.panoramas[:, 12:26, column : column + 20] = colour
    pictures, _ = _occluded(
        torch.from_numpy(given.panoramas.transpose(0, 3, 1, 2) / np.float32(255)),
        np.full((200, 1, 4), np.nan),
        given.anchors,
        GRID,
        np.random.default_rng(1),
    )
    purple = np.abs(255 * pictures.numpy() - colour[:, None, None]).max(axis=1) < 1
    here = purple[:, 12:26, column : column + 20].mean(axis=(1, 2)) > 0.5
    elsewhere = purple.sum(axis=(1, 2)) - purple[:, 12:26, column : column + 20].sum(axis=(1, 2)) > 100
    assert 0.3 < here.mean() < 0.6  # other things stand before it at times
    assert 0.25 < elsewhere.mean() < 0.6


def test_what_is_kept_in_a_file_comes_back(detector, tmp_path):
    path = tmp_path / "stripes.onnx"
    detector.save(path)
    loaded = LandmarkDetector.load(path, names=["stripes"], sha256=detector.sha256)
    assert loaded.header == detector.header
    assert loaded.geometry == GEOMETRY
    assert repr(loaded) == "LandmarkDetector(stripes)"
    assert loaded.detect(scene(50), PANORAMA) == detector.detect(scene(50), PANORAMA)


def test_a_file_that_is_not_a_whole_detector_is_refused(detector, tmp_path):
    path = tmp_path / "stripes.onnx"
    with pytest.raises(InputError, match="cannot be read: No such file"):
        LandmarkDetector.load(path)
    detector.save(path)
    data = path.read_bytes()
    with pytest.raises(InputError, match="finds stripes, but not tree; give the detector"):
        LandmarkDetector.load(path, names=["stripes", "tree"])
    with pytest.raises(InputError, match="expected 0000000000000000"):
        LandmarkDetector.load(path, sha256="0" * 64)
    changed = bytearray(data)
    changed[len(data) // 2] ^= 1
    for broken, message in [
        (bytes(changed), "was changed after it was written"),
        (data[:-1000], "does not end with a checksum"),
        (b"", "does not end with a checksum"),
    ]:
        path.write_bytes(broken)
        with pytest.raises(InputError, match=message):
            LandmarkDetector.load(path)


def test_a_file_that_contradicts_itself_is_refused(monkeypatch):
    network = LandmarkNetwork(2)
    landmark = {"slope": 1.0, "offset": 0.0, "threshold": 0.5}
    two = tuple(Landmark(name=name, **landmark) for name in "ab")

    def file(change):
        values = json.loads(DetectorHeader.of(GEOMETRY, two, {}).model_dump_json(by_alias=True))
        changed = json.dumps(values | change)
        with monkeypatch.context() as patched:
            patched.setattr(DetectorHeader, "model_dump_json", lambda self, **_: changed)
            return written(DetectorHeader.of(GEOMETRY, two, {}), network.folded())

    one = [{"name": "a", **landmark}]
    for change, message in [
        ({"schema": 2}, "this detector has schema 2, this version of andante reads 1; upgrade andante"),
        ({"landmarks": one}, "names 1 landmarks, its network has"),
        ({"landmarks": one * 2}, "two landmarks of one name"),
        (
            {"landmarks": [{"name": "../a", **landmark}] * 2},
            "cannot be used: a landmark cannot be called",
        ),
        ({"min_deg": 60.0}, "a panorama needs elevations"),
        ({"width_px": 256}, "its network has"),
    ]:
        with pytest.raises(InputError, match=message):
            LandmarkDetector(file(change))


def test_learning_says_what_it_needs(monkeypatch):
    recording, labels = drive(6)
    with pytest.raises(InputError, match="has 6 labels in 'monday', at least 20"):
        train_detector([(recording, [labels])], TrainingConfig(GEOMETRY))
    with pytest.raises(ConfigError, match="multiples of 16 px, got 128 x 40"):
        TrainingConfig(PanoramaGeometry(128, 40))
    with pytest.raises(ConfigError, match=r"held_out = 0.9 is not allowed"):
        TrainingConfig(held_out=0.9)
    with pytest.raises(ConfigError, match="batch = 0 is not allowed"):
        TrainingConfig(batch=0)
    with pytest.raises(InputError, match=r"taught in recording 'monday', so it is not one that shows none of them"):
        train_detector([(recording, [labels])], TrainingConfig(GEOMETRY), elsewhere=[recording])
    lost = TrainingConfig(GEOMETRY, steps=1, batch=6, held_out=0.3, least_labels=6)
    with pytest.raises(LearningError, match=r"landmark 'stripes': .* cannot be told apart"):
        train_detector([(recording, [labels])], lost)
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'andante\[torch\]'"):
        train_detector([(recording, [labels])], lost)
