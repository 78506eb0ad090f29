from collections import Counter

import numpy as np
import pytest

from andante.data import Estimate, Status, Trajectory
from andante.evaluation.experiments.rides import Ride
from andante.evaluation.experiments.scenarios import (
    BLIND_S,
    CARRIED_S,
    DOCKED_S,
    SCENARIOS,
    Lap,
    blind,
    carried_in_the_dark,
    dazzled,
    docked,
    kidnapped,
    odometry_jumps,
    odometry_reset,
    unknown_start,
    unreliable_frames,
    wheel_slip,
)
from andante.localization import Evidence

DARK = Evidence(Estimate(Status.LOST, "dark"))
OTHER = Evidence(Estimate(Status.OK, "another day"))
BURNT = Evidence(Estimate(Status.LOST, "burnt"))


@pytest.fixture
def seen(lap):
    other = Ride(lap.infos, (OTHER,) * len(lap))
    return Lap(lap, (BURNT,) * len(lap), DARK, other)


def rng(seed=0):
    return np.random.default_rng(seed)


def way(ride, source):
    """Lengths of all steps in metres."""
    return np.linalg.norm(np.diff(Trajectory.of(ride.infos, source).xy_m, axis=0), axis=1)


def turns(ride, source):
    return np.angle(np.exp(1j * np.diff(Trajectory.of(ride.infos, source).heading_rad)))


@pytest.mark.parametrize("name", SCENARIOS)
def test_a_seed_decides_and_the_lap_stays_as_it_is(name, seen):
    before = seen.clear.infos, seen.clear.evidence
    first, second, other = (SCENARIOS[name](rng(seed), seen) for seed in (3, 3, 4))
    assert first.ride.infos == second.ride.infos
    assert first.ride.evidence == second.ride.evidence
    assert first.ride.infos != other.ride.infos
    assert (seen.clear.infos, seen.clear.evidence) == before
    assert 0 <= first.since < len(first.ride)


@pytest.mark.parametrize("name", [name for name in SCENARIOS if name != "frames dropped, late, twice"])
def test_time_goes_on(name, seen):
    times = [info.timestamp_s for info in SCENARIOS[name](rng(), seen).ride.infos]
    np.testing.assert_allclose(np.diff(times), 0.2)


@pytest.mark.parametrize("name", ["wheel slip 30 %", "odometry reset", "odometry jumps"])
def test_what_odometry_does_changes_no_evidence(name, seen):
    ride = SCENARIOS[name](rng(), seen).ride
    plain = unknown_start(rng(), seen).ride
    count = min(len(ride), len(plain))
    assert ride.evidence[:count] == plain.evidence[:count]
    assert [info.reference for info in ride.infos[:count]] == [info.reference for info in plain.infos[:count]]


def test_a_start_can_be_anywhere(seen):
    starts = {unknown_start(rng(seed), seen).ride.infos[0].reference for seed in range(60)}
    assert len(starts) > 20


def test_kidnapped_moves_the_robot_and_not_its_odometry(seen):
    staged = kidnapped(rng(), seen)
    jump = way(staged.ride, "reference")
    assert jump[staged.since - 1] > 1.0
    assert np.delete(jump, staged.since - 1).max() < 0.7
    assert way(staged.ride, "odometry").max() < 0.7
    assert all(evidence is not DARK for evidence in staged.ride.evidence)


def test_kidnapped_maybe_to_another_day(seen):
    days = [OTHER in kidnapped(rng(seed), seen).ride.evidence for seed in range(20)]
    assert 5 < sum(days) < 15


def test_carried_in_the_dark(seen):
    staged = carried_in_the_dark(rng(), seen)
    dark = np.array([evidence is DARK for evidence in staged.ride.evidence])
    assert dark.sum() == CARRIED_S / 0.2
    assert dark[staged.since - 1]
    assert not dark[staged.since]
    carried = int(way(staged.ride, "reference").argmax())
    assert dark[carried]
    assert dark[carried + 1]


@pytest.mark.parametrize(("scenario", "veil"), [(blind, DARK), (dazzled, BURNT)])
def test_thirty_seconds_without_sight(scenario, veil, seen):
    staged = scenario(rng(), seen)
    veiled = np.array([evidence is veil for evidence in staged.ride.evidence])
    assert veiled.sum() == BLIND_S / 0.2
    assert np.flatnonzero(veiled)[-1] == staged.since - 1
    np.testing.assert_allclose(way(staged.ride, "odometry"), way(staged.ride, "reference"), atol=1e-9)


def test_wheels_slip_by_at_most_thirty_per_cent_and_turn_as_they_do(seen):
    staged = wheel_slip(rng(), seen)
    ratio = way(staged.ride, "odometry") / way(staged.ride, "reference")
    np.testing.assert_allclose(ratio[: staged.since - 1], 1)
    assert (np.abs(ratio - 1) <= 0.3 + 1e-9).all()
    assert np.abs(ratio - 1).max() > 0.1
    np.testing.assert_allclose(turns(staged.ride, "odometry"), turns(staged.ride, "reference"), atol=1e-9)


def test_a_reset_begins_at_zero_again(seen):
    staged = odometry_reset(rng(), seen)
    pose = staged.ride.infos[staged.since].odometry
    assert (pose.x_m, pose.y_m, pose.heading_rad) == (0, 0, 0)
    others = np.delete(way(staged.ride, "odometry"), staged.since - 1)
    np.testing.assert_allclose(others, others[0], atol=1e-9)


def test_odometry_jumps_five_times(seen):
    ride = odometry_jumps(rng(), seen).ride
    off = np.abs(way(ride, "odometry") - way(ride, "reference")) > 1e-6
    assert off.sum() == 5


def test_frames_get_lost_come_late_and_twice(seen):
    ride = unreliable_frames(rng(), seen).ride
    indices = [info.index for info in ride.infos]
    counts = Counter(indices)
    everything = 80 + 2 * 150
    assert 0.05 < 1 - len(counts) / everything < 0.15
    assert max(counts.values()) == 2
    late = (np.diff(indices) < 0).mean()
    assert 0.02 < late < 0.09
    # A frame is what it was, however late it comes.
    stamps = {info.index: info.timestamp_s for info in ride.infos}
    assert all(stamps[info.index] == info.timestamp_s for info in ride.infos)


def test_docked_stands_for_a_minute(seen):
    ride = docked(rng(), seen).ride
    still = way(ride, "odometry") == 0
    assert still.sum() == DOCKED_S / 0.2
    np.testing.assert_array_equal(still, way(ride, "reference") == 0)
