"""Landmarks of a map: learnt from drives through the garden of posts, seen by a detector that knows where posts are."""

import dataclasses
import json
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from safetensors.numpy import load, save

from andante.data import CameraSpec, ImageArray, Status
from andante.errors import ArrayError, ConfigError, ImageError, LearningError, MapError
from andante.evaluation import evaluate
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.views import ViewCutter
from andante.localization.evidence import evidence_of
from andante.mapping import LandmarkConfig, LandmarkMap, SlowMap, add_landmarks, landmark_lesson, map_landmarks
from andante.mapping.landmark_fusion import correlation_of
from andante.mapping.landmark_lesson import Album, best_by_name
from andante.mapping.landmark_sights import Sight, fused
from andante.mapping.landmarks import LandmarkEye

CONFIG = LandmarkConfig(width_px=48, height_px=24, slow_features=12, pca_components=40)
POSTS = {"lamp": 3, "shed": 8, "oak": 17}


class PostDetector:
    """Knows every picture of some recordings, and from where it was taken; ``reach_m`` is how far it sees."""

    def __init__(self, garden: Any, recordings: Sequence[Any], names: Sequence[str] = tuple(POSTS), reach_m=np.inf):
        self._garden, self._names, self._reach_m = garden, names, reach_m
        self._poses = {
            recording.load(info).tobytes(): (info.reference.x_m, info.reference.y_m, info.reference.heading_rad)
            for recording in recordings
            for info in recording.infos
        }

    def detect(self, image: ImageArray, camera: CameraSpec) -> list[Detection]:
        if image.tobytes() not in self._poses:
            return []
        x, y, heading = self._poses[image.tobytes()]
        found = []
        for name in self._names:
            away = self._garden._xy[POSTS[name]] - (x, y)
            distance = float(np.linalg.norm(away))
            if distance < self._reach_m:
                azimuth = float(np.angle(np.exp(1j * (np.arctan2(away[1], away[0]) - heading))))
                top = float(np.arctan(self._garden._height[POSTS[name]] / distance))
                found.append(Detection(Box(azimuth, top / 2, 0.4 / distance, top), name, 0.9))
        return found


@pytest.fixture(scope="module")
def drives(garden) -> list[Any]:
    return garden.two_days(fisheye=True)


@pytest.fixture(scope="module")
def friday(garden) -> Any:
    return garden.another_day(fisheye=True)


@pytest.fixture(scope="module")
def detector(garden, drives, friday) -> PostDetector:
    return PostDetector(garden, [*drives, friday])


@pytest.fixture(scope="module")
def landmarks(drives, detector) -> LandmarkMap:
    return map_landmarks(drives, detector, CONFIG)


@pytest.fixture(scope="module")
def taught(fisheye_map, drives, detector) -> SlowMap:
    return add_landmarks(fisheye_map, drives, detector, CONFIG)


def eye_of(landmarks: LandmarkMap, detector: Any, recording: Any) -> LandmarkEye:
    return LandmarkEye(landmarks, detector, recording.camera, (120, 120))


def test_landmarks_locate_a_day_that_they_have_not_seen(landmarks, detector, friday):
    eye, errors, turns, inside = eye_of(landmarks, detector, friday), [], [], []
    for info in friday.infos:
        found = eye.localize(friday.load(info))
        truth = info.reference
        errors.append(np.hypot(found.x_m - truth.x_m, found.y_m - truth.y_m))
        turns.append(np.angle(np.exp(1j * (found.heading_rad - truth.heading_rad))))
        inside.append(errors[-1] <= found.radius_m)
    assert np.median(errors) < 0.1
    assert np.median(np.abs(turns)) < 0.05
    assert np.mean(inside) >= 0.8


def test_the_estimate_says_which_landmarks_were_used(landmarks, garden, friday):
    one = eye_of(landmarks, PostDetector(garden, [friday], ["shed"]), friday)
    found = one.localize(friday.load(friday.infos[5]))
    assert found.reason.startswith("from shed (")
    assert found.status.has_pose
    assert found.heading_rad is not None
    everything = eye_of(landmarks, PostDetector(garden, [friday]), friday).localize(friday.load(friday.infos[5]))
    assert all(name in everything.reason for name in POSTS)
    assert sum(one.weight for one in everything.hypotheses) == pytest.approx(1.0)


def test_without_a_landmark_the_robot_is_lost(landmarks, garden, friday):
    found = eye_of(landmarks, PostDetector(garden, []), friday).localize(friday.load(friday.infos[0]))
    assert found.status is Status.LOST
    assert found.x_m is None
    assert found.reason == "no landmark of this map is seen, of lamp, oak, shed"


def test_turning_the_robot_turns_the_heading_alone(landmarks, garden):
    pose = garden.loop(60)[7]
    days = [garden.drive(pose[None] + np.array([[0, 0, turn]]), fisheye=True) for turn in (0.0, 1.3)]
    found = [eye_of(landmarks, PostDetector(garden, [day]), day).localize(day.load(day.infos[0])) for day in days]
    assert found[0].x_m == pytest.approx(found[1].x_m, abs=0.06)
    assert found[0].y_m == pytest.approx(found[1].y_m, abs=0.06)
    turned = np.angle(np.exp(1j * (found[1].heading_rad - found[0].heading_rad)))
    assert turned == pytest.approx(1.3, abs=0.03)


def test_of_two_boxes_of_one_name_the_better_counts():
    boxes = [Box(0.0, 0.1, 0.1, 0.1), Box(1.0, 0.1, 0.1, 0.1)]
    seen = [Detection(boxes[0], "oak", 0.4), Detection(boxes[1], "oak", 0.8), Detection(boxes[0], "lamp", 0.2)]
    assert best_by_name(seen) == {"lamp": boxes[0], "oak": boxes[1]}
    assert best_by_name(seen[::-1]) == best_by_name(seen)


def test_names_that_are_not_mapped_are_passed_over(landmarks, friday):
    strange = [Detection(Box(0.0, 0.1, 0.1, 0.1), "castle", 1.0)]
    signature = landmarks.signature(friday.load(friday.infos[0]), strange, ViewCutter(friday.camera, (120, 120)))
    assert np.isnan(signature).all()
    with pytest.raises(ArrayError, match=r"has \d+ numbers, got \(3,\)"):
        landmarks.sights(np.zeros(3, np.float32))


def test_a_human_is_asked_where_nothing_is_seen(garden, drives):
    near = map_landmarks(drives, PostDetector(garden, drives, reach_m=4.0), CONFIG)
    weak = near.weak_places(5.0)
    seen_from = {
        (info.reference.x_m, info.reference.y_m): bool(
            PostDetector(garden, [day], reach_m=4.0).detect(day.load(info), day.camera)
        )
        for day in drives
        for info in day.infos
    }
    unseen = [place for place, shown in seen_from.items() if not shown]
    assert unseen
    assert weak[0].radius_m == np.inf
    assert sum(one.frames for one in weak) <= len(near.places)
    for place in weak:
        if np.isinf(place.radius_m):
            assert min(np.hypot(place.x_m - x, place.y_m - y) for x, y in unseen) < 2.0
    assert not map_landmarks(drives, PostDetector(garden, drives), CONFIG).weak_places(1e3)
    with pytest.raises(ArrayError, match=r"radius_m and cell_m have to be above zero"):
        near.weak_places(0.0)


def test_a_landmark_that_is_hardly_seen_is_left_out(garden, drives, friday):
    class Shy(PostDetector):
        def detect(self, image, camera):
            return [one for one in super().detect(image, camera) if one.name != "oak"]

    assert map_landmarks(drives, Shy(garden, drives), CONFIG).names == ("lamp", "shed")
    with pytest.raises(LearningError, match=r"no landmark is seen in any frame with a position"):
        map_landmarks(drives, PostDetector(garden, []), CONFIG)
    with pytest.raises(LearningError, match=r"is seen in 20 frames or more, the most frequent, 'lamp', in 5; record"):
        map_landmarks(
            [garden.drive(garden.loop(60)[:5], fisheye=True)],
            PostDetector(garden, [garden.drive(garden.loop(60)[:5], fisheye=True)]),
            CONFIG,
        )


def test_landmarks_of_which_nothing_can_be_held_out_are_refused(garden, drives):
    """Nobody could say how far to believe them."""
    short = garden.drive(garden.loop(60)[:25], fisheye=True)
    with pytest.raises(LearningError, match=r"a third of its frames out and learn from 20 others, .* 'lamp', in 25"):
        map_landmarks([short], PostDetector(garden, [short]), CONFIG)
    with pytest.raises(LearningError, match=r"20 frames or more of the other drives when .* 'lamp', in 60; record"):
        map_landmarks(drives, PostDetector(garden, drives[:1]), CONFIG)

    class Half(PostDetector):
        """Sees the oak on one of the days alone."""

        def detect(self, image, camera):
            first = any(drives[0].load(info).tobytes() == image.tobytes() for info in drives[0].infos)
            return [one for one in super().detect(image, camera) if first or one.name != "oak"]

    assert map_landmarks(drives, Half(garden, drives), CONFIG).names == ("lamp", "shed")


def test_landmarks_that_no_trial_recognises_are_refused(drives, detector, monkeypatch):
    monkeypatch.setattr("andante.mapping.landmark_sights._FAMILIAR", 1.1)
    with pytest.raises(LearningError, match=r"no landmark looks the same in frames that were held out"):
        map_landmarks(drives, detector, CONFIG)


def test_what_looks_like_nothing_mapped_is_not_believed(landmarks, detector, friday):
    eye = eye_of(landmarks, detector, friday)
    sights = landmarks.sights(eye.signature(friday.load(friday.infos[3])))
    assert len(sights) > 1
    assert all(one.familiar for one in sights)
    strange = dataclasses.replace(sights[0], xy=sights[0].xy + 5.0, likeness=0.3)
    found = landmarks.estimate_of([strange, *sights[1:]])
    assert (found.x_m, found.y_m) == pytest.approx(dataclasses.astuple(landmarks.estimate_of(sights[1:]))[2:4])
    lost = landmarks.estimate_of([strange])
    assert lost.status is Status.LOST
    assert lost.reason.startswith("what is seen looks like no mapped view of it, by likeness: ")
    assert "(0.30)" in lost.reason
    assert len(lost.hypotheses) > 0


def test_what_is_held_out_has_no_say_in_where_landmarks_stand(drives, detector, monkeypatch):
    """Trials go by the places that they learnt themselves."""
    known = []
    monkeypatch.setattr(
        landmark_lesson,
        "fused",
        lambda sights, *rest: known.extend(one.model for one in sights) or fused(sights, *rest),
    )
    (lamp, *_) = map_landmarks(drives, detector, CONFIG).models
    places = {(one.geometry.x_m, one.geometry.y_m) for one in known if one.name == lamp.name}
    assert len(places) == 2
    assert (lamp.geometry.x_m, lamp.geometry.y_m) not in places


def test_of_one_drive_pieces_of_half_a_metre_are_held_out():
    poses = np.zeros((200, 3))
    poses[:, 0] = 0.05 * np.arange(200)
    part = landmark_lesson._parts(Album((), poses, np.zeros(200, np.int64)), CONFIG)
    assert set(part) == {0, 1, 2}
    edges = np.flatnonzero(np.diff(part)) + 1
    assert set(np.diff(edges)) <= {9, 10, 11}  # what lies on an edge may fall to either side
    sparse = landmark_lesson._parts(Album((), 40 * poses, np.zeros(200, np.int64)), CONFIG)
    np.testing.assert_array_equal(sparse, np.arange(200) % 3)


def test_errors_are_compared_along_the_axes_of_the_map():
    """A long thin covariance beside a round one: their errors in deviations are those of symmetric roots."""
    rng = np.random.default_rng(3)
    turn = np.array([[1.0, -1.0], [1.0, 1.0]]) / np.sqrt(2)
    root = turn @ np.diag([3.0, 0.1]) @ turn.T
    errors = rng.normal(size=(50, 2))
    model = SimpleNamespace(scale=1.0)
    held = [
        [Sight(model, None, root @ one, root @ root, 1.0), Sight(model, None, one, np.eye(2), 1.0)] for one in errors
    ]
    album = Album((), np.zeros((50, 3)), np.zeros(50, np.int64))
    white = landmark_lesson._white(held, [model, model], album)
    np.testing.assert_allclose(white[:, 0], errors, atol=1e-9)
    assert correlation_of(white) == pytest.approx(1.0)


def test_inverse_error_is_the_thesis_way(drives, detector, friday):
    config = CONFIG.model_copy(update={"fusion": "inverse-error"})
    eye = eye_of(map_landmarks(drives, detector, config), detector, friday)
    found = [eye.localize(friday.load(info)) for info in friday.infos]
    errors = [
        np.hypot(one.x_m - info.reference.x_m, one.y_m - info.reference.y_m)
        for one, info in zip(found, friday.infos, strict=True)
    ]
    assert np.median(errors) < 0.2
    assert all(one.heading_rad is not None for one in found)


def test_drives_without_headings_give_positions_without(garden, drives, detector, friday, copied):
    blind = [
        copied(day, reference=[dataclasses.replace(info.reference, heading_rad=None) for info in day.infos])
        for day in drives
    ]
    found = eye_of(map_landmarks(blind, detector, CONFIG), detector, friday).localize(friday.load(friday.infos[3]))
    assert found.status.has_pose
    assert found.heading_rad is None
    assert np.isnan(found.covariance[2, 2])


def test_a_single_session_is_calibrated_on_parts_of_itself(drives, detector):
    alone = map_landmarks(drives[:1], detector, CONFIG)
    assert not alone.calibration.sessions
    assert alone.calibration.radius_factor > 0
    assert map_landmarks(drives, detector, CONFIG).calibration.sessions


def test_the_same_drives_give_the_same_landmarks(landmarks, drives, detector):
    again = map_landmarks(drives, detector, CONFIG)
    for name, array in landmarks.to_arrays().items():
        np.testing.assert_array_equal(again.to_arrays()[name], array)
    assert again.calibration == landmarks.calibration


def test_a_map_keeps_its_landmarks_in_its_file(taught, detector, friday, tmp_path):
    taught.save(tmp_path / "a.andante")
    found = SlowMap.load(tmp_path / "a.andante").with_detector(detector)
    assert found.landmarks.names == taught.landmarks.names
    assert found.landmarks.calibration == taught.landmarks.calibration
    image = friday.load(friday.infos[4])
    assert found.localize(image).as_dict() == taught.localize(image).as_dict()
    np.testing.assert_array_equal(found.landmarks.places, taught.landmarks.places)
    found.save(tmp_path / "b.andante")
    assert (tmp_path / "a.andante").stat().st_size > (tmp_path / "b.andante").stat().st_size  # without its memory


def test_a_map_without_landmarks_has_the_file_that_it_always_had(fisheye_map, taught, tmp_path):
    fisheye_map.save(tmp_path / "plain")
    dataclasses.replace(taught, landmarks=None).save(tmp_path / "again")
    assert (tmp_path / "plain").read_bytes() == (tmp_path / "again").read_bytes()
    assert SlowMap.load(tmp_path / "plain").landmarks is None


def test_without_a_detector_the_whole_image_speaks_alone(fisheye_map, taught, friday, tmp_path):
    taught.save(tmp_path / "a.andante")
    image = friday.load(friday.infos[4])
    assert SlowMap.load(tmp_path / "a.andante").localize(image).as_dict() == fisheye_map.localize(image).as_dict()
    with pytest.raises(MapError, match=r"this map has no landmarks to look for"):
        fisheye_map.with_detector(PostDetector(None, []))


def test_evaluation_and_tracking_see_what_localizing_sees(taught, fisheye_map, friday):
    run = evaluate(taught, friday).run
    for frame in run.frames[::6]:
        image = friday.load(frame.info)
        assert frame.estimate.as_dict() == taught.localize(image).as_dict()
        assert "from lamp" in frame.estimate.reason
        assert evidence_of(taught, image).estimate.as_dict() == frame.estimate.as_dict()
    assert evaluate(taught, friday).figures.median_m <= evaluate(fisheye_map, friday).figures.median_m + 0.05
    assert [one["name"] for one in taught.describe()["landmarks"]] == ["lamp", "oak", "shed"]


def test_images_of_another_size_are_understood(taught, friday):
    image = friday.load(friday.infos[0])
    twice = np.repeat(np.repeat(image, 2, axis=0), 2, axis=1)
    assert "no landmark of this map is seen" in taught.localize(twice).reason
    with pytest.raises(ImageError, match=r"120x60 px does not fit the camera, whose images are 120x120 px"):
        eye_of(taught.landmarks, PostDetector(None, []), friday).localize(image[:60])


@pytest.mark.parametrize(
    ("name", "change", "message"),
    [
        ("landmarks.0.numbers", lambda a: a[:5], r"landmark 'lamp' has arrays of shapes \(5,\)"),
        ("landmarks.1.model.mean", lambda a: a[:-1], r"landmarks\.1\.model\.mean"),
        ("landmarks.2.readout.xy", lambda a: a[:-1], r"readout\.xy"),
        ("landmarks.places", lambda a: a[:, :2], r"the places of landmarks have shape \(n, 3\)"),
        ("landmarks.0.geometry", lambda a: a * 0, r"has to be above zero"),
        ("landmarks.0.geometry", None, r"lacks the stored arrays geometry"),
    ],
)
def test_a_damaged_file_is_refused(taught, tmp_path, name, change, message):
    path = tmp_path / "a.andante"
    taught.save(path)
    arrays = load(path.read_bytes())
    if change is None:
        del arrays[name]
    else:
        arrays[name] = np.ascontiguousarray(change(arrays[name]))
    path.write_bytes(save(arrays, metadata={"andante": _header(path)}))
    with pytest.raises(MapError, match=message):
        SlowMap.load(path)


def test_a_correlation_beyond_one_is_refused(taught, tmp_path):
    path = tmp_path / "a.andante"
    taught.save(path)
    header = json.loads(_header(path))
    header["landmarks"]["calibration"]["correlation"] = 1.5
    path.write_bytes(save(load(path.read_bytes()), metadata={"andante": json.dumps(header)}))
    with pytest.raises(MapError, match=r"have a correlation of 1\.5, from 0 to 1 is allowed"):
        SlowMap.load(path)


def test_landmarks_need_metres_and_a_fisheye(slowmap, days, fisheye_map, drives, detector, copied):
    with pytest.raises(ConfigError, match=r"cut out of fisheye images, this camera is a panorama"):
        add_landmarks(slowmap, days, detector, CONFIG)
    places = dataclasses.replace(fisheye_map, unit="place")
    with pytest.raises(ConfigError, match=r"landmarks need reference poses in metres"):
        add_landmarks(places, drives, detector, CONFIG)


def test_unknown_keys_of_a_configuration_are_refused():
    with pytest.raises(ValueError, match=r"wide_deg"):
        LandmarkConfig(wide_deg=3)


def _header(path) -> str:
    data = path.read_bytes()
    size = int.from_bytes(data[:8], "little")
    return json.loads(data[8 : 8 + size])["__metadata__"]["andante"]
