"""Boxes on a circle: nothing depends on where the seam is."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.errors import InputError
from andante.landmarks.boxes import Box

angles = st.floats(-np.pi, np.pi)
sizes = st.floats(0.01, 1.5)
boxes = st.builds(Box, angles, st.floats(-0.5, 0.8), sizes, sizes)


def turned(box: Box, by_rad: float) -> Box:
    return Box(
        float(np.angle(np.exp(1j * (box.azimuth_rad + by_rad)))), box.elevation_rad, box.width_rad, box.height_rad
    )


@settings(deadline=None, max_examples=40)
@given(boxes, boxes, angles)
def test_turning_the_robot_changes_no_overlap(first, second, turn):
    assert turned(first, turn).iou(turned(second, turn)) == pytest.approx(first.iou(second), abs=1e-9)
    assert first.iou(second) == pytest.approx(second.iou(first), abs=1e-12)


@settings(deadline=None, max_examples=40)
@given(boxes)
def test_a_box_overlaps_itself_wholly(box):
    assert box.iou(box) == pytest.approx(1.0)


@settings(deadline=None, max_examples=40)
@given(boxes, boxes)
def test_overlap_is_what_counting_cells_gives(first, second):
    azimuth = -np.pi + 2 * np.pi * (np.arange(1500) + 0.5) / 1500

    def mask(box):
        near = np.abs(np.angle(np.exp(1j * (azimuth - box.azimuth_rad)))) < box.width_rad / 2
        elevation = np.linspace(-1.5, 1.8, 600)
        return near[:, None] & (np.abs(elevation - box.elevation_rad) < box.height_rad / 2)[None, :]

    both, either = (mask(first) & mask(second)).sum(), (mask(first) | mask(second)).sum()
    if either > 2000:
        assert first.iou(second) == pytest.approx(both / either, abs=0.08)


def test_boxes_wider_than_half_the_circle_meet_on_both_sides():
    front, back = Box(0.0, 0.0, 4.0, 1.0), Box(np.pi, 0.0, 4.0, 1.0)
    assert front.shared_rad2(back) == pytest.approx(2 * (4.0 - np.pi))


def test_rounding_does_not_end_on_the_open_side_of_the_seam():
    """Half a turn and the next larger number, which wraps to half a turn the other way."""
    anchor, behind = Box(0.0, 0.0, 0.18098243524892949, 1.0), Box(float(np.nextafter(-np.pi, -4)), 0.0, 1.0, 1.0)
    assert anchor.shifted(*behind.seen_from(anchor)).azimuth_rad == np.pi


@settings(deadline=None, max_examples=40)
@given(boxes, boxes)
def test_a_landmark_is_where_its_anchor_says(anchor, landmark):
    again = anchor.shifted(*landmark.seen_from(anchor))
    assert again.iou(landmark) == pytest.approx(1.0, abs=1e-6)
    assert -np.pi < again.azimuth_rad <= np.pi


def test_right_in_the_picture_is_clockwise_and_up_is_up():
    beside = Box(3.1, 0.1, 0.2, 0.4).shifted(-1.0, 0.5, 2.0, 1.0)
    assert beside.azimuth_rad == pytest.approx(3.3 - 2 * np.pi)
    assert (beside.elevation_rad, beside.width_rad, beside.height_rad) == pytest.approx((0.3, 0.4, 0.4))


def test_edges_across_the_seam():
    box = Box.between(-3.0, 3.0, -0.1, 0.3)
    assert (box.azimuth_rad, box.elevation_rad) == pytest.approx((np.pi, 0.1))
    assert (box.width_rad, box.height_rad) == pytest.approx((2 * np.pi - 6.0, 0.4))
    assert box.left_rad - box.right_rad == pytest.approx(box.width_rad)


def test_an_anchor_without_size_measures_nothing():
    with pytest.raises(InputError, match=r"needs a width and a height .* choose another frame"):
        Box(0, 0, 1, 1).seen_from(Box(0, 0, 0.0, 1))
