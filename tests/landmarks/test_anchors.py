"""Anchors all around: one detection a thing, wherever the cuts and the seam are."""

import numpy as np
import pytest

from andante.camera import PanoramaGeometry
from andante.landmarks.anchors import find_anchors, near_and_far
from andante.landmarks.boxes import Box
from andante.landmarks.cuts import Cuts
from andante.landmarks.yolox import Found

GEOMETRY = PanoramaGeometry(1440, 240, -15.0, 45.0)


def drawn(*boxes, level=255):
    """A black panorama with bright boxes."""
    panorama = np.zeros((240, 1440, 3), np.uint8)
    for box in boxes:
        left, right = ((np.pi - edge) / (2 * np.pi) * 1440 for edge in (box.left_rad, box.right_rad))
        top, low = ((np.radians(45) - edge) / np.radians(60) * 240 for edge in (box.high_rad, box.low_rad))
        columns = np.mod(np.arange(round(left), round(right)), 1440)
        panorama[round(top) : round(low), columns] = level
    return panorama


def bright(name="bicycle"):
    """A detector that finds each bright patch of columns; whole ones are surer than what a picture's edge divides."""

    def detector(picture, min_score):
        mask = picture[..., 0] > 200
        columns = np.flatnonzero(mask.any(axis=0))
        found = []
        for run in np.split(columns, np.flatnonzero(np.diff(columns) > 1) + 1) if len(columns) else []:
            rows = np.flatnonzero(mask[:, run].any(axis=1))
            pixels = (float(run[0]), float(rows[0]), float(run[-1] + 1), float(rows[-1] + 1))
            found.append(Found(pixels, name, 0.9 if len(run) > 5 else 0.5))
        return found

    return detector


@pytest.mark.parametrize("azimuth", np.linspace(-np.pi, np.pi, 15))
def test_one_thing_is_found_once_wherever_it_stands(azimuth):
    box = Box(float(azimuth), 0.1, 0.3, 0.4)
    (found,) = find_anchors(bright(), near_and_far(GEOMETRY), drawn(box), "bicycle")
    assert found.box.iou(box) > 0.85
    assert (found.name, found.score, found.followed) == ("bicycle", 0.9, False)


def test_two_things_are_two():
    boxes = Box(0.5, 0.1, 0.3, 0.4), Box(-2.9, 0.0, 0.2, 0.3)
    found = find_anchors(bright(), near_and_far(GEOMETRY), drawn(*boxes), "bicycle")
    assert len(found) == 2
    assert all(max(one.box.iou(box) for one in found) > 0.8 for box in boxes)


@pytest.mark.parametrize("azimuth", [0.0, 1.0, 3.1])
def test_what_is_wider_than_a_cut_is_put_together(azimuth):
    box = Box(azimuth, 0.1, 1.9, 0.3)
    (found,) = find_anchors(bright("car"), [Cuts(GEOMETRY, count=9, wide_deg=60.0)], drawn(box), "car")
    assert found.box.width_rad == pytest.approx(1.9, abs=0.15)
    assert found.box.iou(box) > 0.8


def test_other_names_are_left_out_unless_taken_for_the_asked_one():
    panorama = drawn(Box(0.0, 0.1, 0.3, 0.3))
    cuts = [Cuts(GEOMETRY)]
    assert find_anchors(bright("dog"), cuts, panorama, "car") == []
    (found,) = find_anchors(bright("truck"), cuts, panorama, "car")
    assert found.name == "car"


def test_a_box_that_reaches_out_of_the_picture_ends_where_the_picture_does():
    def beyond(picture, min_score):
        return [Found((100.0, 100.0, 200.0, 900.0), "car", 0.7)]

    (first, *_) = find_anchors(beyond, [Cuts(GEOMETRY)], drawn(), "car")
    assert first.box.low_rad == pytest.approx(np.radians(-15.0), abs=0.01)
