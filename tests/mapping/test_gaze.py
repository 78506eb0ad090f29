from dataclasses import replace

import numpy as np
import pytest
from safetensors.numpy import load_file, save_file

from andante.data import CameraSpec, Pose2D, Status
from andante.errors import ArrayError, ConfigError, LearningError, MapError, RecordingError
from andante.mapping.gaze import GazeMap, build_gaze_map
from andante.mapping.gaze_config import GazeConfig
from andante.mapping.gaze_readout import spaced_azimuths
from andante.protocols import Localizer
from andante.recordings import MemoryRecording

SMALL = GazeConfig(regions=36, principal_components=40, slow_features=20, strides=(1, 10), patches=8)


@pytest.fixture(scope="module")
def gaze(days):
    return build_gaze_map(days, SMALL)


def told(gaze, recording, look):
    """Errors in metres and degrees of the best hypotheses."""
    errors = []
    for info in recording.infos:
        best = look(gaze, recording.load(info)).hypotheses[0]
        truth = info.reference
        turn = np.angle(np.exp(1j * (best.heading_rad - truth.heading_rad)))
        errors.append((np.hypot(best.x_m - truth.x_m, best.y_m - truth.y_m), abs(np.degrees(turn))))
    return np.array(errors)


@pytest.mark.parametrize("patches", [3, 8])
def test_an_unseen_day_is_localized_by_patches(gaze, garden, patches):
    errors = told(gaze, garden.another_day(), lambda m, image: m.localize_patches(image, spaced_azimuths(patches, 0.3)))
    assert np.median(errors[:, 0]) < 0.25
    assert np.median(errors[:, 1]) < 3


def test_a_single_patch_is_enough_mostly(gaze, garden):
    errors = told(gaze, garden.another_day(), lambda m, image: m.localize_patches(image, [0.5]))
    assert np.median(errors[:, 0]) < 0.5


def test_half_of_the_horizon_may_be_hidden(gaze, garden):
    def look(m, image):
        hidden = image.copy()
        hidden[:, 20:80] = np.random.default_rng(0).integers(60, 140, (12, 60))
        return m.localize(hidden)

    errors = told(gaze, garden.another_day(), look)
    assert np.median(errors[:, 0]) < 0.3


def test_it_is_a_localizer_whose_estimates_are_complete(gaze, garden):
    assert isinstance(gaze, Localizer)
    friday = garden.another_day()
    estimates = [gaze.localize(friday.load(info)) for info in friday.infos]
    assert any(one.status is Status.OK for one in estimates)
    for one in estimates:
        assert one.hypotheses
        assert "patches agree" in one.reason or "do not agree" in one.reason
        if one.status.has_pose:
            assert one.radius_m > 0
            assert np.isfinite(one.covariance).all()
            assert (one.x_m, one.heading_rad) == (one.hypotheses[0].x_m, one.hypotheses[0].heading_rad)
        else:
            assert one.x_m is None


def test_a_picture_that_shows_nothing_is_lost(gaze):
    estimate = gaze.localize(np.full((12, 120), 7, np.uint8))
    assert estimate.status is Status.LOST
    assert "shows nothing" in estimate.reason


def test_another_garden_is_not_answered_like_the_mapped_one(gaze, garden, other_garden):
    answered = []
    for place in (garden, other_garden):
        friday = place.another_day()
        answered.append(np.mean([gaze.localize(friday.load(one)).status is Status.OK for one in friday.infos]))
    assert answered[1] < 0.2 < answered[0]


def test_a_robot_that_turns_on_the_spot_stays_where_it_is(gaze, garden):
    image = garden.another_day().load(garden.another_day().infos[4])
    azimuth = spaced_azimuths(8)
    told = gaze.look(image, azimuth)
    turned = gaze.look(np.roll(image, 30, axis=1), azimuth - np.pi / 2)
    np.testing.assert_allclose(turned.xy, told.xy, atol=1e-3)
    assert abs(np.angle(np.exp(1j * (turned.heading_rad - told.heading_rad - np.pi / 2)))) < 1e-3


def test_away_from_the_drives_known_things_tell_the_place(gaze, garden):
    errors = []
    for x, y in ((0, 0), (1, 0.5), (-1.5, -0.5), (0.5, -1.2)):
        panorama = garden.panorama((x, y, 0.8))
        found = gaze.resect(panorama, spaced_azimuths(24))
        errors.append(np.hypot(*(found.xy - (x, y))))
    assert np.median(errors) < 1.0


def test_the_same_recordings_give_the_same_map(gaze, days):
    again = build_gaze_map(days, SMALL)
    np.testing.assert_array_equal(again.readout.gallery.slow, gaze.readout.gallery.slow)
    assert again.bounds == gaze.bounds


def test_principal_components_are_an_honest_neighbour(days, garden):
    neighbour = build_gaze_map(days, SMALL.model_copy(update={"representation": "principal"}))
    errors = told(neighbour, garden.another_day(), lambda m, image: m.localize(image))
    assert np.median(errors[:, 0]) < 0.3


def test_a_fisheye_and_its_odometry_alone(garden):
    monday = garden.drive(garden.loop(40), fisheye=True)
    poses = [info.reference for info in monday.infos]
    images = [monday.load(info) for info in monday.infos]
    times = [info.timestamp_s for info in monday.infos]
    driven = MemoryRecording(images, times, monday.camera, odometry=poses, name="driven")
    gaze = build_gaze_map([driven], SMALL.model_copy(update={"positions": "odometry"}))
    best = gaze.localize(images[7]).hypotheses[0]
    assert np.hypot(best.x_m - poses[7].x_m, best.y_m - poses[7].y_m) < 0.3


def test_a_map_comes_back_from_its_file_as_it_was(gaze, garden, tmp_path):
    size = gaze.save(tmp_path / "a.gaze")
    back = GazeMap.load(tmp_path / "a.gaze")
    assert (tmp_path / "a.gaze").stat().st_size == size
    friday = garden.another_day()
    for info in friday.infos[:5]:
        assert back.localize(friday.load(info)).as_dict() == gaze.localize(friday.load(info)).as_dict()
    assert (back.config, back.bounds, back.name) == (gaze.config, gaze.bounds, gaze.name)
    assert [one.content_hash for one in back.sources] == [one.content_hash for one in gaze.sources]


def test_files_that_are_no_maps_of_gazes(gaze, slowmap, tmp_path):
    with pytest.raises(MapError, match=r"cannot be used: there is no such file"):
        GazeMap.load(tmp_path / "none")
    slowmap.save(tmp_path / "other.andante")
    with pytest.raises(MapError, match=r"cannot be used: it is no map of gazes; make it again"):
        GazeMap.load(tmp_path / "other.andante")
    (tmp_path / "text").write_text("a text")
    with pytest.raises(MapError, match=r"is damaged or no map of gazes"):
        GazeMap.load(tmp_path / "text")
    with pytest.raises(MapError, match=r"cannot be written"):
        gaze.save(tmp_path / "missing" / "a.gaze")


def test_a_file_with_arrays_that_do_not_fit(gaze, tmp_path):
    path = tmp_path / "a.gaze"
    gaze.save(path)
    metadata = {"andante-gaze": _metadata(path)}
    arrays = load_file(path)
    save_file(arrays | {"xy": arrays["xy"][:-1].copy()}, path, metadata)
    with pytest.raises(MapError, match=r"cannot be used: its arrays have shapes"):
        GazeMap.load(path)
    save_file(arrays | {"xy": arrays["xy"] * np.nan}, path, metadata)
    with pytest.raises(MapError, match=r"array xy holds values that are not finite"):
        GazeMap.load(path)
    save_file({name: array for name, array in arrays.items() if name != "mean"}, path, metadata)
    with pytest.raises(MapError, match=r"a map of gazes has"):
        GazeMap.load(path)
    save_file(arrays, path, {"andante-gaze": _metadata(path_of(gaze, tmp_path)).replace('"schema": 1', '"schema": 9')})
    with pytest.raises(MapError, match=r"has another schema than 1"):
        GazeMap.load(path)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            lambda text: text.replace('"patches": 1}', '"patches": 2}', 1),
            r"bounds are of \[2, 3, 8, 24\] patches, they have",
        ),
        (lambda text: "[" * 100_000, r"cannot be used: maximum recursion depth"),
    ],
)
def test_a_file_with_a_header_that_is_wrong(gaze, tmp_path, change, message):
    path = path_of(gaze, tmp_path)
    save_file(load_file(path), tmp_path / "a.gaze", {"andante-gaze": change(_metadata(path))})
    with pytest.raises(MapError, match=message):
        GazeMap.load(tmp_path / "a.gaze")


def test_a_drive_of_one_place_can_be_kept(garden, tmp_path):
    """Nothing to mistake it for: margins are infinite, which files cannot hold."""
    small = build_gaze_map([garden.drive(garden.loop(30, radius_m=0.2))], SMALL)
    small.save(tmp_path / "a.gaze")
    assert GazeMap.load(tmp_path / "a.gaze").bounds == small.bounds
    assert small.localize(garden.panorama((0.2, 0.0, 0.0))).status is Status.OK


def path_of(gaze, folder):
    gaze.save(folder / "whole.gaze")
    return folder / "whole.gaze"


def _metadata(path):
    from safetensors import safe_open

    with safe_open(path, framework="numpy") as file:
        return file.metadata()["andante-gaze"]


def test_bad_input(gaze, days, garden, copied):
    with pytest.raises(RecordingError, match=r"a map of gazes needs at least one recording, got none"):
        build_gaze_map([])
    with pytest.raises(RecordingError, match=r"have the same content; leave one out"):
        build_gaze_map([days[0], days[0]], SMALL)
    with pytest.raises(RecordingError, match=r"2 recordings with odometry alone are in frames of their own"):
        build_gaze_map(days, SMALL.model_copy(update={"positions": "odometry"}))
    with pytest.raises(LearningError, match=r"patches are too few to learn from, more than 40 are needed"):
        build_gaze_map([garden.drive(garden.loop(1))], SMALL)
    blind = copied(days[0], reference=[Pose2D(p.x_m, p.y_m) for p in (info.reference for info in days[0].infos)])
    with pytest.raises(RecordingError, match=r"'monday' has no headings; .* needs heading_rad"):
        build_gaze_map([blind], SMALL)
    ahead = copied(days[0], camera=CameraSpec(model="perspective"))
    with pytest.raises(ConfigError, match=r"needs a camera that looks all around, this one is perspective"):
        build_gaze_map([ahead], SMALL)
    with pytest.raises(ArrayError, match=r"each of at least one patch needs an azimuth"):
        gaze.localize_patches(days[0].load(days[0].infos[0]), [])


def test_the_bounds_are_those_of_the_number_of_patches(gaze, days):
    image = days[0].load(days[0].infos[0])
    strict = replace(gaze, bounds=tuple(replace(one, lost_below=1e9 * (one.patches == 3)) for one in gaze.bounds))
    answers = {count: strict.localize_patches(image, spaced_azimuths(count)).status for count in (2, 3, 5, 8)}
    assert [count for count, status in answers.items() if status is Status.LOST] == [3, 5]
