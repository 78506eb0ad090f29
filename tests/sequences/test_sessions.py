"""Several drives of one border in one frame."""

import numpy as np
import pytest

from andante.errors import ArrayError, ConfigError, RecordingError
from andante.sequences import register_session, register_sessions

N = 150


@pytest.fixture(scope="module")
def year(drives):
    """Five laps in different seasons that begin at different places: features, odometry, truth of each."""
    seen, driven, truths = [], [], []
    for number in range(5):
        rng = np.random.default_rng(40 + number)
        truth = drives.border(n=N, start=0.21 * number)
        truth[:, :2] += 0.02 * rng.standard_normal((N, 2))
        bias, scale = rng.normal(0, 0.001), 1 + rng.normal(0, 0.01)
        seen.append(drives.features(truth, season=number))
        driven.append(drives.odometry(truth, rng, bias_rad=bias, turn_rad=0.002, wheel=0.02, scale=scale))
        truths.append(truth)
    return seen, driven, truths


def between_m(sessions, truths):
    """(k,) how wrongly frames of the same true place lie relative to each other, rotated into one frame."""
    first, others = sessions[0], sessions[1:]
    found = np.concatenate([session.poses for session in sessions])
    true = np.concatenate(truths)
    a, b = found[:, :2] - found[:, :2].mean(axis=0), true[:, :2] - true[:, :2].mean(axis=0)
    angle = np.arctan2((a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]).sum(), (a * b).sum())
    matrix = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    wrong = []
    for session, truth in zip(others, truths[1:], strict=True):
        nearest = np.hypot(*(truth[:, None, :2] - truths[0][:, :2]).transpose(2, 0, 1)).argmin(axis=1)
        estimated = (session.xy_m - first.xy_m[nearest]) @ matrix.T
        wrong.append(np.hypot(*(estimated - truth[:, :2] + truths[0][nearest, :2]).T))
    return np.concatenate(wrong)


def test_frames_of_one_place_coincide(drives, year):
    seen, driven, truths = year
    sessions = register_sessions(seen, driven)
    assert np.median(between_m(sessions, truths)) < 0.08
    everything = np.concatenate([session.poses for session in sessions])
    assert drives.rigid_error_m(everything, np.concatenate(truths)).max() < 0.35
    raw = np.concatenate(driven)
    assert drives.rigid_error_m(raw, np.concatenate(truths)).mean() > 2
    for number, session in enumerate(sessions[1:], 1):
        report = session.report
        assert report.references == tuple(range(number))
        assert report.kept > 0.95 * N * number
        assert report.kept + report.rejected == N * number
        assert not report.reverse
        assert not report.misfit
        assert report.closing is not None
    assert sessions[0].report.registration is None
    np.testing.assert_allclose(sessions[0].poses[0], 0, atol=1e-9)


def test_headings_come_along(year):
    seen, driven, truths = year
    sessions = register_sessions(seen, driven)
    offset = sessions[0].heading_rad[0] - truths[0][0, 2]
    for session, truth in zip(sessions, truths, strict=True):
        error = (session.heading_rad - truth[:, 2] - offset + np.pi) % (2 * np.pi) - np.pi
        assert np.median(np.abs(error)) < 0.1


def test_bending_brings_drives_together(year):
    seen, driven, truths = year
    bent = between_m(register_sessions(seen[:2], driven[:2]), truths[:2])
    # Where correspondences are worth nothing, the drives are only laid over each other as a whole.
    stiff = between_m(register_sessions(seen[:2], driven[:2], anchor_m=50.0), truths[:2])
    assert bent.mean() < stiff.mean()


def test_a_new_drive_changes_nothing(year):
    seen, driven, _ = year
    all_at_once = register_sessions(seen, driven)
    before = register_sessions(seen[:3], driven[:3])
    for one, other in zip(before, all_at_once, strict=False):
        np.testing.assert_array_equal(one.poses, other.poses)
        assert one.report.kept == other.report.kept
    later = register_session(seen[3], driven[3], earlier=before)
    np.testing.assert_array_equal(later.poses, all_at_once[3].poses)


def test_a_drive_of_another_garden_is_refused(drives, year):
    seen, driven, _ = year
    truth = drives.border(n=N, size_m=6.3)
    foreign, astray = drives.features(truth, garden=7), drives.odometry(truth)
    with pytest.raises(RecordingError, match="drive 1: this drive does not fit"):
        register_sessions([seen[0], foreign, seen[1]], [driven[0], astray, driven[1]])
    sessions = register_sessions([seen[0], foreign, seen[1]], [driven[0], astray, driven[1]], misfits="leave_out")
    assert "does not fit" in sessions[1].report.misfit
    assert np.isnan(sessions[1].poses).all()
    assert sessions[2].report.references == (0,)
    alone = register_sessions(seen[:2], driven[:2])
    np.testing.assert_array_equal(sessions[2].poses, alone[1].poses)


def test_no_drive_of_other_gardens_is_accepted(drives, year):
    seen, driven, _ = year
    for garden in range(10, 40):
        truth = drives.border(n=N, start=0.03 * garden, size_m=6.0)
        foreign = drives.features(truth, garden=garden)
        sessions = register_sessions([seen[0], foreign], [driven[0], drives.odometry(truth)], misfits="leave_out")
        assert sessions[1].report.misfit


def test_a_part_of_a_lap_and_the_other_direction(drives, year):
    seen, driven, truths = year
    backward = truths[2][::-1] + np.array([0, 0, np.pi])
    given = [seen[0], seen[1][30:100], seen[2][::-1]], [driven[0], driven[1][30:100], drives.odometry(backward)]
    sessions = register_sessions(*given)
    assert sessions[1].report.closing is None
    assert not sessions[1].report.reverse
    assert sessions[2].report.reverse
    assert np.median(between_m(sessions, [truths[0], truths[1][30:100], backward])) < 0.08


def test_a_first_drive_of_more_than_a_lap(drives, year):
    seen, driven, truths = year
    truth = drives.border(n=345, laps=2.3)
    long = drives.odometry(truth, np.random.default_rng(5), bias_rad=0.001, wheel=0.02)
    sessions = register_sessions([drives.features(truth, season=30), seen[1]], [long, driven[1]])
    assert sessions[0].report.closing.turns == 1
    assert drives.rigid_error_m(sessions[0].poses, truth).mean() < 0.1
    assert np.median(between_m(sessions, [truth, truths[1]])) < 0.08


def test_faults(year):
    seen, driven, _ = year
    with pytest.raises(ArrayError, match="one entry per drive, at least one; got 2, 1 and 2"):
        register_sessions(seen[:2], driven[:1])
    with pytest.raises(ArrayError, match="at least one"):
        register_sessions([], [])
    with pytest.raises(ConfigError, match="misfits='drop'"):
        register_sessions(seen, driven, misfits="drop")
    with pytest.raises(ArrayError, match="features has 150 frames, odometry 99"):
        register_sessions(seen[:1], [driven[0][:99]])
    with pytest.raises(ConfigError, match="anchor_m=0"):
        register_sessions(seen, driven, anchor_m=0)
    with pytest.raises(RecordingError, match="drive 0: this drive is no closed loop"):
        register_sessions([seen[0][:70]], [driven[0][:70]], misfits="leave_out")
