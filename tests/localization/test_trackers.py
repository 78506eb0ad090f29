"""Everything that may go wrong on a drive, with images that know headings and with such that do not."""

from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from andante.data import Estimate, Fix, Frame, Hypothesis, Pose2D, Status
from andante.errors import ImageError, InputError
from andante.localization import Evidence, KalmanTracker, ParticleTracker, make_tracker
from andante.protocols import Tracker


def followed(tracker, evidence, infos, fixes=None):
    """One estimate a frame, each checked for what always holds."""
    fixes = fixes or [None] * len(infos)
    out = []
    for seen, info, fix in zip(evidence, infos, fixes, strict=True):
        estimate = tracker.fuse(seen, info, fix)
        assert estimate.reason
        assert (estimate.x_m is not None) == estimate.status.has_pose
        if estimate.hypotheses:
            weights = [one.weight for one in estimate.hypotheses]
            assert sum(weights) == pytest.approx(1.0)
            assert weights == sorted(weights, reverse=True)
        if estimate.status.has_pose:
            assert estimate.covariance.shape == (3, 3)
            assert estimate.radius_m > 0
            known = estimate.covariance if estimate.heading_rad is not None else estimate.covariance[:2, :2]
            assert (np.linalg.eigvalsh(known) > 0).all()
        estimate.as_dict()
        out.append(estimate)
    return out


@pytest.fixture
def drive(world):
    poses = world.loop(160)
    return world.images(poses), world.infos(poses)


def test_it_follows_a_drive_from_an_unknown_start(world, kind, slowmap, drive):
    evidence, infos = drive
    out = followed(make_tracker(slowmap, kind), evidence, infos)
    error = world.errors_m(out, infos)
    single = [
        np.hypot(e.estimate.x_m - i.reference.x_m, e.estimate.y_m - i.reference.y_m)
        for e, i in zip(*drive, strict=True)
    ]
    assert np.mean(error) <= 1.05 * np.mean(single)
    assert not world.oks(out)[:2].any()
    assert world.oks(out)[6:].all()
    assert np.degrees(np.median(world.heading_errors_rad(out, infos)[20:])) < 4
    assert np.mean(error <= [one.radius_m for one in out]) > 0.8


def test_a_robot_that_is_carried_away_is_found_again(world, kind, slowmap):
    poses = np.vstack([world.loop(60), world.loop(60, start=110)])
    infos = world.infos(poses[:60]) + world.infos(poses[60:], seed=1)
    # Odometry notices nothing.
    last = infos[59].odometry
    infos = world.in_time(
        infos[:60]
        + [
            replace(
                one, odometry=Pose2D(one.odometry.x_m + last.x_m, one.odometry.y_m + last.y_m, one.odometry.heading_rad)
            )
            for one in infos[60:]
        ]
    )
    out = followed(make_tracker(slowmap, kind), world.images(poses), infos)
    error, ok = world.errors_m(out, infos), world.oks(out)
    assert not (ok & (error > 1)).any()
    assert np.nanmax(error[70:]) < 0.5
    assert ok[75:].all()
    assert any("jumped" in one.reason for one in out[60:63])


@pytest.mark.parametrize("blank", [True, False], ids=["dazzled", "no picture"])
def test_it_goes_on_blindly_doubts_itself_and_recovers(world, kind, slowmap, drive, blank):
    evidence, infos = drive
    evidence = [(world.blank() if blank else None) if 40 <= n < 120 else one for n, one in enumerate(evidence)]
    out = followed(make_tracker(slowmap, kind), evidence, infos)
    error, ok = world.errors_m(out, infos), world.oks(out)
    assert ok[35:40].all()
    assert not ok[50:120].any()
    assert out[60].status == Status.DEGRADED
    assert "confirmed" in out[60].reason
    assert out[110].radius_m > out[60].radius_m > out[39].radius_m
    assert np.nanmax(error) < 1.0
    assert ok[126:].all()


def test_blind_for_minutes_it_is_lost(world, kind, slowmap):
    poses = world.loop(60)
    infos = world.infos(poses)
    tracker = make_tracker(slowmap, kind)
    followed(tracker, world.images(poses), infos)
    ahead, status = infos[-1], []
    for n in range(1, 900):
        turn = 0.3 * np.sin(n / 20)
        moved = Pose2D(ahead.odometry.x_m + 0.14 * np.cos(turn), ahead.odometry.y_m + 0.14 * np.sin(turn), turn)
        ahead = replace(ahead, timestamp_s=ahead.timestamp_s + 0.2, odometry=moved)
        status.append(tracker.fuse(None, ahead).status)
    assert status[30] == Status.DEGRADED
    assert status[-1] == Status.LOST


def test_wheels_that_slip(world, kind, slowmap):
    poses = world.loop(160)
    infos = world.infos(poses)
    odometry, x, y = [], 0.0, 0.0
    for n, (before, info) in enumerate(zip([infos[0], *infos], infos, strict=False)):
        gain = 1.43 if n % 40 < 10 else 1.0
        x += gain * (info.odometry.x_m - before.odometry.x_m)
        y += gain * (info.odometry.y_m - before.odometry.y_m)
        odometry.append(Pose2D(x, y, info.odometry.heading_rad))
    infos = world.infos(poses, odometry=odometry)
    out = followed(make_tracker(slowmap, kind), world.images(poses), infos)
    assert np.mean(world.errors_m(out, infos)) < 0.12
    assert np.nanmax(world.errors_m(out, infos)) < 0.6


def test_odometry_that_starts_again_somewhere(world, kind, slowmap, drive):
    evidence, infos = drive
    there = infos[70].odometry
    infos = [
        replace(
            one,
            odometry=Pose2D(
                one.odometry.x_m - there.x_m + 50, one.odometry.y_m - there.y_m - 9, one.odometry.heading_rad
            ),
        )
        if n >= 70
        else one
        for n, one in enumerate(infos)
    ]
    out = followed(make_tracker(slowmap, kind), evidence, infos)
    assert "odometry jumped" in out[70].reason
    assert np.nanmax(world.errors_m(out, infos)) < 0.5


@pytest.mark.parametrize("kept", [0.0, 0.7])
def test_odometry_that_is_missing(world, kind, slowmap, drive, kept):
    evidence, infos = drive
    rng = np.random.default_rng(0)
    infos = [one if rng.random() < kept else replace(one, odometry=None) for one in infos]
    out = followed(make_tracker(slowmap, kind), evidence, infos)
    assert np.nanmean(world.errors_m(out, infos)) < 0.1
    assert world.oks(out)[10:].mean() > 0.9


def test_odometry_without_headings(world, kind, slowmap, drive):
    evidence, infos = drive
    infos = [replace(one, odometry=replace(one.odometry, heading_rad=None)) for one in infos]
    out = followed(make_tracker(slowmap, kind), evidence, infos)
    assert np.nanmean(world.errors_m(out, infos)) < 0.08
    assert np.degrees(np.nanmedian(world.heading_errors_rad(out, infos)[20:])) < 5


def test_numbers_that_are_none(world, kind, slowmap, drive):
    evidence, infos = drive
    bad = [Pose2D(np.nan, 0.0, 0.0), Pose2D(0.0, np.inf, 0.0), Pose2D(0.0, 0.0, np.nan)]
    infos = [replace(one, odometry=bad[n % 3]) if n % 7 == 3 else one for n, one in enumerate(infos)]
    fixes = [Fix(np.nan, 0.0, 0.1), Fix(0.0, 0.0, np.inf), Fix(0.0, 0.0, 0.0), Fix(0.0, 0.0, -1.0)] * 40
    out = followed(make_tracker(slowmap, kind), evidence, infos, fixes)
    assert np.nanmean(world.errors_m(out, infos)) < 0.1
    tracker = make_tracker(slowmap, kind)
    assert tracker.fuse(evidence[0], infos[0]).status.has_pose
    hypothesis = Hypothesis(np.nan, np.inf, 1.0)
    odd = Evidence(Estimate(Status.OK, "", np.nan, np.nan, hypotheses=(hypothesis,)), np.full(40, 0.1))
    assert tracker.fuse(odd, infos[1]).status.has_pose
    assert tracker.fuse(evidence[2], replace(infos[2], timestamp_s=np.nan)) == tracker.fuse(None, infos[1])


def test_old_and_repeated_frames_change_nothing(world, kind, slowmap, drive):
    evidence, infos = drive
    plain, shuffled = make_tracker(slowmap, kind), make_tracker(slowmap, kind)
    for n, (seen, info) in enumerate(zip(evidence[:80], infos, strict=False)):
        expected = plain.fuse(seen, info)
        assert shuffled.fuse(seen, info).as_dict() == expected.as_dict()
        assert shuffled.fuse(evidence[100], info).as_dict() == expected.as_dict()
        if n > 5:
            assert shuffled.fuse(evidence[n - 5], infos[n - 5]).as_dict() == expected.as_dict()


def test_dropped_frames_and_gaps(world, kind, slowmap, drive):
    evidence, infos = drive
    rng = np.random.default_rng(1)
    kept = [n for n in range(160) if rng.random() > 0.2 and not 60 <= n < 90]
    out = followed(make_tracker(slowmap, kind), [evidence[n] for n in kept], [infos[n] for n in kept])
    assert np.nanmax(world.errors_m(out, [infos[n] for n in kept])) < 0.4


def test_a_robot_at_rest_becomes_no_surer_and_does_not_drift(world, kind, slowmap):
    poses = np.vstack([world.loop(40), np.repeat(world.loop(1, start=40), 400, axis=0)])
    infos = world.infos(poses)
    odometry = [one.odometry for one in infos[:41]] + [infos[40].odometry] * 399
    infos = world.infos(poses, odometry=odometry)
    moving = world.images(poses[:40])
    rng = np.random.default_rng(2)
    still = [world.image(pose, rng) for pose in poses[40:]]
    out = followed(make_tracker(slowmap, kind), moving + still, infos)
    assert world.oks(out)[45:].all()
    assert out[-1].radius_m > 0.5 * out[45].radius_m
    assert np.hypot(out[-1].x_m - out[45].x_m, out[-1].y_m - out[45].y_m) < 0.06


def test_wrong_images_are_not_followed(world, kind, slowmap, drive):
    evidence, infos = drive
    evidence = [evidence[(n + 80) % 160] if n % 20 in (10, 11) else one for n, one in enumerate(evidence)]
    out = followed(make_tracker(slowmap, kind), evidence, infos)
    error = world.errors_m(out, infos)
    assert np.nanmax(error) < 0.4
    assert not (world.oks(out) & (error > 0.4)).any()
    assert "contradicts" in out[50].reason or "away from where odometry leads" in out[50].reason


def test_two_places_that_look_alike_stay_in_mind_until_motion_decides(world, slowmap):
    poses = world.loop(60)
    infos = world.infos(poses)
    evidence = []
    for n, one in enumerate(world.images(poses)):
        here = one.estimate.hypotheses[0]
        # As long as both look alike, the other place is ahead as often as the true one; its copy lies 5 m away.
        there = replace(here, x_m=here.x_m + 5.0, weight=0.5)
        both = (replace(here, weight=0.5), there)[:: 1 if n % 2 else -1]
        alike = replace(one.estimate, x_m=both[0].x_m, y_m=both[0].y_m, hypotheses=both)
        evidence.append(replace(one, estimate=alike) if n < 30 else one)
    out = followed(ParticleTracker(slowmap), evidence, infos)
    for estimate in out[5:30]:
        assert estimate.status == Status.DEGRADED
        assert {round((one.x_m - infos[0].reference.x_m) / 50) for one in estimate.hypotheses}
        assert len(estimate.hypotheses) >= 2
        assert estimate.radius_m > 2
    assert "elsewhere" in out[20].reason
    assert world.oks(out)[40:].all()
    assert world.errors_m(out, infos)[40:].max() < 0.3


def test_off_the_map_there_is_no_pose(world, kind, slowmap):
    poses = world.loop(40)
    infos = world.infos(poses)
    rng = np.random.default_rng(0)
    evidence = [world.image(rng.uniform(-5, 5, 3), rng, Status.OFF_MAP) for _ in poses]
    out = followed(make_tracker(slowmap, kind), evidence, infos)
    assert not any(one.status.has_pose for one in out)
    assert out[-1].status == Status.OFF_MAP


def test_images_that_stick_to_a_path_which_the_robot_leaves_are_not_believed(world, kind, slowmap):
    poses = world.loop(60)
    along = np.diff(poses[[40, 41], :2], axis=0)[0]
    off = poses[40] + np.column_stack([np.outer(np.arange(25), [-along[1], along[0]]), np.full(25, np.pi / 2)])
    off[:, 2] = poses[40, 2] + np.pi / 2
    # What the images name lies on the mapped path, a little ahead of where the robot left it.
    named = poses[[min(40 + n // 3, 44) for n in range(25)]]
    infos = world.infos(np.vstack([poses[:41], off]))
    out = followed(make_tracker(slowmap, kind), world.images(np.vstack([poses[:41], named])), infos)
    error = world.errors_m(out, infos)
    assert not (world.oks(out) & (error > 1)).any()


def test_doubtful_images_alone_make_no_pose_ok(world, kind, slowmap):
    poses = world.loop(60)
    rng = np.random.default_rng(0)
    evidence = [world.image(pose, rng, Status.DEGRADED) for pose in poses]
    out = followed(make_tracker(slowmap, kind), evidence, world.infos(poses))
    assert {one.status for one in out} == {Status.DEGRADED}


def test_a_fix_bridges_blindness_and_an_outlier_carries_nothing_away(world, kind, slowmap, drive):
    evidence, infos = drive
    rng = np.random.default_rng(0)
    fixes = [Fix(i.reference.x_m + rng.normal(0, 0.02), i.reference.y_m + rng.normal(0, 0.02), 0.02) for i in infos]
    fixes[70] = Fix(infos[70].reference.x_m + 9, infos[70].reference.y_m, 0.02)
    out = followed(make_tracker(slowmap, kind), [None] * 160, infos, fixes)
    error = world.errors_m(out, infos)
    assert np.nanmax(error[10:]) < 0.2
    assert not world.oks(out)[70]
    assert np.degrees(np.nanmedian(world.heading_errors_rad(out, infos)[20:])) < 4
    # RTK drops out for a while, images bridge it.
    gap = [None if n < 100 or n >= 120 else one for n, one in enumerate(evidence)]
    partial = [None if 100 <= n < 120 else one for n, one in enumerate(fixes)]
    partial[70] = None
    out = followed(make_tracker(slowmap, kind), gap, infos, partial)
    assert world.oks(out)[10:].all()


def test_a_frozen_picture_is_a_fault(world, slowmap, drive):
    evidence, infos = drive
    evidence = [evidence[60] if 60 < n < 70 else one for n, one in enumerate(evidence)]
    out = followed(ParticleTracker(slowmap), evidence, infos)
    assert "stands still although the robot moved" in out[61].reason


def test_it_is_deterministic_and_can_be_reset(kind, slowmap, drive):
    evidence, infos = drive
    one, other = make_tracker(slowmap, kind, seed=3), make_tracker(slowmap, kind, seed=3)
    first = [estimate.as_dict() for estimate in followed(one, evidence, infos)]
    assert first == [estimate.as_dict() for estimate in followed(other, evidence, infos)]
    one.reset()
    assert first == [estimate.as_dict() for estimate in followed(one, evidence, infos)]


def test_frames_are_tracked_and_seen_from_many_threads(kind, slowmap, garden):
    recording = garden.another_day()
    frames = list(recording.frames())
    tracker, plain = make_tracker(slowmap, kind), make_tracker(slowmap, kind)
    assert isinstance(tracker, Tracker)
    with ThreadPoolExecutor(4) as pool:
        seen = list(pool.map(tracker.see, [frame.image for frame in frames]))
    for frame, evidence in zip(frames, seen, strict=True):
        assert tracker.fuse(evidence, frame.info).as_dict() == plain.update(frame).as_dict()
    assert tracker.name == kind
    with pytest.raises(ImageError):
        tracker.update(Frame(frames[0].info, np.zeros((5, 5), np.uint8)))


def test_a_map_of_places_has_no_metres(slowmap):
    with pytest.raises(InputError, match="numbered places"):
        KalmanTracker(replace(slowmap, unit="place"))
