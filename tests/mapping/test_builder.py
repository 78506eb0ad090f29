"""From recordings to a map: accuracy, determinism, every choice of the configuration, faults."""

import dataclasses
import subprocess
import sys

import numpy as np
import pytest

from andante.data import CameraSpec, Pose2D, Status
from andante.errors import ConfigError, LearningError, RecordingError
from andante.mapping import BuildLog, FrontEnd, MapConfig, MappedSession, build_map, encode_session, learn_map
from andante.mapping import builder as builder_module
from andante.mapping import learning as learning_module
from andante.mapping import lessons as lessons_module
from andante.mapping import sessions as sessions_module
from andante.mapping.frontend import camera_and_size
from andante.recordings import open_recording, parallel


def bytes_of(slowmap, folder) -> bytes:
    slowmap.save(folder / "map.andante")
    return (folder / "map.andante").read_bytes()


def test_a_drive_in_another_light_is_localized(slowmap, garden, errors_m):
    errors = errors_m(slowmap, garden.another_day())
    assert np.median(errors) < 0.1
    assert errors.max() < 0.5


def test_fisheye_images_give_the_same(fisheye_map, garden, errors_m):
    errors = errors_m(fisheye_map, garden.another_day(fisheye=True))
    assert np.median(errors) < 0.12
    assert errors.max() < 0.5


def test_the_radius_holds_the_truth(slowmap, garden, errors_m):
    day = garden.another_day()
    radius = np.array([slowmap.localize(day.load(info)).radius_m for info in day.infos])
    assert np.mean(errors_m(slowmap, day) <= radius) >= 0.85


def test_the_same_input_gives_the_same_bytes(days, slowmap, tmp_path):
    assert bytes_of(build_map(days), tmp_path) == bytes_of(slowmap, tmp_path)


@pytest.mark.parametrize("workers", [1, 3])
def test_the_number_of_threads_is_invisible(days, slowmap, tmp_path, monkeypatch, workers):
    monkeypatch.setattr(parallel, "default_workers", lambda: workers)
    monkeypatch.setattr(sessions_module, "default_workers", lambda: workers)
    assert bytes_of(build_map(days), tmp_path) == bytes_of(slowmap, tmp_path)


def test_the_size_of_stacks_is_invisible(days, slowmap, tmp_path, monkeypatch):
    monkeypatch.setattr(sessions_module, "STACK", 1)
    assert bytes_of(build_map(days), tmp_path) == bytes_of(slowmap, tmp_path)


def test_the_configuration_is_resolved(slowmap):
    config = slowmap.config
    assert config.positions == "reference"
    assert config.features.kind == "fourier"
    assert config.learning.slow_features == slowmap.model.output_dim == 119  # 120 frames have no more
    assert None not in (config.learning.place_radius_m, config.readout.consensus_m, config.calibration.block_m)


def test_sources_say_where_the_map_came_from(slowmap, days):
    assert [source.name for source in slowmap.sources] == ["monday", "tuesday"]
    assert [source.content_hash for source in slowmap.sources] == [day.content_hash() for day in days]
    assert {(source.frames, source.poses, source.folder) for source in slowmap.sources} == {(60, "reference", None)}
    assert slowmap.sources[1].conditions == {"gain": 0.7}
    assert slowmap.learnt_from(days[0].content_hash())
    assert not slowmap.learnt_from("another")


def test_two_sessions_are_tried_on_each_other_and_one_on_its_blocks(slowmap, days, small_config):
    assert slowmap.calibration.kind == "sessions"
    assert [fold.left_out for fold in slowmap.calibration.folds] == ["monday", "tuesday"]
    assert max(fold.median for fold in slowmap.calibration.folds) < 0.3
    alone = build_map(days[:1], small_config)
    assert alone.calibration.kind == "blocks"
    assert sum(fold.n for fold in alone.calibration.folds) == 60


def test_nothing_but_the_compression_sees_held_out_frames(days, small_config, monkeypatch, copied):
    """With the compression out of the way, other pictures in the held-out session do not change the model of a fold."""
    learnt = []
    original = learning_module.learn_slow

    def spy(x, ground, recipe, seed):
        learnt.append((x.copy(), original(x, ground, recipe, seed)))
        return learnt[-1][1]

    for module in (builder_module, lessons_module):
        monkeypatch.setattr(module, "learn_slow", spy)
    config = small_config.with_values(
        {"learning": {"pca_components": 0, "ridge": 1e-3}, "features": {"n_frequencies": 8}}
    )
    shuffled = [days[1].load(info) for info in days[1].infos]
    shuffled = shuffled[30:] + shuffled[:30]
    build_map(days, config)
    build_map([days[0], copied(days[1], images=shuffled)], config)
    # Whole map, fold without monday, fold without tuesday; twice.
    assert len(learnt) == 6
    without_tuesday, again = learnt[2], learnt[5]
    assert len(without_tuesday[0]) == 60
    np.testing.assert_array_equal(without_tuesday[0], again[0])
    np.testing.assert_array_equal(without_tuesday[1].model.weights, again[1].model.weights)
    np.testing.assert_array_equal(without_tuesday[1].metric, again[1].metric)


CHOICES = [
    ({"learning": {"order": "restructured"}}, 0.3),
    ({"learning": {"order": "temporal"}}, 0.3),
    ({"learning": {"order": "temporal", "edge_ridge": 0.0, "ridge": 0.01}}, 0.4),
    ({"readout": {"kind": "polynomial"}, "learning": {"slow_features": 8}}, 2.0),
    ({"readout": {"kind": "gaussian-process"}}, 0.4),
    ({"learning": {"expansion": "quadratic", "slow_features": 8}}, 1.5),
    ({"learning": {"pca_components": 0, "ridge": 0.01}, "features": {"n_frequencies": 10}}, 0.3),
    ({"features": {"orientations": 0}}, 0.3),
    ({"features": {"normalise": False, "unit": False}}, 1.5),
]


@pytest.mark.parametrize(("values", "bound_m"), CHOICES)
def test_every_choice_works_and_survives_the_file(days, garden, small_config, tmp_path, errors_m, values, bound_m):
    built = build_map(days, small_config.with_values(values))
    day = garden.another_day()
    readings = dataclasses.replace(
        built, calibration=dataclasses.replace(built.calibration, off_map_below=0.0, lost_below=0.0)
    )
    assert np.median(errors_m(readings, day)) < bound_m
    built.save(tmp_path / "map.andante")
    loaded = type(built).load(tmp_path / "map.andante")
    for info in day.infos[::5]:
        assert loaded.localize(day.load(info)).as_dict() == built.localize(day.load(info)).as_dict()


def test_flat_pixels_work_where_the_robot_keeps_its_heading(garden, small_config, errors_m):
    def northward(n, y, gain):
        poses = np.column_stack([np.linspace(-3, 3, n), np.full(n, y), np.zeros(n)])
        return garden.drive(poses, name=f"gain {gain}", gain=gain)

    config = small_config.with_values({"features": {"kind": "flat"}})
    built = build_map([northward(60, 0.0, 1.0), northward(60, 0.05, 0.8)], config)
    assert built.front_end.feature_kind == "flat"
    assert not built.heading_invariant
    assert np.median(errors_m(built, northward(31, 0.02, 0.9))) < 0.2


def test_the_thesis_recipe_runs(days, garden):
    built = build_map(days, MapConfig.thesis())
    assert built.model.output_dim == 8
    assert built.config.learning.order == "restructured"
    estimate = built.localize(garden.panorama(garden.loop(60)[7]))
    assert estimate.status.has_pose


@pytest.mark.parametrize(("positions", "drives"), [("odometry", 2), ("auto", 1)])
def test_positions_from_odometry(days, garden, small_config, positions, drives, errors_m, copied):
    days = [copied(day, reference=None, odometry=[info.reference for info in day.infos]) for day in days[:drives]]
    built = build_map(days, small_config.with_values({"positions": positions}))
    assert built.config.positions == "odometry"
    assert np.median(errors_m(built, garden.another_day())) < 0.3


@pytest.mark.parametrize("positions", ["place", "auto"])
def test_places_give_a_place_and_no_metres(days, small_config, positions, copied):
    drives = [copied(day, reference=None, place=list(range(60))) for day in days]
    built = build_map(drives, small_config.with_values({"positions": positions}))
    assert (built.unit, built.config.positions) == ("place", "place")
    estimates = [built.localize(days[0].load(info)) for info in days[0].infos[5:55:7]]
    assert [abs(estimate.place - place) <= 1 for estimate, place in zip(estimates, range(5, 55, 7), strict=True)]
    for estimate in estimates:
        assert (estimate.x_m, estimate.y_m, estimate.radius_m, estimate.covariance) == (None, None, None, None)


def test_reference_poses_win_over_places_and_odometry(days, small_config, copied):
    both = [copied(day, odometry=[Pose2D(0.1 * i, 9.0) for i in range(60)], place=list(range(60))) for day in days]
    assert build_map(both, small_config).config.positions == "reference"


def test_frames_left_out_are_counted(garden, small_config, copied):
    poses = garden.loop(40)
    drive = garden.drive(np.insert(poses, 20, np.repeat(poses[20:21], 5, axis=0), axis=0))
    reference = [info.reference for info in drive.infos]
    reference[3] = reference[30] = None
    log = BuildLog()
    built = build_map([copied(drive, reference=reference)], small_config, log=log)
    assert (log.stationary, log.without_position) == (5, 2)
    assert built.sources[0].frames == 45 - 5 - 2
    assert set(log.seconds) == {"decode", "features", "learn", "readout"}


def test_progress_is_told(days, small_config):
    told = []
    build_map(days, small_config, progress=lambda *step: told.append(step))
    for name in ("monday", "tuesday"):
        steps = [(done, total) for stage, done, total in told if stage == name]
        assert steps == sorted(steps)
        assert steps[-1] == (60, 60)
    assert told[-4:] == [("learn", done, 3) for done in range(4)]


def encoded(days, config) -> tuple[list[MappedSession], FrontEnd]:
    front_end = FrontEnd(*camera_and_size(days[0]), config.panorama, config.features)
    return [encode_session(day, front_end, "reference", config) for day in days], front_end


def test_learning_from_encoded_sessions_gives_the_very_same_map(days, slowmap, tmp_path):
    sessions, front_end = encoded(days, MapConfig())
    assert bytes_of(learn_map(sessions, front_end), tmp_path) == bytes_of(slowmap, tmp_path)
    # What a map remembers is enough to make it again.
    again = learn_map(slowmap.memory, slowmap.front_end, slowmap.asked)
    assert bytes_of(again, tmp_path) == bytes_of(slowmap, tmp_path)


PROCESS = """
import sys
from pathlib import Path
from andante.mapping import build_map
from andante.recordings import open_recording
build_map([open_recording(folder) for folder in sys.argv[2:]]).save(Path(sys.argv[1]))
"""


def test_another_process_gives_the_same_bytes(days, on_disk, tmp_path):
    folders = [str(on_disk(day).folder) for day in days]
    maps = [tmp_path / f"{name}.andante" for name in ("here", "there")]
    build_map([open_recording(folder) for folder in folders]).save(maps[0])
    subprocess.run([sys.executable, "-c", PROCESS, str(maps[1]), *folders], check=True, timeout=60)
    assert maps[0].read_bytes() == maps[1].read_bytes()


def test_what_is_asked_for_is_kept_beside_what_came_out(days, small_config):
    built = build_map(days, small_config)
    assert built.asked == small_config
    assert (built.asked.learning.edge_ridge, built.asked.learning.place_radius_m) == (None, None)
    assert (built.config.learning.edge_ridge, built.config.learning.invariance) == (10.0, 1.0)
    again = build_map(days, built.config)
    assert again.config == built.config
    np.testing.assert_array_equal(again.model.weights, built.model.weights)


def test_four_drives_choose_how_to_learn(garden, errors_m):
    lights = [(1.0, 0.0), (0.7, 20.0), (0.85, -10.0), (1.1, 5.0)]
    drives = [
        garden.drive(garden.loop(30, 0.2 * n, 3 + 0.02 * n), name=f"day {n}", gain=gain, offset=offset)
        for n, (gain, offset) in enumerate(lights)
    ]
    built = build_map(drives, MapConfig().with_values({"learning": {"edge_ridge": 3.0}}))
    learning = built.config.learning
    assert learning.edge_ridge == 3.0
    assert learning.slow_features in (96, 119)  # of 120 frames there are no 128
    assert learning.invariance in (1.0, 10.0)
    assert built.asked.learning.invariance is None
    assert np.median(errors_m(built, garden.another_day())) < 0.15


def test_a_map_without_memory_is_smaller_and_localizes_the_same(days, slowmap, garden, tmp_path):
    forgetful = build_map(days, MapConfig().with_values({"memory": {"keep": False}}))
    assert forgetful.memory is None
    assert slowmap.memory is not None
    saved = len(bytes_of(slowmap, tmp_path)) - len(bytes_of(forgetful, tmp_path))
    assert saved == pytest.approx(120 * (1440 + 4 + slowmap.front_end.phase_dim + 4 + 16 + 8), rel=0.01)
    for pose in garden.loop(7, 0.3):
        picture = garden.panorama(pose)
        assert forgetful.localize(picture).as_dict() == slowmap.localize(picture).as_dict()
    for built, expected in ((slowmap, 2), (forgetful, None)):
        built.save(tmp_path / "map.andante")
        assert type(built).load(tmp_path / "map.andante").memory is None
        loaded = type(built).load(tmp_path / "map.andante", with_memory=True).memory
        assert (loaded if loaded is None else len(loaded)) == expected


def test_a_bounded_memory_is_what_the_map_is_made_of(days, small_config):
    built = build_map(days, small_config.with_values({"memory": {"max_frames": 100}}))
    kept = [len(session) for session in built.memory]
    assert sum(kept) <= 100
    assert min(kept) >= 40
    assert [source.frames for source in built.sources] == [len(own) for own in built.pictures] == kept
    assert len(built.readout.references) == sum(kept)
    assert sum(fold.n for fold in built.calibration.folds) == sum(kept)


def test_no_sessions_and_copies_of_sessions_make_no_map(days, small_config):
    sessions, front_end = encoded(days, small_config)
    with pytest.raises(RecordingError, match="a map needs at least one recording, got none"):
        learn_map([], front_end, small_config)
    with pytest.raises(RecordingError, match="recordings 'tuesday' and 'tuesday' have the same content; leave one out"):
        learn_map([*sessions, sessions[1]], front_end, small_config)


def test_the_description_says_what_was_held_out_and_in_what_light(slowmap, days, small_config):
    folds = slowmap.describe()["cross_validation"]["folds"]
    assert [fold["conditions"] for fold in folds] == [[{"gain": 1.0}], [{"gain": 0.7}]]
    alone = build_map(days[:1], small_config).describe()["cross_validation"]
    assert {tuple(fold["conditions"]) for fold in alone["folds"]} == {()}


def test_references_are_thinned(days, small_config):
    built = build_map(days, small_config.with_values({"readout": {"max_references": 30}}))
    assert len(built.readout.references) <= 30


def test_no_recording():
    with pytest.raises(RecordingError, match="a map needs at least one recording, got none"):
        build_map([])


def test_the_same_content_twice_is_refused(days, copied):
    twin = copied(days[0], name="twin")
    with pytest.raises(RecordingError, match="recordings 'monday' and 'twin' have the same content; leave one out"):
        build_map([*days, twin])


@pytest.mark.parametrize("n", [2, 3, 9])
def test_too_few_frames(garden, n):
    with pytest.raises(LearningError, match=f"{n} usable frames are too few to learn from"):
        build_map([garden.drive(garden.loop(n))])


def test_one_frame_alone(garden):
    with pytest.raises(LearningError, match="1 usable frames are too few to learn from; record a longer drive"):
        build_map([garden.drive(garden.loop(1))])


def test_fifteen_frames_are_fewer_than_components_and_still_a_map(garden, errors_m):
    drive = garden.drive(garden.loop(120)[:15])
    built = build_map([drive])
    assert built.model.output_dim == 14
    assert errors_m(built, drive).max() < 0.5


def test_pictures_that_never_change_teach_nothing(garden, days, copied):
    frozen = copied(days[0], images=[days[0].load(days[0].infos[0])] * 60)
    for components in (256, 0):
        with pytest.raises(LearningError, match=r"all samples are the same|none of the .* signals varies") as caught:
            build_map([frozen], MapConfig().with_values({"learning": {"pca_components": components}}))
        assert "\n" not in str(caught.value)


def test_a_camera_that_hangs_for_a_while_does_no_harm(days, garden, errors_m, copied):
    pictures = [days[0].load(info) for info in days[0].infos]
    pictures[10:14] = [pictures[10]] * 4
    built = build_map([copied(days[0], images=pictures), days[1]])
    assert len(built.calibration.folds) == 2
    assert np.median(errors_m(built, garden.another_day())) < 0.1


def test_cameras_of_two_kinds_make_no_map(days, garden):
    fisheye = garden.drive(garden.loop(30), fisheye=True, name="up")
    with pytest.raises(ConfigError, match=r"this map was made from panorama images .* the new fisheye camera gives"):
        build_map([days[0], fisheye])


def test_a_panorama_that_goes_round_and_one_that_does_not_make_no_map(days, copied):
    half = dataclasses.replace(days[1].camera, horizontal_field_of_view_deg=200.0)
    with pytest.raises(ConfigError, match="use a camera like the map's"):
        build_map([days[0], copied(days[1], camera=half)])


def test_two_fisheyes_with_different_circles_make_one_map(garden, errors_m, copied):
    days = garden.two_days(fisheye=True)
    moved = CameraSpec(centre_px=(63.5, 57.5), radius_px=58.0)
    pictures = [np.roll(days[1].load(info), (-2, 4), axis=(0, 1)) for info in days[1].infos]
    built = build_map([days[0], copied(days[1], images=pictures, camera=moved)])
    assert np.median(errors_m(built, garden.another_day(fisheye=True))) < 0.12


def test_all_estimates_of_the_mapped_drives_are_ok(slowmap, days):
    for day in days:
        assert {slowmap.localize(day.load(info)).status for info in day.infos} == {Status.OK}
