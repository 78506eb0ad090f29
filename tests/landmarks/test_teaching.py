import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.angles import wrapped
from andante.camera import PanoramaGeometry
from andante.errors import InputError, LearningError
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.coco_names import COCO_NAMES
from andante.landmarks.teaching import AnchorTrack, Lesson, Relation, find_track, nearest, spread, teach

GEOMETRY = PanoramaGeometry(720, 160, -40.0, 40.0)
ABOVE = Relation(0.0, 1.2, 1.5, 1.5)


def track(count: int = 20, elevation_rad: float = -0.1, height_rad: float = 0.2, width_rad: float = 0.3) -> AnchorTrack:
    boxes = [Box(float(wrapped(3.0 + 0.05 * at)), elevation_rad, width_rad, height_rad) for at in range(count)]
    return AnchorTrack("bicycle", {at: Detection(box, "bicycle", 0.5) for at, box in enumerate(boxes)})


def test_landmarks_follow_their_anchor_across_the_seam():
    lesson = teach("shed", track(), Relation(-2.0, 1.0, 0.5, 1.5), GEOMETRY)
    assert (lesson.name, lesson.anchor, len(lesson.boxes)) == ("shed", "bicycle", 20)
    for index, box in lesson.boxes.items():
        assert wrapped(box.azimuth_rad - 3.0 - 0.05 * index - 0.6) == pytest.approx(0.0)  # to the left
        assert (box.elevation_rad, box.width_rad, box.height_rad) == pytest.approx((0.1, 0.15, 0.3))


_share, _size = st.floats(-15, 15), st.floats(0.05, 15)


@given(right=st.floats(-3, 3), up=_share, width=_size, height=_size)
def test_a_drawn_box_gives_the_relation_that_gives_the_box(right, up, width, height):
    anchor = Box(2.9, -0.1, 0.4, 0.2)
    relation = Relation(right, up, width, height)
    again = Relation.between(anchor, relation.box(anchor))
    assert (again.right, again.up, again.height) == pytest.approx((right, up, height), abs=1e-9)
    assert again.width == pytest.approx(width, abs=1e-9)


def test_boxes_end_where_the_picture_ends_and_need_half_of_themselves_in_it():
    top = np.radians(40.0)
    half_in = teach("roof", track(elevation_rad=top - 0.21), Relation(0, 1.0, 1, 1), GEOMETRY)
    (box, *_) = half_in.boxes.values()
    assert box.high_rad == pytest.approx(top)
    assert box.height_rad == pytest.approx(0.11)
    with pytest.raises(InputError, match=r"'roof' lies outside of the picture in 20 of 20 frames, above its upper"):
        teach("roof", track(elevation_rad=top - 0.18), Relation(0, 1.0, 1, 1), GEOMETRY)


def test_box_outside_of_the_picture():
    with pytest.raises(
        InputError,
        match=r"landmark 'shed' lies outside of the picture in 20 of 20 frames, above its upper edge at 40 degrees of "
        r"elevation; choose a box nearer to the bicycle",
    ):
        teach("shed", track(), Relation(0.0, 10.0, 1.0, 1.0), GEOMETRY)
    with pytest.raises(InputError, match=r"frames, below its lower edge at -40 degrees"):
        teach("shed", track(), Relation(0.0, -10.0, 1.0, 1.0), GEOMETRY)
    with pytest.raises(
        InputError, match=r"more than 180 degrees wide in 20 of 20 frames, 206 in the median"
    ):  # wider than what anybody sees at once
        teach("shed", track(), Relation(0.0, 0.0, 12.0, 1.0), GEOMETRY)


@pytest.mark.parametrize(
    ("numbers", "message"),
    [
        ((21, 0, 1, 1), r"a landmark 21 to the right and 0 above its anchor is no neighbour: give at most 20"),
        ((0, float("nan"), 1, 1), r"is no neighbour"),
        ((0, 0, 0, 1), r"a landmark of 0 x 1 times the anchor's box cannot be"),
        ((0, 0, 1, float("inf")), r"cannot be: give a width and a height above 0, at most 20"),
    ],
)
def test_relations_that_cannot_be(numbers, message):
    with pytest.raises(InputError, match=message):
        Relation(*numbers)


@pytest.mark.parametrize("name", ["", "../shed", "a/b", "a\\b", ".", "\n", "x" * 101])
def test_names_that_could_be_paths(name):
    with pytest.raises(InputError, match=r"a landmark cannot be called"):
        teach(name, track(), ABOVE, GEOMETRY)


def test_tracks_that_teach_nothing():
    with pytest.raises(LearningError, match=r"no umbrella was found in any frame; put one beside the landmark"):
        AnchorTrack("umbrella", {})
    with pytest.raises(LearningError, match=r"the bicycle was found in 3 frames only, at least 10 are needed"):
        track(3)
    with pytest.raises(LearningError, match=r"was found in 1 frame only"):
        track(1)


def test_the_frame_to_draw_in_is_large_sure_and_seen():
    def one(size: float, score: float, followed: bool = False) -> Detection:
        return Detection(Box(0, 0, size, size), "bicycle", score, followed)

    small = {index: one(0.1, 0.5) for index in range(10)}
    chosen = AnchorTrack("bicycle", {**small, 20: one(0.3, 0.4), 21: one(0.3, 0.6), 22: one(0.5, 0.9, followed=True)})
    assert chosen.best_frame() == 21
    near = {index: one(0.9, 0.7) for index in range(10)}  # from so close there is no room above it
    assert AnchorTrack("bicycle", {**near, 20: one(0.3, 0.8)}).best_frame() == 20


def test_frames_are_left_out():
    lesson = teach("shed", track(), ABOVE, GEOMETRY)
    assert sorted(lesson.without([3, 99]).boxes) == [0, 1, 2, *range(4, 20)]
    assert lesson.without([]) == lesson
    with pytest.raises(LearningError, match=r"'shed' would be left with 9 frames, at least 10 are needed"):
        lesson.without(range(11))


def test_spread():
    assert spread(range(100, 201), 3) == [100, 150, 200]
    assert spread([4, 7], 12) == [4, 7]
    assert len(spread(range(1000), 12)) == 12


def test_every_frame_belongs_to_the_nearest_of_some():
    assert nearest([1, 2, 3, 7, 8, 20], [1, 7, 20]) == {1: [1, 2, 3], 7: [7, 8], 20: [20]}


def test_kinds_that_no_detector_knows(anchor_scene):
    with pytest.raises(InputError, match=r"no detector knows an anchor 'unicorn'; choose one of: bicycle, car, cow"):
        find_track(anchor_scene(), anchor_scene.recording(), "unicorn", lambda done, total: None)
    many = anchor_scene()
    many.names = COCO_NAMES
    with pytest.raises(InputError, match=r"choose one of: .*bicycle, .*sports ball \(7[0-2] others are known\)$"):
        find_track(many, anchor_scene.recording(), "unicorn", lambda done, total: None)
    with pytest.raises(InputError, match=r"choose one of: skateboard, "):
        find_track(many, anchor_scene.recording(), "skatebord", lambda done, total: None)
    assert many.searched == []
    found = find_track(anchor_scene(), anchor_scene.recording(), "bicycle", lambda done, total: None)
    assert list(found.detections) == list(range(40))
    assert isinstance(teach("shed", found, ABOVE, GEOMETRY), Lesson)
