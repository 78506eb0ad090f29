"""One image in, one honest estimate out."""

import dataclasses
import json
import math
from concurrent.futures import ThreadPoolExecutor

import cv2
import numpy as np
import pytest

from andante.data import CameraSpec, Status
from andante.errors import ArrayError, ConfigError, ImageError
from andante.mapping import SlowMap, build_map
from andante.mapping.frontend import Encoded

SOMEWHERE = 17


def turned(picture: np.ndarray, degrees: float) -> np.ndarray:
    """The picture turned counter-clockwise about the centre of its circle."""
    matrix = cv2.getRotationMatrix2D((59.5, 59.5), degrees, 1.0)
    return cv2.warpAffine(picture, matrix, (120, 120), flags=cv2.INTER_CUBIC)


def apart_deg(one_rad: float, other_rad: float) -> float:
    """How far two headings are apart, around the shorter way."""
    return abs(math.degrees(math.remainder(one_rad - other_rad, 2 * math.pi)))


def statuses(slowmap, pictures) -> list[Status]:
    return [slowmap.localize(picture).status for picture in pictures]


def test_an_estimate_says_all_that_it_promises(slowmap, garden):
    pose = garden.loop(60)[SOMEWHERE]
    estimate = slowmap.localize(garden.panorama(pose))
    assert estimate.status is Status.OK
    assert math.hypot(estimate.x_m - pose[0], estimate.y_m - pose[1]) < 0.1
    assert apart_deg(estimate.heading_rad, pose[2]) < 1
    assert estimate.radius_m > 0
    assert estimate.covariance.shape == (3, 3)
    assert np.linalg.eigvalsh(estimate.covariance).min() > 0
    assert 0 < estimate.likeness <= 1
    json.dumps(estimate.as_dict(), allow_nan=False)


def test_the_covariance_is_that_of_the_radius(slowmap, garden):
    """Were it round, the radius would hold 90 % of it; the heading varies by itself, in radians."""
    for pose in garden.loop(23, 0.3):
        estimate = slowmap.localize(garden.panorama(pose))
        assert estimate.status.has_pose
        covariance = estimate.covariance
        deviation_m = math.sqrt(np.trace(covariance[:2, :2]) / 2)
        assert 1 - math.exp(-0.5 * (estimate.radius_m / deviation_m) ** 2) == pytest.approx(0.9)
        np.testing.assert_allclose(covariance, covariance.T)
        np.testing.assert_array_equal(covariance[2, :2], 0)
        assert np.linalg.eigvalsh(covariance).min() > 0
        assert math.radians(0.1) <= math.sqrt(covariance[2, 2]) < math.radians(5)


@pytest.mark.parametrize("turn", [0.0, 0.7, 2.0, math.pi, -2.5])
def test_the_heading_of_a_robot_that_turned(fisheye_map, slowmap, garden, turn):
    for pose in garden.loop(7, 0.3):
        turned = (*pose[:2], pose[2] + turn)
        for built, look in ((fisheye_map, garden.fisheye), (slowmap, garden.panorama)):
            heading = built.localize(look(turned)).heading_rad
            assert apart_deg(heading, turned[2]) < 2
            assert -math.pi <= heading < math.pi


def test_headings_hold_what_their_deviation_promises(slowmap, garden):
    """In another light, turned at random; 90 % of a Gaussian lie within 1.645 deviations."""
    off, promised = [], []
    for pose in garden.loop(60, 0.3):
        turned = (*pose[:2], pose[2] + 7 * pose[0])
        estimate = slowmap.localize(garden.panorama(turned, 1.1, -20))
        off.append(apart_deg(estimate.heading_rad, turned[2]))
        promised.append(1.645 * math.degrees(math.sqrt(estimate.covariance[2, 2])))
    assert np.mean(np.array(off) <= promised) >= 0.85
    assert np.median(off) < 0.5


def test_the_heading_is_that_of_the_robot_and_not_of_its_camera(fisheye_map, garden):
    """The camera screwed on again, a quarter further round, and declared so."""
    picture = garden.fisheye(garden.loop(60)[SOMEWHERE])
    camera = dataclasses.replace(garden.fisheye_camera, forward_deg=90.0)
    turned = np.rot90(picture).copy()
    straight, other = fisheye_map.localize(picture), fisheye_map.for_camera(camera, turned).localize(turned)
    assert apart_deg(other.heading_rad, straight.heading_rad) < 0.5
    assert apart_deg(fisheye_map.localize(turned).heading_rad, straight.heading_rad) == pytest.approx(90, abs=0.5)


def test_every_hypothesis_has_its_own_heading(slowmap, garden):
    """What the compass says at its place, whatever it is worth; one of an imagined view comes with the view."""
    several, slowmap = 0, dataclasses.replace(slowmap, scenery=None)
    for pose in garden.loop(23, 0.3):
        picture = garden.panorama(pose, 0.6, 40)
        encoded, estimate = slowmap.front_end.encode(picture), slowmap.localize(picture)
        assert estimate.hypotheses[0].heading_rad == estimate.heading_rad
        for one in estimate.hypotheses:
            (heading,) = slowmap.compass.bearings(encoded.phase, np.array([[one.x_m, one.y_m]])).heading
            assert one.heading_rad == (heading if np.isfinite(heading) else None)
        several += len(estimate.hypotheses) > 1
    assert several > 5


def test_without_a_heading_the_covariance_says_nothing_of_it(slowmap, garden):
    mute = dataclasses.replace(
        slowmap, calibration=dataclasses.replace(slowmap.calibration, heading_factor=None)
    ).localize(garden.panorama(garden.loop(60)[SOMEWHERE]))
    assert mute.status is Status.OK
    assert mute.heading_rad is None
    assert np.isnan(mute.covariance[2]).all()
    assert np.isnan(mute.covariance[:, 2]).all()
    assert np.linalg.eigvalsh(mute.covariance[:2, :2]).min() > 0


def test_a_camera_that_looks_one_way_tells_no_heading(garden, days, copied, small_config, tmp_path):
    """And its map, which remembers no phases, survives the file all the same."""
    half = CameraSpec(model="panorama", horizontal_field_of_view_deg=200.0)
    built = build_map([copied(day, camera=half) for day in days], small_config)
    assert built.compass is None
    assert built.calibration.heading_factor is None
    built.save(tmp_path / "map.andante")
    loaded = SlowMap.load(tmp_path / "map.andante", with_memory=True)
    assert [session.phase.dim for session in loaded.memory] == [0, 0]
    for one in (built, loaded):
        estimate = one.localize(garden.panorama(garden.loop(60)[SOMEWHERE]))
        assert estimate.status is Status.OK
        assert estimate.heading_rad is None
        assert np.isnan(estimate.covariance[2]).all()
        assert {one.heading_rad for one in estimate.hypotheses} == {None}
        json.dumps(estimate.as_dict(), allow_nan=False)


def test_drives_without_headings_make_a_map_that_tells_none(days, garden, copied, small_config):
    blind = [
        copied(day, reference=[dataclasses.replace(info.reference, heading_rad=None) for info in day.infos])
        for day in days
    ]
    built = build_map(blind, small_config)
    assert built.compass is None
    assert built.localize(garden.panorama(garden.loop(60)[SOMEWHERE])).heading_rad is None


def test_headings_of_one_drive_out_of_several_cannot_be_tried_and_are_not_told(days, garden, copied, small_config):
    """Were they, the map would judge by a likeness to phases which the trial without that drive does not know."""
    blind = copied(days[1], reference=[dataclasses.replace(info.reference, heading_rad=None) for info in days[1].infos])
    pose = garden.loop(60)[SOMEWHERE]
    built = build_map([days[0], blind], small_config)
    assert (built.compass, built.calibration.heading_factor) == (None, None)
    assert built.localize(garden.panorama(pose)).status is Status.OK
    built = build_map([days[0], blind, garden.another_day()], small_config)
    assert apart_deg(built.localize(garden.panorama(pose)).heading_rad, pose[2]) < 2


def test_hypotheses_weigh_one_and_the_first_is_the_estimate(slowmap, garden):
    for pose in garden.loop(23, 0.3):
        estimate = slowmap.localize(garden.panorama(pose))
        assert sum(one.weight for one in estimate.hypotheses) == pytest.approx(1)
        first, *others = estimate.hypotheses
        assert (first.x_m, first.y_m) == (estimate.x_m, estimate.y_m)
        assert all(other.weight <= first.weight for other in others)


def test_bgr_is_understood_as_grey(slowmap, garden):
    picture = garden.panorama(garden.loop(60)[SOMEWHERE])
    colour = np.repeat(picture[:, :, None], 3, axis=2)
    assert slowmap.localize(colour).as_dict() == slowmap.localize(picture).as_dict()


@pytest.mark.parametrize("quarter_turns", [1, 2, 3])
def test_a_robot_turned_by_quarters_is_at_the_same_place(fisheye_map, garden, quarter_turns):
    picture = garden.fisheye(garden.loop(60)[SOMEWHERE])
    straight, other = fisheye_map.localize(picture), fisheye_map.localize(np.rot90(picture, quarter_turns).copy())
    assert other.status is straight.status is Status.OK
    assert other.x_m == pytest.approx(straight.x_m, abs=1e-3)
    assert other.y_m == pytest.approx(straight.y_m, abs=1e-3)


@pytest.mark.parametrize("degrees", [10, 77, 200])
def test_a_robot_turned_by_any_angle_is_at_the_same_place(fisheye_map, garden, degrees):
    """Resampled pixels are blurred a little, no more."""
    picture = garden.fisheye(garden.loop(60)[SOMEWHERE])
    straight, other = fisheye_map.localize(picture), fisheye_map.localize(turned(picture, degrees))
    assert other.status is Status.OK
    assert math.hypot(other.x_m - straight.x_m, other.y_m - straight.y_m) < 0.1


def test_a_robot_that_really_turned_is_at_the_same_place(fisheye_map, garden):
    pose = garden.loop(60)[SOMEWHERE]
    estimates = [fisheye_map.localize(garden.fisheye((*pose[:2], pose[2] + turn))) for turn in (0, 0.7, 2, 4)]
    xy = np.array([(estimate.x_m, estimate.y_m) for estimate in estimates])
    assert np.linalg.norm(xy - xy[0], axis=1).max() < 0.05


@pytest.mark.parametrize("level", [0, 128, 255])
def test_a_covered_lens_is_lost_and_says_why(slowmap, level):
    estimate = slowmap.localize(np.full((12, 120), level, np.uint8))
    assert estimate.status is Status.LOST
    assert "the image shows nothing" in estimate.reason
    assert "is the lens covered?" in estimate.reason
    assert (estimate.x_m, estimate.y_m, estimate.radius_m, estimate.covariance) == (None, None, None, None)


def test_a_black_fisheye_image_is_lost(fisheye_map):
    assert fisheye_map.localize(np.zeros((120, 120), np.uint8)).status is Status.LOST


@pytest.mark.parametrize("kind", ["panorama", "fisheye"])
def test_noise_is_off_the_map(kind, slowmap, fisheye_map):
    built, shape = (slowmap, (12, 120)) if kind == "panorama" else (fisheye_map, (120, 120))
    rng = np.random.default_rng(0)
    found = statuses(built, [rng.integers(0, 256, shape, dtype=np.uint8) for _ in range(50)])
    assert sum(status.has_pose for status in found) <= 2


@pytest.mark.parametrize("kind", ["panorama", "fisheye"])
def test_another_garden_is_hardly_ever_taken_for_this_one(kind, slowmap, fisheye_map, other_garden):
    built, look = (slowmap, other_garden.panorama) if kind == "panorama" else (fisheye_map, other_garden.fisheye)
    found = statuses(built, [look(pose) for pose in other_garden.loop(40)])
    assert found.count(Status.OK) <= 4
    assert sum(not status.has_pose for status in found) >= 22


def test_off_the_map_names_its_reason_and_keeps_what_was_considered(slowmap):
    noise = np.random.default_rng(1).integers(0, 256, (12, 120), dtype=np.uint8)
    estimate = slowmap.localize(noise)
    assert estimate.status is Status.OFF_MAP
    assert "looks like this" in estimate.reason
    assert "\n" not in estimate.reason
    assert estimate.x_m is None
    assert estimate.hypotheses


def test_a_mapped_drive_is_never_strange(slowmap, days):
    assert {slowmap.localize(day.load(info)).status for day in days for info in day.infos} == {Status.OK}


@pytest.mark.parametrize("shape", [(100, 120), (121, 60), (12, 120), (0, 0), (0, 120)])
def test_an_image_of_other_proportions_is_refused(fisheye_map, shape):
    with pytest.raises(ImageError, match=r"does not fit the camera|at least one pixel"):
        fisheye_map.localize(np.zeros(shape, np.uint8))


@pytest.mark.parametrize("size", [1, 2, 3, 5, 9])
def test_an_image_in_which_nothing_can_be_seen_has_no_pose(fisheye_map, garden, size):
    picture = cv2.resize(garden.fisheye(garden.loop(60)[0]), (size, size), interpolation=cv2.INTER_AREA)
    assert not fisheye_map.localize(picture).status.has_pose


def test_the_message_for_a_foreign_size_says_what_fits(fisheye_map):
    with pytest.raises(ImageError, match="an image of 120x100 px does not fit the camera, whose images are 120x120 px"):
        fisheye_map.localize(np.zeros((100, 120), np.uint8))


def test_a_panorama_that_is_too_small_is_refused(slowmap, garden):
    half = cv2.resize(garden.panorama(garden.loop(60)[0]), (60, 6), interpolation=cv2.INTER_AREA)
    with pytest.raises(ImageError, match="an image of 60x6 px is too small: it gives a panorama of 60x6 px, the map"):
        slowmap.localize(half)


@pytest.mark.parametrize(
    "wrong",
    [
        np.zeros(120, np.uint8),
        np.zeros((12, 120, 4), np.uint8),
        np.zeros((12, 120)),
        np.zeros((1, 12, 120, 3), np.uint8),
    ],
)
def test_what_is_no_image_is_refused(slowmap, wrong):
    with pytest.raises(ImageError, match="shape"):
        slowmap.localize(wrong)


@pytest.mark.parametrize("factor", [0.5, 2.0])
def test_another_resolution_of_the_same_camera_is_understood(fisheye_map, garden, factor):
    pose = garden.loop(60)[SOMEWHERE]
    picture = garden.fisheye(pose)
    size = round(120 * factor)
    interpolation = cv2.INTER_AREA if factor < 1 else cv2.INTER_CUBIC
    estimate = fisheye_map.localize(cv2.resize(picture, (size, size), interpolation=interpolation))
    assert estimate.status.has_pose
    assert math.hypot(estimate.x_m - pose[0], estimate.y_m - pose[1]) < 0.3


def test_many_threads_give_what_one_gives(fisheye_map, garden, tmp_path):
    """A map fresh from its file, which has not met the half size yet."""
    fisheye_map.save(tmp_path / "map.andante")
    fresh = SlowMap.load(tmp_path / "map.andante")
    pictures = [garden.fisheye(pose) for pose in garden.loop(24)]
    halves = [cv2.resize(picture, (60, 60), interpolation=cv2.INTER_AREA) for picture in pictures]
    with ThreadPoolExecutor(8) as pool:
        found = [estimate.as_dict() for estimate in pool.map(fresh.localize, [*pictures, *halves])]
    assert found == [fisheye_map.localize(picture).as_dict() for picture in [*pictures, *halves]]


def test_features_of_a_wrong_length_are_refused(slowmap):
    with pytest.raises(ArrayError, match="X has 5 features, but this map is expecting 1440"):
        slowmap.estimate(Encoded(np.zeros((1, 5), np.float32), np.zeros((1, slowmap.front_end.phase_dim), np.float32)))


def test_slow_features_of_an_image(slowmap, garden, days):
    slow = slowmap.slow_features(garden.panorama(garden.loop(60)[0]))
    assert slow.shape == (slowmap.model.output_dim,)
    mapped = np.concatenate([slowmap.model.transform(session.codes.rows()) for session in slowmap.memory])
    np.testing.assert_allclose(mapped.mean(axis=0), 0, atol=1e-2)
    np.testing.assert_allclose(mapped.var(axis=0), 1, atol=1e-2)
    # The pictures themselves, before they are coded: only of the last of 119 features from 120 frames a bit is lost.
    live = np.array([slowmap.slow_features(day.load(info)) for day in days for info in day.infos])
    np.testing.assert_allclose(live.mean(axis=0), 0, atol=1e-2)
    np.testing.assert_allclose(live.var(axis=0)[:40], 1, atol=1e-2)
    np.testing.assert_allclose(live.var(axis=0), 1, atol=0.2)


def test_a_map_for_another_camera(fisheye_map, garden):
    """The same lens, its circle elsewhere in a larger picture."""
    pose = garden.loop(60)[SOMEWHERE]
    picture = np.pad(garden.fisheye(pose), ((0, 20), (30, 0)))
    moved = fisheye_map.for_camera(CameraSpec(centre_px=(89.5, 59.5), radius_px=58.0), picture)
    estimate = moved.localize(picture)
    assert math.hypot(estimate.x_m - pose[0], estimate.y_m - pose[1]) < 0.1
    with pytest.raises(ConfigError, match="use a camera like the map's"):
        fisheye_map.for_camera(CameraSpec(model="panorama"), np.zeros((24, 300), np.uint8))


def test_a_map_for_a_recording_of_its_own_camera_is_itself(slowmap, days):
    assert slowmap.for_recording(days[0]) is slowmap


def test_the_description_is_plain(slowmap):
    described = json.loads(json.dumps(slowmap.describe(), allow_nan=False))
    assert described["feature_dim"] == 1440
    assert described["panorama_px"] == [120, 12]
    assert [one["name"] for one in described["recordings"]] == ["monday", "tuesday"]
    assert described["cross_validation"]["kind"] == "sessions"
    assert described["heading_invariant"] is True
    assert len(described["deltas"]) == described["slow_features"] == 119


def test_the_circle_of_an_undeclared_fisheye_is_found(garden, errors_m, small_config):
    """Bright to the rim, as a real sky is; one picture of those looked at is missing."""

    class Gap:
        """The recording without one picture."""

        def __init__(self, inner):
            self._inner = inner

        def __getattr__(self, name):
            return getattr(self._inner, name)

        def load(self, info, *, colour=False):
            if info.index == 0:
                raise ImageError("image 0 is gone")
            return self._inner.load(info, colour=colour)

        def frames(self, indices=None, *, colour=False, on_skip=None):
            from andante.recordings.frames import iterate_frames

            return iterate_frames(self, indices, colour=colour, on_skip=on_skip)

    day = garden.two_days(fisheye=True)[0]
    day.camera = CameraSpec()
    built = build_map([Gap(day)], small_config)
    found = built.front_end.camera
    assert math.dist(found.centre_px, (59.5, 59.5)) < 1
    assert found.radius_px == pytest.approx(58, abs=1.5)
    assert np.median(errors_m(built, garden.another_day(fisheye=True))) < 0.3
    assert built.sources[0].skipped == ("image 0 is gone",)
