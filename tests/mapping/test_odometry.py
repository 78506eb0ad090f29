"""Maps of drives whose only positions are odometry that drifts."""

import numpy as np
import pytest

from andante.data import Pose2D, Trajectory
from andante.errors import RecordingError
from andante.mapping import BuildLog, build_map, update_map
from andante.mapping.odometry import in_one_frame
from andante.recordings import MemoryRecording
from andante.simulator.odometry import OdometryNoise, drifting


def lap(garden, name: str, start: float, seed: int, gain: float = 1.0, n: int = 80) -> MemoryRecording:
    """Once around, begun elsewhere each time, with an odometry of its own; the truth is the reference."""
    poses = garden.loop(n, start)
    poses[:, 2] = np.arctan2(*np.roll(np.diff(np.vstack([poses, poses[:1]]), axis=0)[:, :2], 1, axis=1).T)
    truth = Trajectory(0.2 * np.arange(n), poses[:, :2], poses[:, 2])
    drive = garden.drive(poses, name=name, gain=gain)
    return MemoryRecording(
        [drive.load(info) for info in drive.infos],
        truth.timestamp_s,
        drive.camera,
        reference=[Pose2D(*pose) for pose in poses.tolist()],
        odometry=drifting(truth, OdometryNoise(), np.random.default_rng(seed)),
        name=name,
    )


@pytest.fixture(scope="module")
def laps(garden) -> list[MemoryRecording]:
    return [lap(garden, "a", 0, 1), lap(garden, "b", 30.3, 2, 0.8), lap(garden, "c", 55.6, 3, 1.1)]


@pytest.fixture(scope="module")
def without_truth(laps) -> list[MemoryRecording]:
    return [
        MemoryRecording(
            [one.load(info) for info in one.infos],
            [info.timestamp_s for info in one.infos],
            one.camera,
            odometry=[info.odometry for info in one.infos],
            name=one.name,
        )
        for one in laps
    ]


def apart_between(slowmap, laps) -> float:
    """How wrongly frames of two drives lie to each other: distances in the map against true ones, for near frames."""
    wrong = []
    for one in range(3):
        for other in range(one):
            a, b = slowmap.memory[one], slowmap.memory[other]
            true_a, true_b = (Trajectory.of(laps[k].infos, "reference").xy_m for k in (one, other))
            nearest = np.linalg.norm(true_a[:, None] - true_b[None], axis=2).argmin(axis=1)
            gap = (a.xy - b.xy[nearest]) - (true_a - true_b[nearest])
            wrong.append(
                np.linalg.norm(a.xy - b.xy[nearest], axis=1) - np.linalg.norm(true_a - true_b[nearest], axis=1)
            )
            assert gap.shape == a.xy.shape
    return float(np.median(np.abs(np.concatenate(wrong))))


def test_drives_end_up_in_one_frame(laps, without_truth):
    log = BuildLog()
    slowmap = build_map(without_truth, log=log)
    assert slowmap.config.positions == "odometry"
    assert [closing.name for closing in log.closings] == ["a", "b", "c"]
    assert log.closings[0].kept is None
    assert all(closing.kept > 60 for closing in log.closings[1:])
    assert apart_between(slowmap, laps) < 0.1


def test_headings_are_those_of_the_common_frame(laps, without_truth):
    """Which is turned against the truth by one angle, the same everywhere."""
    slowmap = build_map(without_truth)
    turns = []
    for drive in laps:
        for info in drive.infos[::5]:
            estimate = slowmap.localize(drive.load(info))
            turns.append(np.exp(1j * (estimate.heading_rad - info.reference.heading_rad)))
    frame = np.mean(turns)
    assert abs(frame) > 0.99
    off = np.degrees(np.abs(np.angle(np.array(turns) / frame)))
    assert np.median(off) < 2


def test_an_update_is_a_rebuild(without_truth, tmp_path):
    log = BuildLog()
    updated, _ = update_map(build_map(without_truth[:2]), without_truth[2], log=log)
    assert [closing.name for closing in log.closings] == ["c"]
    updated.save(tmp_path / "updated.andante")
    build_map(without_truth).save(tmp_path / "together.andante")
    assert (tmp_path / "updated.andante").read_bytes() == (tmp_path / "together.andante").read_bytes()


def test_a_drive_through_another_garden_has_no_place(without_truth, other_garden):
    foreign = lap(other_garden, "foreign", 10.2, 5)
    with pytest.raises(
        RecordingError, match="recording 'foreign' cannot be placed by its odometry: this drive does not"
    ):
        update_map(build_map(without_truth[:2]), foreign)


def test_headings_are_needed(without_truth):
    first = without_truth[0]
    blind = MemoryRecording(
        [first.load(info) for info in first.infos],
        [info.timestamp_s for info in first.infos],
        first.camera,
        odometry=[Pose2D(info.odometry.x_m, info.odometry.y_m) for info in first.infos],
        name="blind",
    )
    with pytest.raises(RecordingError, match="'blind' cannot be placed by its odometry: its headings are unknown"):
        build_map([without_truth[1], blind])
    log = BuildLog()
    assert build_map([blind], log=log).config.positions == "odometry"  # the first one needs none
    assert "blind is mapped as its odometry has it, drift and all: its headings are unknown" in log.closings[0].hint


def test_one_drive_that_does_not_close_stays_as_it_is(garden):
    half = lap(garden, "half", 0, 1)
    open_ended = MemoryRecording(
        [half.load(info) for info in half.infos[:40]],
        [info.timestamp_s for info in half.infos[:40]],
        half.camera,
        odometry=[info.odometry for info in half.infos[:40]],
        name="half",
    )
    log = BuildLog()
    slowmap = build_map([open_ended], log=log)
    assert log.closings[0].heading_error_rad is None
    assert "drift and all" in log.closings[0].hint
    np.testing.assert_array_equal(slowmap.memory[0].xy, Trajectory.of(open_ended.infos, "odometry").xy_m)


def test_an_update_is_a_rebuild_even_where_the_first_drive_is_open(garden, without_truth, tmp_path):
    whole = without_truth[0]
    part = MemoryRecording(
        [whole.load(info) for info in whole.infos[:60]],
        [info.timestamp_s for info in whole.infos[:60]],
        whole.camera,
        odometry=[info.odometry for info in whole.infos[:60]],
        name="part",
    )
    updated, _ = update_map(build_map([part]), without_truth[1])
    updated.save(tmp_path / "updated.andante")
    build_map([part, without_truth[1]]).save(tmp_path / "together.andante")
    assert (tmp_path / "updated.andante").read_bytes() == (tmp_path / "together.andante").read_bytes()


def test_earlier_drives_are_not_moved(without_truth):
    slowmap = build_map(without_truth[:2])
    (placed,), _ = in_one_frame(
        slowmap.memory, [(build_map(without_truth[2:]).memory[0], without_truth[2])], slowmap.config.drift
    )
    both = build_map(without_truth)
    np.testing.assert_array_equal(both.memory[1].xy, slowmap.memory[1].xy)
    np.testing.assert_allclose(both.memory[2].xy, placed.xy, atol=0.2)
