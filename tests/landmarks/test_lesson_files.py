import cv2
import pytest

from andante.errors import InputError
from andante.landmarks.coco import load_coco
from andante.landmarks.contact_sheet import contact_sheet
from andante.landmarks.labels import Labels
from andante.landmarks.lesson_files import check_new, write_lessons
from andante.landmarks.surroundings import Surroundings
from andante.landmarks.teaching import Relation, find_track, teach

SHED = Relation(0.2, 1.4, 1.6, 1.8)


@pytest.fixture(scope="module")
def taught(anchor_scene):
    """Recording, panoramas, and two lessons."""
    recording = anchor_scene.recording()
    surroundings = Surroundings(recording)
    track = find_track(anchor_scene(), recording, "bicycle", lambda done, total: None)
    lessons = [
        teach(name, track, relation, surroundings.geometry)
        for name, relation in (("shed", SHED), ("old birch", Relation(-3, 1, 1, 1)))
    ]
    return recording, surroundings, lessons


def test_files(taught, anchor_scene, tmp_path):
    recording, surroundings, lessons = taught
    folder = tmp_path / "monday.landmarks"
    files = write_lessons(folder, recording, surroundings, lessons)
    names = ["shed.json", "shed.png", "old birch.json", "old birch.png", "coco"]
    assert [file.name for file in files] == names
    assert sorted(path.name for path in folder.iterdir()) == sorted(names)
    assert [path.name for path in tmp_path.iterdir()] == ["monday.landmarks"]

    labels = Labels.load(folder / "shed.json")
    assert labels.content_hash == recording.content_hash()
    for index in range(anchor_scene.frames):
        assert labels.boxes[index].iou(anchor_scene.shed(index)) > 0.99
    assert labels.anchors[7].iou(anchor_scene.anchor(7)) > 0.99  # which a detector must not learn
    (shed, birch), geometry = load_coco(folder / "coco" / "annotations.json")
    assert (shed.name, birch.name) == ("shed", "old birch")
    assert geometry.width_px == 720
    for index, box in shed.boxes.items():
        assert box.iou(anchor_scene.shed(index)) > 0.95
    assert len(list((folder / "coco" / "images").iterdir())) == 40
    sheet = cv2.imread(str(folder / "shed.png"))
    assert sheet.shape[1] == 4 * 328 + 8


def test_contact_sheet_shows_the_landmark(taught):
    recording, surroundings, lessons = taught
    sheet = contact_sheet(recording, surroundings, lessons[0], 5)
    assert sheet.shape[1] == 4 * 328 + 8
    tile = sheet[8 : 8 + 200, 8 : 8 + 320].astype(int)
    mark = abs(tile - (182, 89, 0)).sum(axis=2) < 30
    rows, columns = mark.nonzero()
    assert abs(columns.mean() - 160) < 3  # in the middle of its tile
    inside = tile[(rows.min() + rows.max()) // 2, 160]
    assert abs(inside - (150, 90, 40)).sum() < 60  # the shed


def test_nothing_is_overwritten_and_nothing_half_done(taught, tmp_path, monkeypatch):
    recording, surroundings, lessons = taught
    with pytest.raises(InputError, match=r"exists already; choose another folder with --out"):
        check_new(tmp_path)

    (tmp_path / "file").write_bytes(b"")
    with pytest.raises(InputError, match=r"file/x/y cannot be made, .*file is no folder; choose another place"):
        check_new(tmp_path / "file" / "x" / "y")
    (tmp_path / "file").unlink()
    with monkeypatch.context() as patched:
        patched.setattr("os.access", lambda *_: False)
        with pytest.raises(InputError, match=r"x/y cannot be made, .* cannot be written to; choose another place with"):
            check_new(tmp_path / "x" / "y")
    check_new(tmp_path / "x" / "y")

    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr("andante.landmarks.lesson_files.export_coco", full)
    with pytest.raises(InputError, match=r"x cannot be written: No space left on device; choose another place"):
        write_lessons(tmp_path / "x", recording, surroundings, lessons)
    assert list(tmp_path.iterdir()) == []
