"""Maps of raw images: learnt in one go with their network, alike every time, and able to learn more."""

import dataclasses

import numpy as np
import pytest

from andante.data import CameraSpec
from andante.errors import ConfigError, MapError
from andante.mapping import BuildLog, FrontEnd, MapConfig, build_map, encode_session, learn_map, merge_maps, update_map
from andante.mapping.frontend import camera_and_size
from andante.mapping.network import same_network
from andante.mapping.network_lesson import network_edges
from andante.recordings import MemoryRecording

from .test_network import SMALL

CONFIG = MapConfig().with_values(SMALL)


@pytest.fixture(scope="module")
def friday(garden):
    return garden.another_day()


@pytest.fixture(scope="module")
def built(days):
    return build_map(days, CONFIG)


@pytest.mark.parametrize(
    ("values", "within_m"),
    [
        ({}, 0.15),
        ({"readout": {"kind": "polynomial"}}, 1.2),
        ({"readout": {"kind": "gaussian-process"}}, 0.4),
        ({"learning": {"expansion": "quadratic", "slow_features": 8}}, 0.4),
        ({"learning": {"order": "restructured"}}, 0.3),
        ({"learning": {"order": "temporal"}}, 0.4),
    ],
)
def test_every_readout_and_order_finds_its_way(values, within_m, days, friday):
    slowmap = build_map(days, CONFIG.with_values(values))
    features = np.array([slowmap.front_end.features(friday.load(info)) for info in friday.infos])
    found = slowmap.readout.locate(slowmap.model.transform(features)).xy
    truth = np.array([(info.reference.x_m, info.reference.y_m) for info in friday.infos])
    assert np.median(np.linalg.norm(found - truth, axis=1)) < within_m


def test_the_same_drives_give_the_same_file(built, days, tmp_path):
    built.save(tmp_path / "one.andante")
    build_map(days, CONFIG).save(tmp_path / "two.andante")
    assert (tmp_path / "one.andante").read_bytes() == (tmp_path / "two.andante").read_bytes()


def test_drives_are_encoded_as_any_other_session_is(built, days):
    for day, mapped in zip(days, built.memory, strict=True):
        again = encode_session(day, built.front_end, "reference", CONFIG)
        np.testing.assert_array_equal(again.codes.codes, mapped.codes.codes)
        np.testing.assert_array_equal(again.codes.scale, mapped.codes.scale)


def test_an_updated_map_is_that_of_all_drives_given_the_network(built, friday, tmp_path):
    updated, trial = update_map(built, friday)
    assert trial.objection is None
    assert same_network(updated.front_end.network, built.front_end.network)
    session = encode_session(friday, built.front_end, "reference", CONFIG)
    learn_map([*built.memory, session], built.front_end, CONFIG).save(tmp_path / "together.andante")
    updated.save(tmp_path / "updated.andante")
    assert (tmp_path / "updated.andante").read_bytes() == (tmp_path / "together.andante").read_bytes()


def test_maps_with_networks_of_their_own_cannot_be_merged(built, days, friday):
    with pytest.raises(
        MapError, match=r"each has learnt a network of its own .* update one of them with the recordings"
    ):
        merge_maps(built, build_map([days[1], friday], CONFIG))
    # With one and the same network they can.
    updated, _ = update_map(built, friday)
    merged, trials = merge_maps(built, updated)
    assert len(merged.sources) == 3
    assert [trial.name for trial in trials] == ["friday"]


def test_the_thesis_network_keeps_its_eight_outputs(days, garden):
    values = {"layers": [*SMALL["network"]["layers"][:2], {"output_dim": 8, "reduced_dim": 12}], "depth": 4}
    slowmap = build_map(days, MapConfig.thesis_pixels().with_values({"network": values}))
    assert (slowmap.model.input_dim, slowmap.model.output_dim) == (8, 8)
    assert slowmap.config.learning.expansion == "linear"
    features = np.array([slowmap.front_end.features(garden.panorama(pose)) for pose in garden.loop(20)])
    slow = slowmap.model.transform(features)
    # One linear map leads from one to the other and back: nothing is lost or bent.
    design = np.column_stack([slow, np.ones(len(slow))])
    back = design @ np.linalg.lstsq(design, features, rcond=None)[0]
    np.testing.assert_allclose(back, features, atol=2e-2)


def test_seconds_and_progress_tell_of_the_network(days):
    told, log = [], BuildLog()
    build_map(days, CONFIG, progress=lambda *step: told.append(step), log=log)
    assert log.seconds["network"] > 0
    for stage, frames in (("monday", 60), ("tuesday", 60), ("network", 5 * 120), ("encode", 120)):
        steps = [(done, total) for name, done, total in told if name == stage]
        assert steps == sorted(steps)
        assert steps[-1] == (frames, frames)


def without_codes(days, poses="reference"):
    front_end = FrontEnd(*camera_and_size(days[0]), CONFIG.panorama, MapConfig().features)
    sessions = [encode_session(day, front_end, "reference", CONFIG) for day in days]
    return [dataclasses.replace(one, source=dataclasses.replace(one.source, poses=poses)) for one in sessions]


def test_edges_join_pictures_in_time_and_near_ones_of_other_drives(days):
    sessions = without_codes(days)
    edges = network_edges(sessions, CONFIG)
    in_time = (edges.second - edges.first == 1) & (edges.first != 59)
    assert in_time.sum() == 2 * 59
    first, second = edges.first[~in_time], edges.second[~in_time]
    assert 60 <= len(first) <= 120
    assert ((first < 60) != (second < 60)).all()
    xy = np.concatenate([session.xy for session in sessions])
    assert np.linalg.norm(xy[first] - xy[second], axis=1).max() < 1
    fewer = network_edges(sessions, CONFIG.with_values({"network": {"neighbours": 0}}))
    assert len(fewer) == 2 * 59


def test_frames_without_a_position_leave_no_holes_in_time(days):
    every_second = [one.subset(np.arange(0, len(one), 2)) for one in without_codes(days)[:1]]
    assert len(network_edges(every_second, CONFIG)) == 29


def test_regular_drives_are_all_joined_with_each_other(days):
    alike = [dataclasses.replace(one) for one in without_codes(days)[:1] * 5]
    edges = network_edges(alike, CONFIG)
    pairs = {(a // 60, b // 60) for a, b in zip(edges.first.tolist(), edges.second.tolist(), strict=True)}
    assert {(a, b) for a in range(5) for b in range(a + 1, 5)} <= pairs


def test_drives_that_know_their_odometry_alone_are_learnt_along_time(days):
    assert len(network_edges(without_codes(days, poses="odometry"), CONFIG)) == 2 * 59


def test_frames_of_many_drives_have_a_bounded_number_of_edges(days, friday, garden):
    many = [*days, friday, garden.drive(garden.loop(60, 0.7), name="sunday")]
    sessions = without_codes(many)
    frames = sum(len(session) for session in sessions)
    assert len(network_edges(sessions, CONFIG)) <= 2 * frames - len(many)


def test_small_pictures_are_refused_before_they_are_read(days):
    with pytest.raises(ConfigError, match="at least 30x24 px, this camera gives 120x12; take features of kind flat"):
        build_map(days, MapConfig().with_values({"features": {"kind": "pixels"}}))


def test_a_camera_that_gives_other_panoramas_is_refused(built):
    with pytest.raises(ConfigError, match="use a camera like the map's"):
        built.for_camera(CameraSpec(model="panorama"), np.zeros((10, 100), np.uint8))
    alike = built.for_camera(
        dataclasses.replace(built.front_end.camera, forward_deg=90.0), np.zeros((12, 120), np.uint8)
    )
    assert alike.front_end.network is built.front_end.network


def test_odometry_alone_is_enough(days, garden, copied):
    drives: list[MemoryRecording] = []
    for day in days:
        reference = [info.reference for info in day.infos]
        drives.append(copied(day, reference=[None] * 60, odometry=reference))
    slowmap = build_map(drives[:1], CONFIG)
    assert slowmap.config.positions == "odometry"
    assert slowmap.localize(garden.panorama(garden.loop(60)[7])).status.has_pose
