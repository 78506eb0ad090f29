"""What onnxruntime says of an image is what ``SlowMap`` says of it."""

import dataclasses
import itertools

import numpy as np
import pytest

from andante.data import Status
from andante.export.judgement import STATUSES
from andante.mapping.located import tempered

# Single precision carries seven digits, and features of unit length are weighted by rows as long as 130: 3e-6 measured.
SLOW_TOLERANCE = 3e-5
# Positions within 8 m. A Gaussian process sums up weights of both signs a thousand times larger: 1 mm measured.
XY_TOLERANCE_M = {"local": 3e-5, "polynomial": 1e-4, "gaussian-process": 5e-3}
# Between its points its variance is what is left of one, of which three digits remain.
COVARIANCE_TOLERANCE_M2 = {"local": 1e-5, "polynomial": 3e-5, "gaussian-process": 3e-4}


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
            found = exported(image)
            features = slowmap.front_end.features(image)[None]
            slow, spread = slowmap.model.transform(features), slowmap.model.spread(features)
            located = slowmap.readout.locate(slow)
            estimate = slowmap.localize(image)
            np.testing.assert_allclose(found["slow"], slow[0], atol=SLOW_TOLERANCE)
            likeness = tempered(located.likeness, spread, located.spread)
            np.testing.assert_allclose(found["likeness"], likeness, atol=3e-5)
            np.testing.assert_allclose(found["agreement"], located.agreement, atol=1e-4)
            assert STATUSES[found["status"].item()] == estimate.status
            if estimate.status.has_pose:
                np.testing.assert_allclose(found["xy"], located.xy[0], atol=XY_TOLERANCE_M[readout])
                np.testing.assert_allclose(
                    found["covariance"], located.covariance[0], atol=COVARIANCE_TOLERANCE_M2[readout]
                )
                radius_tolerance = 2e-2 if readout == "gaussian-process" else 1e-3
                np.testing.assert_allclose(found["radius"], estimate.radius_m, atol=radius_tolerance)
            else:
                assert np.isnan(found["xy"]).all()


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
    assert all(np.isnan(found[name]).all() for name in ("xy", "covariance", "radius"))
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
