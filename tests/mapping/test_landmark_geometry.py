"""Landmarks as things in the map: found from bearings, and what their boxes say of the pose."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.landmarks.boxes import Box
from andante.mapping.landmark_geometry import Geometry, adjusted, refined

THINGS = np.array([[6.0, 1.0], [-4.0, 5.0], [1.0, -7.0]])
TOP_M = 2.0
LOOSE = np.tile(np.eye(2) * 4.0, (3, 1, 1))


def box_of(thing: np.ndarray, pose: np.ndarray, off: float = 0.0) -> Box:
    """As the horizon camera of a robot sees a thing that rises ``TOP_M`` above it."""
    away = thing - pose[:2]
    top = np.arctan(TOP_M / np.linalg.norm(away))
    azimuth = np.angle(np.exp(1j * (np.arctan2(away[1], away[0]) - pose[2] + off)))
    return Box(float(azimuth), float(top / 2), 0.1, float(top))


@pytest.fixture(scope="module")
def poses() -> np.ndarray:
    rng = np.random.default_rng(0)
    return np.column_stack([rng.uniform(-3, 3, (60, 2)), rng.uniform(-np.pi, np.pi, 60)])


@pytest.fixture(scope="module")
def geometries(poses) -> list[Geometry]:
    return [Geometry.fit([box_of(thing, pose) for pose in poses], poses) for thing in THINGS]


def test_a_landmark_stands_where_its_bearings_meet(geometries):
    found = np.array([(one.x_m, one.y_m) for one in geometries])
    np.testing.assert_allclose(found, THINGS, atol=1e-6)
    np.testing.assert_allclose([one.rise for one in geometries], np.log(TOP_M), atol=1e-6)


def test_boxes_that_are_half_hidden_do_not_move_it(poses):
    rng = np.random.default_rng(1)
    off = np.where(rng.random(60) < 0.15, 0.5, rng.normal(0, 0.01, 60))
    found = Geometry.fit([box_of(THINGS[0], pose, error) for pose, error in zip(poses, off, strict=True)], poses)
    np.testing.assert_allclose([found.x_m, found.y_m], THINGS[0], atol=0.1)
    assert 0.005 < found.bearing_rad < 0.03


def test_without_headings_or_different_directions_it_stands_nowhere(poses):
    unknown = poses.copy()
    unknown[:, 2] = np.nan
    boxes = [box_of(THINGS[0], pose) for pose in poses]
    assert Geometry.fit(boxes, unknown) is None
    assert Geometry.fit(boxes[:4], poses[:4]) is None
    standing = np.repeat(poses[:1], 20, axis=0)
    assert Geometry.fit([box_of(THINGS[0], pose) for pose in standing], standing) is None


@settings(max_examples=40, deadline=None)
@given(st.floats(-2.5, 2.5), st.floats(-2.5, 2.5), st.floats(-3.1, 3.1), st.integers(0, 2**32))
def test_three_boxes_correct_rough_positions_and_tell_the_heading(geometries, x, y, heading, seed):
    pose, rng = np.array([x, y, heading]), np.random.default_rng(seed)
    rough = pose[:2] + rng.normal(0, 0.5, (3, 2))
    found = adjusted(rough, LOOSE, [box_of(thing, pose) for thing in THINGS], geometries)
    np.testing.assert_allclose(found.pose[:2], pose[:2], atol=0.05)
    assert abs(np.angle(np.exp(1j * (found.pose[2] - heading)))) < 0.02
    assert np.linalg.eigvalsh(found.covariance).min() > 0
    assert np.trace(found.covariance[:2, :2]) < np.trace(LOOSE[0])


def test_a_single_landmark_gives_a_heading_and_keeps_the_position(geometries):
    pose = np.array([1.0, -1.0, 0.5])
    found = adjusted(pose[None, :2], LOOSE[:1] / 400, [box_of(THINGS[1], pose)], geometries[1:2])
    np.testing.assert_allclose(found.pose, pose, atol=1e-3)
    assert np.isfinite(found.covariance).all()


def test_a_place_taken_for_another_is_outvoted(geometries):
    pose = np.array([1.0, -1.0, 0.5])
    rough = np.array([pose[:2] + 0.05, pose[:2] - 0.05, [15.0, 15.0]])
    found = adjusted(rough, LOOSE / 400, [box_of(thing, pose) for thing in THINGS], geometries)
    np.testing.assert_allclose(found.pose[:2], pose[:2], atol=0.1)


def test_where_the_robot_is_turned_changes_the_heading_alone(geometries):
    pose = np.array([0.5, 0.7, 0.2])
    rough = pose[:2] + np.array([[0.3, 0.0], [0.0, -0.2], [0.1, 0.1]])
    turned = pose + np.array([0, 0, 2.0])
    first, second = (
        adjusted(rough, LOOSE, [box_of(thing, one) for thing in THINGS], geometries) for one in (pose, turned)
    )
    np.testing.assert_allclose(first.pose[:2], second.pose[:2], atol=1e-4)
    assert second.pose[2] - first.pose[2] == pytest.approx(2.0, abs=1e-4)


def test_a_known_pose_is_pulled_towards_what_boxes_say_and_no_further(geometries):
    true = np.array([0.5, -0.8, 2.0])
    boxes = [box_of(thing, true) for thing in THINGS]
    off = true + np.array([0.3, 0.2, 0.02])
    found = refined(off, np.diag([0.2**2, 0.2**2, 0.02**2]), boxes, geometries)
    np.testing.assert_allclose(found.pose, true, atol=0.02)
    assert (found.fit < 2.0).all()
    assert (np.diag(found.covariance) < [0.2**2, 0.2**2, 0.02**2]).all()
    sure = refined(off, np.diag([1e-4**2, 1e-4**2, 1e-5**2]), boxes, geometries)
    np.testing.assert_allclose(sure.pose, off, atol=1e-3)


def test_what_is_seen_elsewhere_moves_a_known_pose_little_and_does_not_fit(geometries):
    pose, covariance = np.array([0.0, 0.0, 0.3]), np.diag([0.1**2, 0.1**2, 0.01**2])
    found = refined(pose, covariance, [box_of(THINGS[0], pose, 0.6)], geometries[:1])
    assert np.hypot(*found.pose[:2]) < 0.05
    assert found.fit[0] > 15


def test_what_pulls_the_pose_to_itself_does_not_fit_for_that():
    # Sharply seen, and far from where a pose that is not as sure expects it: the pose follows, at no cost to the box.
    pose, covariance = np.array([0.0, 0.0, 0.3]), np.diag([0.1**2, 0.1**2, np.radians(0.5) ** 2])
    sharp = Geometry(*THINGS[0].tolist(), np.radians(0.3), np.log(TOP_M), 0.05)
    found = refined(pose, covariance, [box_of(THINGS[0], pose, np.radians(5.0))], [sharp])
    assert np.hypot(*found.pose[:2]) > 0.2
    assert 3.0 < found.fit[0] < 5.0


def test_slopes_are_those_of_what_is_expected(geometries):
    pose = np.array([0.5, -0.8, 2.0])
    sigma = [2 * one.bearing_rad for one in geometries]
    boxes = [box_of(thing, pose) for thing in THINGS]
    for axis, step in enumerate(np.eye(3) * 1e-4):
        spread = np.zeros((3, 3))
        spread[axis, axis] = 1.0
        prior = spread + np.eye(3) * 1e-12
        off = [
            box.azimuth_rad - box_of(thing, pose + step).azimuth_rad for box, thing in zip(boxes, THINGS, strict=True)
        ]
        expected = np.abs(off) / np.hypot(sigma, np.array(off) / 1e-4)
        np.testing.assert_allclose(refined(pose + step, prior, boxes, geometries).fit, expected, rtol=1e-2, atol=1e-9)
