import json
import math

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.angles import wrapped
from andante.camera import PanoramaGeometry
from andante.errors import InputError
from andante.landmarks.boxes import Box
from andante.landmarks.coco import box_pixels, export_coco, from_coco, load_coco, pixel_box, to_coco
from andante.landmarks.labels import Labels

GEOMETRY = PanoramaGeometry(640, 112, -5.0, 60.0)


def inside(draw_height):
    return math.radians(-5.0) + draw_height / 2.0, math.radians(60.0) - draw_height / 2.0


@st.composite
def boxes(draw):
    height = draw(st.floats(0.01, 1.1))
    low, high = inside(height)
    azimuth = draw(st.floats(-math.pi, math.pi, exclude_min=True))
    return Box(azimuth, draw(st.floats(low, high)), draw(st.floats(0.01, 2 * math.pi)), height)


def close(first: Box, second: Box) -> bool:
    turn = abs(wrapped(first.azimuth_rad - second.azimuth_rad))
    rest = [first.elevation_rad - second.elevation_rad, first.width_rad - second.width_rad]
    return max(turn, *map(abs, rest), abs(first.height_rad - second.height_rad)) < 1e-9


@given(boxes())
def test_boxes_survive_pixels(box):
    pixels = box_pixels(box, GEOMETRY)
    assert 0 <= pixels[0] < 640
    assert close(pixel_box(pixels, GEOMETRY), box)


@given(st.dictionaries(st.integers(0, 50), boxes(), min_size=1), st.sets(st.integers(60, 70)))
def test_labels_survive_coco(found, absent):
    given_labels = [
        Labels("shed", "monday", found, frozenset(absent), "hash"),
        Labels("tree", "monday", {99: Box(0.1, 0.1, 0.1, 0.1)}),
    ]
    given_labels[1] = Labels("tree", "monday", given_labels[1].boxes, content_hash="hash")
    coco = json.loads(json.dumps(to_coco(given_labels, GEOMETRY)))
    read, geometry = from_coco(coco)
    assert geometry == GEOMETRY
    assert [one.name for one in read] == ["shed", "tree"]
    assert read[0].absent == absent
    assert read[0].boxes.keys() == found.keys()
    assert all(close(read[0].boxes[frame], box) for frame, box in found.items())
    for annotation in coco["annotations"]:
        x, y, width, height = annotation["bbox"]
        assert -1e-9 <= x < x + width <= 640 + 1e-9
        assert -1e-6 <= y < y + height <= 112 + 1e-6
    assert [one["id"] for one in coco["annotations"]] == list(range(1, len(coco["annotations"]) + 1))


def test_a_box_over_the_seam_is_two_annotations_of_one_group():
    coco = to_coco([Labels("shed", "monday", {4: Box(math.pi, 0.5, 0.2, 0.2)})], GEOMETRY)
    right, left = coco["annotations"]
    assert right["seam_group"] == left["seam_group"]
    assert right["bbox"][0] + right["bbox"][2] == pytest.approx(640)
    assert left["bbox"][0] == 0
    assert right["bbox"][2] == pytest.approx(left["bbox"][2]) == pytest.approx(0.1 * 640 / (2 * math.pi))


def test_what_lies_beyond_the_picture_is_cut_off():
    box = Box(0.0, math.radians(-5.0), 0.2, math.radians(10.0))
    coco = to_coco([Labels("shed", "monday", {4: box})], GEOMETRY)
    (read,), _ = from_coco(coco)
    assert np.degrees(read.boxes[4].elevation_rad - read.boxes[4].height_rad / 2) == pytest.approx(-5)
    assert np.degrees(read.boxes[4].height_rad) == pytest.approx(5)


def test_the_export_is_readable_by_itself(garden, tmp_path):
    recording = garden.drive(garden.loop(6), fisheye=True)
    geometry = PanoramaGeometry(64, 16, 5.0, 60.0)
    labels = [Labels("shed", "monday", {1: Box(0.0, 0.5, 0.3, 0.3), 4: Box(3.0, 0.5, 0.5, 0.2)}, frozenset({2}))]
    path = export_coco(labels, recording, tmp_path / "coco", geometry)
    read, _ = load_coco(path)
    assert read[0].frames == [1, 2, 4]
    for image in json.loads(path.read_text())["images"]:
        assert cv2.imread(str(path.parent / image["file_name"])).shape == (16, 64, 3)
    with pytest.raises(InputError, match="cannot be made: File exists"):
        export_coco(labels, recording, tmp_path / "coco", geometry)


def test_what_cannot_be_one_file_is_refused(tmp_path):
    box = {1: Box(0.0, 0.5, 0.3, 0.3)}
    with pytest.raises(InputError, match="no labels to export"):
        to_coco([], GEOMETRY)
    with pytest.raises(InputError, match="labels of 2 recordings"):
        to_coco([Labels("a", "monday", box), Labels("b", "tuesday", box)], GEOMETRY)
    with pytest.raises(InputError, match="two sets of labels are of one landmark"):
        to_coco([Labels("a", "monday", box), Labels("a", "monday", box)], GEOMETRY)
    with pytest.raises(InputError, match="no labels of landmarks as Andante exports them"):
        from_coco({"images": []})
    (tmp_path / "x.json").write_text("[")
    with pytest.raises(InputError, match="is no JSON"):
        load_coco(tmp_path / "x.json")
