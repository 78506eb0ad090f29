"""What came after makes what came before better."""

import numpy as np
import pytest

from andante.data import Status
from andante.errors import ConfigError
from andante.localization import FixedLagSmoother, make_tracker, smooth


def moments(evidence, infos):
    return [(seen, info, None) for seen, info in zip(evidence, infos, strict=True)]


def test_it_is_closer_than_the_tracker_and_one_estimate_a_frame(world, kind, slowmap):
    poses = world.loop(160)
    infos = world.infos(poses)
    rng = np.random.default_rng(0)
    told = moments([world.image(pose, rng) for pose in poses], infos)
    tracker = make_tracker(slowmap, kind)
    live = [tracker.fuse(*one) for one in told]
    late = list(smooth(make_tracker(slowmap, kind), told, lag=10))
    assert len(late) == 160
    assert world.errors_m(late, infos).mean() < 0.9 * world.errors_m(live, infos).mean()
    assert np.mean(world.errors_m(late, infos) <= [one.radius_m for one in late]) > 0.8
    assert [one.status for one in late[10:]] == [one.status for one in live[10:]]
    assert np.nanmean(world.heading_errors_rad(late, infos)) < np.nanmean(world.heading_errors_rad(live, infos))


def test_the_last_frame_and_a_lag_longer_than_the_drive(world, kind, slowmap):
    poses = world.loop(30)
    told = moments(world.images(poses), world.infos(poses))
    tracker = make_tracker(slowmap, kind)
    live = [tracker.fuse(*one) for one in told]
    for lag in (1, 10, 100):
        late = list(smooth(make_tracker(slowmap, kind), told, lag=lag))
        assert len(late) == 30
        assert late[-1].x_m == pytest.approx(live[-1].x_m)


def test_frames_before_the_first_image_are_told_by_those_after(world, kind, slowmap):
    poses = world.loop(60)
    infos = world.infos(poses)
    evidence = [None if n < 8 else one for n, one in enumerate(world.images(poses))]
    late = list(smooth(make_tracker(slowmap, kind), moments(evidence, infos), lag=20))
    assert {one.status for one in late[:8]} == {Status.DEGRADED}
    assert "came after" in late[0].reason
    assert np.max(world.errors_m(late, infos)[:8]) < 0.4


def test_nothing_is_passed_back_to_before_a_robot_was_carried_away(world, kind, slowmap):
    poses = np.vstack([world.loop(60), world.loop(60, start=110)])
    still = world.infos(poses[:60])
    odometry = [one.odometry for one in still] + [still[-1].odometry] * 60
    late = list(
        smooth(make_tracker(slowmap, kind), moments(world.images(poses), world.infos(poses, odometry=odometry)), lag=20)
    )
    error = world.errors_m(late, world.infos(poses))
    assert np.nanmax(error[:60]) < 0.3


def test_old_frames_and_missing_odometry(world, kind, slowmap):
    poses = world.loop(60)
    infos = world.infos(poses)
    shuffled = [infos[n - 3] if n % 10 == 9 else info for n, info in enumerate(infos)]
    late = list(smooth(make_tracker(slowmap, kind), moments(world.images(poses), shuffled), lag=5))
    assert len(late) == 60
    assert np.nanmax(world.errors_m(late, infos)) < 1.0


def test_it_remembers_no_more_than_its_lag(world, slowmap):
    poses = world.loop(40)
    smoother = FixedLagSmoother(make_tracker(slowmap, "kalman"), lag=5)
    given = [smoother.push(*one) for one in moments(world.images(poses), world.infos(poses))]
    assert [one is None for one in given] == [True] * 5 + [False] * 35
    assert len(list(smoother.flush())) == 5
    assert list(smoother.flush()) == []


def test_a_lag_below_one(slowmap):
    with pytest.raises(ConfigError, match="lag of 0"):
        FixedLagSmoother(make_tracker(slowmap, "kalman"), lag=0)
