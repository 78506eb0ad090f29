import json
import math
from dataclasses import replace

import numpy as np
import pytest

from andante.errors import InputError
from andante.landmarks.boxes import Box
from andante.landmarks.labels import Labels, check_name, names_of, require_usable

BOX = Box(0.3, 0.2, 0.4, 0.3)


def labels(**changes):
    return replace(Labels("old shed", "monday", {3: BOX, 7: Box(math.pi, 0.1, 0.2, 0.1)}, frozenset({5})), **changes)


def test_what_is_saved_reads_back_exactly(tmp_path):
    taught = labels(content_hash="abc", anchors={3: Box(0.5, 0.1, 0.1, 0.1)})
    taught.save(tmp_path / "shed.json")
    assert Labels.load(tmp_path / "shed.json") == taught
    assert [path.name for path in tmp_path.iterdir()] == ["shed.json"]


def test_frames_and_names_are_listed_once_and_in_order():
    assert labels().frames == [3, 5, 7]
    assert names_of([labels(), labels(name="tree"), labels(recording="tuesday")]) == ["old shed", "tree"]


@pytest.mark.parametrize("name", ["", " ", "../shed", "a/b", "a\\b", ".hidden", "a\nb", "x" * 101, "a\x00", "森" * 67])
def test_a_name_that_could_be_a_path_is_refused(name):
    with pytest.raises(InputError, match="a landmark cannot be called"):
        labels(name=name)


@pytest.mark.parametrize("name", ["Schuppen 2", "Hütte", "a.b", "x", "x" * 100, "森" * 66, "corner_left-1"])
def test_usual_names_will_do(name):
    check_name(name)


@pytest.mark.parametrize(
    "box", [replace(BOX, width_rad=0.0), replace(BOX, azimuth_rad=3.5), replace(BOX, elevation_rad=math.nan)]
)
def test_a_box_that_no_picture_can_have_is_refused(box):
    with pytest.raises(InputError, match="frame 3 has a box with azimuth"):
        labels(boxes={3: box})


def test_a_frame_cannot_both_have_a_box_and_none():
    with pytest.raises(InputError, match="frame 3 has a box and is declared absent as well"):
        labels(absent=frozenset({3}))
    with pytest.raises(InputError, match="frame -1 does not exist"):
        labels(boxes={-1: BOX})


def test_labels_are_only_used_with_their_recording(garden):
    recording = garden.drive(garden.loop(10))
    require_usable(labels(content_hash=recording.content_hash()), recording, 0.0, 35.0)
    with pytest.raises(InputError, match="give the recording that they were made for"):
        require_usable(labels(content_hash="other"), recording, 0.0, 35.0)
    with pytest.raises(InputError, match="speak of frame 12, recording 'monday' has frames 0 to 9"):
        require_usable(labels(boxes={12: BOX}), recording, 0.0, 35.0)
    with pytest.raises(InputError, match="has 2 labels in 'monday', at least 20 are needed"):
        require_usable(labels(), recording, 0.0, 35.0, least=20)
    with pytest.raises(InputError, match="has 0 labels"):
        require_usable(labels(boxes={}), recording, 0.0, 35.0)
    high = Box(0.0, np.radians(50.0), 0.1, np.radians(4.0))
    with pytest.raises(InputError, match=r"box of frame 3 lies at 48.0 to 52.0 degrees of elevation, outside"):
        require_usable(labels(boxes={3: high}), recording, 0.0, 35.0)


def test_a_file_that_is_something_else_is_refused_in_one_line(tmp_path):
    path = tmp_path / "shed.json"
    with pytest.raises(InputError, match="cannot be read: No such file"):
        Labels.load(path)
    labels().save(path)
    good = json.loads(path.read_text())
    for change, message in [
        ({"schema": 2}, "shed.json cannot be used: they have schema 2, this version .* reads 1; upgrade andante"),
        ({"format": "other"}, "format: input should be"),
        ({"extra": 1}, "extra: extra inputs are not permitted"),
        ({"boxes": [{**good["boxes"][0], "width_rad": -1}]}, r"boxes.0.width_rad: input should be greater than 0"),
        ({"boxes": [good["boxes"][0]] * 2}, "frame 3 has two boxes"),
        ({"name": "../x"}, "labels .*shed.json cannot be used: a landmark cannot be called"),
    ]:
        path.write_text(json.dumps(good | change))
        with pytest.raises(InputError, match=message) as fault:
            Labels.load(path)
        assert "\n" not in str(fault.value)
    path.write_text("{")
    with pytest.raises(InputError, match="cannot be used: invalid json"):
        Labels.load(path)
    with pytest.raises(InputError, match="cannot be written: No such file"):
        labels().save(tmp_path / "missing" / "shed.json")
