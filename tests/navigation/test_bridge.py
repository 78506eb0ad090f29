import numpy as np
import pytest

from andante.angles import wrapped
from andante.data import Estimate, Pose2D, Status
from andante.navigation.bridge import Bridge
from andante.protocols import View

FRAME = np.array([3.0, -2.0, 0.7])  # of odometry, in the map


def in_map(odometry):
    cos, sin = np.cos(FRAME[2]), np.sin(FRAME[2])
    x, y = FRAME[:2] + np.array([[cos, -sin], [sin, cos]]) @ odometry[:2]
    return np.array([x, y, FRAME[2] + odometry[2]])


def view(step, odometry, *, status=Status.OK, heading=True, off=(0.0, 0.0), seconds=0.2):
    x, y, turn = in_map(odometry)
    if status.has_pose:
        estimate = Estimate(status, "", x + off[0], y + off[1], turn if heading else None)
    else:
        estimate = Estimate(status, "")
    return View(seconds * step, estimate, Pose2D(*odometry))


def curve(steps):
    """Odometry along an arc, 0.1 m a step."""
    turn = 0.05 * np.arange(steps)
    return np.column_stack([2.0 * np.sin(turn), 2.0 * (1 - np.cos(turn)), turn])


def close(pose, odometry, metres=1e-6):
    x, y, turn = in_map(odometry)
    return np.hypot(pose.x_m - x, pose.y_m - y) < metres and abs(wrapped(pose.heading_rad - turn)) < metres


def test_with_a_heading_the_first_estimate_is_enough():
    bridge, way = Bridge(), curve(3)
    assert all(close(bridge.update(view(n, row)), row) for n, row in enumerate(way))


def test_the_heading_follows_from_the_way():
    bridge, way = Bridge(), curve(30)
    poses = [bridge.update(view(n, row, heading=False)) for n, row in enumerate(way)]
    assert poses[0] is None
    assert bridge.update(view(30, way[-1], heading=False)) is not None
    known = next(n for n, pose in enumerate(poses) if pose is not None)
    assert 4 <= known <= 12
    assert all(close(pose, row) for pose, row in zip(poses[known:], way[known:], strict=True))


def test_it_says_when_only_the_heading_is_missing():
    bridge = Bridge()
    assert not bridge.waits_for_heading
    bridge.update(view(0, curve(1)[0], heading=False))
    assert bridge.waits_for_heading


def test_odometry_goes_on_for_a_while():
    bridge, way = Bridge(reach_m=1.0), curve(40)
    bridge.update(view(0, way[0]))
    poses = [bridge.update(view(n, row, status=Status.LOST)) for n, row in enumerate(way[1:], 1)]
    known = [pose for pose in poses if pose is not None]
    assert len(known) == 10
    assert all(close(pose, row) for pose, row in zip(known, way[1:], strict=False))
    assert known[-1].bridged_m == pytest.approx(1.0, abs=0.01)


def test_standing_it_lasts_only_so_long():
    bridge, here = Bridge(reach_s=2.0), curve(1)[0]
    bridge.update(view(0, here))
    assert bridge.update(view(10, here, status=Status.LOST)) is not None
    assert bridge.update(view(11, here, status=Status.LOST)) is None


def test_jitter_is_smoothed():
    rng, way = np.random.default_rng(0), curve(200)
    bridge = Bridge()
    off = rng.normal(0.0, 0.1, (200, 2))
    errors = []
    for n, row in enumerate(way):
        pose = bridge.update(view(n, row, off=off[n]))
        errors.append(np.hypot(*(np.array([pose.x_m, pose.y_m]) - in_map(row)[:2])))
    assert np.mean(errors[20:]) < 0.7 * np.hypot(*off.T).mean()


def test_one_estimate_far_off_is_ignored_and_three_are_followed():
    bridge, way = Bridge(), curve(20)
    for n in range(10):
        bridge.update(view(n, way[n]))
    assert close(bridge.update(view(10, way[10], off=(5.0, 0.0))), way[10])
    assert close(bridge.update(view(11, way[11])), way[11])
    far = [bridge.update(view(n, way[n], off=(5.0, 0.0))) for n in (12, 13, 14)]
    assert far[-1].x_m == pytest.approx(in_map(way[14])[0] + 5.0)


def test_doubtful_estimates_make_doubtful_poses():
    bridge = Bridge()
    assert not bridge.update(view(0, curve(1)[0])).doubtful
    assert bridge.update(view(1, curve(1)[0], status=Status.DEGRADED)).doubtful


def test_the_point_ahead():
    pose = Bridge().update(view(0, np.zeros(3)))
    assert pose.ahead(2.0) == pytest.approx((3.0 + 2.0 * np.cos(0.7), -2.0 + 2.0 * np.sin(0.7)))
