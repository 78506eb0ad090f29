"""What onnxruntime says of an image is what ``SlowMap`` says of it."""

import dataclasses
import itertools
import math

import numpy as np
import pytest

from andante.data import Estimate, Status
from andante.export.judgement import STATUSES
from andante.mapping import SlowMap
from andante.mapping.codes import Codes

POSE = ("xy", "covariance", "radius", "heading_rad", "heading_deviation_rad")
# Single precision carries seven digits, and features of unit length are weighted by rows as long as 130: 3e-6 measured.
SLOW_TOLERANCE = 3e-5
# Positions within 8 m. A Gaussian process sums up weights of both signs a thousand times larger: 1 mm measured.
XY_TOLERANCE_M = {"local": 3e-5, "polynomial": 1e-4, "gaussian-process": 5e-3}
# Both depend on which places are near, and so on the position.
LIKENESS_TOLERANCE = {"local": 3e-5, "polynomial": 3e-5, "gaussian-process": 3e-3}
HEADING_TOLERANCE_RAD = {"local": 1e-4, "polynomial": 1e-4, "gaussian-process": 3e-3}
# Between its points its variance is what is left of one, of which three digits remain.
RADIUS_TOLERANCE_M = {"local": 1e-3, "polynomial": 1e-3, "gaussian-process": 2e-2}


def assert_same(found: dict[str, np.ndarray], slowmap: SlowMap, image: np.ndarray) -> Estimate:
    """All outputs against the map's own words, which are given back."""
    readout = slowmap.config.readout.kind
    encoded, estimate = slowmap.front_end.encode(image), slowmap.localize(image)
    sighting = slowmap.sight(encoded)
    np.testing.assert_allclose(found["slow"], slowmap.model.transform(encoded.features)[0], atol=SLOW_TOLERANCE)
    np.testing.assert_allclose(found["likeness"], sighting.likeness, atol=LIKENESS_TOLERANCE[readout])
    np.testing.assert_allclose(found["likeness"], estimate.likeness, atol=LIKENESS_TOLERANCE[readout])
    np.testing.assert_allclose(found["agreement"], sighting.located.agreement, atol=1e-4)
    assert STATUSES[found["status"].item()] == estimate.status
    if not estimate.status.has_pose:
        assert all(np.isnan(found[name]).all() for name in POSE)
        return estimate
    np.testing.assert_allclose(found["xy"], sighting.located.xy[0], atol=XY_TOLERANCE_M[readout])
    np.testing.assert_allclose(found["radius"], estimate.radius_m, atol=RADIUS_TOLERANCE_M[readout])
    expected = estimate.covariance[:2, :2]
    np.testing.assert_allclose(found["covariance"], expected, rtol=1e-3, atol=2e-2 * RADIUS_TOLERANCE_M[readout])
    heading, deviation = found["heading_rad"].item(), found["heading_deviation_rad"].item()
    assert np.isnan(heading) == np.isnan(deviation) == (estimate.heading_rad is None)
    if estimate.heading_rad is not None:
        assert abs(math.remainder(heading - estimate.heading_rad, 2 * math.pi)) < HEADING_TOLERANCE_RAD[readout]
        assert -np.pi <= heading < np.pi
        assert deviation == pytest.approx(math.sqrt(estimate.covariance[2, 2]), rel=10 * LIKENESS_TOLERANCE[readout])
    return estimate


@pytest.mark.parametrize(
    ("fisheye", "readout", "expansion"),
    list(itertools.product((False, True), ("local", "polynomial", "gaussian-process"), ("linear", "quadratic"))),
)
def test_every_image_of_all_drives(fisheye, readout, expansion, map_of, drives, running):
    slowmap = map_of(fisheye=fisheye, readout=readout, expansion=expansion)
    exported = running(slowmap)
    for recording in drives(fisheye):
        for info in recording.infos:
            image = recording.load(info)
            assert_same(exported(image), slowmap, image)


@pytest.mark.parametrize("readout", ["local", "polynomial"])
def test_robots_that_look_any_way(readout, map_of, garden, running):
    slowmap = map_of(readout=readout)
    exported, told = running(slowmap), []
    for turn, pose in enumerate(garden.loop(60, 0.3)):
        image = garden.panorama((*pose[:2], 0.9 * turn), 0.6, 40)
        told.append(assert_same(exported(image), slowmap, image).heading_rad)
    assert sum(heading is not None for heading in told) > 30


def test_places_that_only_their_phases_tell_apart(garden, small_map, running):
    """Every reference is there twice; the compass finds the twin, which has phases of its own."""
    readout, compass = small_map.readout, small_map.compass
    away = np.array([40.0, 0.0])
    twice = dataclasses.replace(
        readout,
        codes=Codes.joined([readout.codes, readout.codes]),
        xy=np.concatenate([readout.xy, readout.xy + away]),
        spread=np.tile(readout.spread, 2),
    )
    foreign = Codes.of(compass.codes.rows()[::-1].copy())
    for right, codes in ((0, [compass.codes, foreign]), (1, [foreign, compass.codes])):
        both = dataclasses.replace(
            compass, codes=Codes.joined(codes), xy=np.concatenate([compass.xy, compass.xy + away])
        )
        slowmap = dataclasses.replace(small_map, readout=twice, compass=both)
        exported, sides = running(slowmap), []
        for pose in garden.loop(30, 0.3):
            image = garden.panorama((*pose[:2], 1.0))
            estimate = assert_same(exported(image), slowmap, image)
            if estimate.x_m is not None:
                sides.append(estimate.x_m > 20)
        assert len(sides) > 15
        assert np.mean(sides) == pytest.approx(right, abs=0.1)


@pytest.mark.parametrize("missing", ["compass", "heading_factor"])
def test_maps_that_tell_no_headings(missing, small_map, drives, running):
    if missing == "compass":
        slowmap = dataclasses.replace(small_map, compass=None)
    else:
        calibration = dataclasses.replace(small_map.calibration, heading_factor=None)
        slowmap = dataclasses.replace(small_map, calibration=calibration)
    exported = running(slowmap)
    for info in drives(False)[2].infos:
        image = drives(False)[2].load(info)
        assert assert_same(exported(image), slowmap, image).heading_rad is None


@pytest.mark.parametrize("places", [1, 2, 3])
def test_few_places(places, small_map, drives, running):
    compass = small_map.compass
    few = dataclasses.replace(compass, codes=compass.codes.subset(slice(places)), xy=compass.xy[:places])
    slowmap = dataclasses.replace(small_map, compass=few)
    exported = running(slowmap)
    for info in drives(False)[2].infos:
        image = drives(False)[2].load(info)
        assert_same(exported(image), slowmap, image)


def test_noise_and_blends_of_two_places(garden, small_map, running):
    """Images of which the votes and the headings are as unclear as can be."""
    exported, rng = running(small_map), np.random.default_rng(3)
    poses = garden.loop(40)
    for one, other in zip(poses, poses[rng.permutation(40)], strict=True):
        image = garden.panorama(one) / 2 + garden.panorama(other) / 2 + rng.normal(0, 5, (12, 120))
        image = np.clip(image, 0, 255).astype(np.uint8)
        assert_same(exported(image), small_map, image)


def test_foreign_places_have_no_position(garden, small_map, running):
    exported, elsewhere = running(small_map), type(garden)(seed=5)
    expected = []
    for pose in garden.loop(40):
        image = elsewhere.panorama(pose)
        status = small_map.localize(image).status
        found = exported(image)
        assert STATUSES[found["status"].item()] == status
        assert np.isnan(found["xy"]).all() == np.isnan(found["covariance"]).all() == (not status.has_pose)
        expected.append(status)
    assert Status.OFF_MAP in expected


def test_a_blank_image_is_lost(small_map, running):
    found = running(small_map)(np.full(small_map.front_end.image_shape, 7, np.uint8))
    assert STATUSES[found["status"].item()] is Status.LOST
    assert all(np.isnan(found[name]).all() for name in POSE)
    assert np.isfinite(found["slow"]).all()


@pytest.mark.parametrize("neighbours", [1, 2, 5, 9])
def test_fewer_neighbours(neighbours, small_map, drives, running):
    slowmap = dataclasses.replace(small_map, readout=dataclasses.replace(small_map.readout, neighbours=neighbours))
    exported, recording = running(slowmap), drives(False)[2]
    for info in recording.infos:
        image = recording.load(info)
        estimate = slowmap.localize(image)
        if estimate.status.has_pose:
            np.testing.assert_allclose(exported(image)["xy"], (estimate.x_m, estimate.y_m), atol=1e-4)


def test_images_of_another_size(map_of, garden, running):
    slowmap = map_of(fisheye=True)
    exported = running(slowmap, image_shape=(240, 240))
    assert exported.exported.inputs == {"image": (240, 240)}
    for pose in garden.loop(8):
        image = np.repeat(np.repeat(garden.fisheye(pose), 2, axis=0), 2, axis=1)
        estimate = slowmap.localize(image)
        np.testing.assert_allclose(exported(image)["xy"], (estimate.x_m, estimate.y_m), atol=1e-4)


def test_the_thesis_polynomial_of_higher_degree(map_of, drives, running):
    slowmap = map_of(readout={"kind": "polynomial", "degree": 4, "inputs": 3})
    exported, recording = running(slowmap), drives(False)[2]
    for info in recording.infos:
        image = recording.load(info)
        estimate = slowmap.localize(image)
        np.testing.assert_allclose(exported(image)["xy"], (estimate.x_m, estimate.y_m), atol=1e-3)
