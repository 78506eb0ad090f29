"""Loop closures within one drive."""

import numpy as np
import pytest

from andante.errors import ArrayError, ConfigError
from andante.sequences import close_wire_loop, find_loop_closures


@pytest.mark.parametrize("laps", [1.1, 2.3])
def test_a_drive_of_more_than_a_lap_closes_where_it_revisits(drives, laps):
    n = int(150 * laps)
    truth = drives.border(n=n, laps=laps)
    drifted = drives.odometry(truth, np.random.default_rng(3), bias_rad=0.002, wheel=0.02)
    found = find_loop_closures(drives.features(truth), drifted)
    assert len(found) >= 0.7 * (n - 150) / np.floor(laps)
    apart = np.hypot(*(truth[found.later] - truth[found.earlier])[:, :2].T)
    assert apart.max() < 0.5
    assert np.median(apart) < 0.15
    assert (found.earlier < found.later).all()
    assert ((found.confidence > 0) & (found.confidence <= 1)).all()
    closed = close_wire_loop(drifted, pairs=found.pairs)
    assert closed.turns == 1
    assert drives.rigid_error_m(drifted, truth).mean() > 0.3
    assert drives.rigid_error_m(closed.poses, truth).mean() < 0.12


def test_a_drive_that_revisits_nothing_closes_nowhere(drives):
    line = np.column_stack([np.linspace(0, 30, 150), np.zeros((150, 2))])
    assert len(find_loop_closures(drives.features(line), line)) == 0


def test_metres_travelled_are_enough_but_odometry_gates(drives):
    # Two places 20 m apart that look the same, and a lap that comes back.
    truth = drives.border(n=220, laps=1.1)
    seen = drives.features(truth, noise=0.1)
    seen[100:110] = seen[20:30]
    travelled = np.append(0, np.cumsum(np.hypot(*np.diff(truth[:, :2], axis=0).T)))
    without = find_loop_closures(seen, travelled)
    assert {(earlier, later) for earlier, later in without.pairs if later >= 200} >= {(5, 205), (10, 210)}
    assert set(range(100, 110)) & set(without.later)
    gated = find_loop_closures(seen, truth)
    assert not set(range(100, 110)) & set(gated.later)
    assert gated.pairs[:, 1].min() > 195


@pytest.mark.parametrize(
    ("change", "error", "message"),
    [
        (
            {"features": np.zeros(5)},
            ArrayError,
            r"one feature vector for each of at least 3 frames \(n, d\), got \(5,\)",
        ),
        ({"features": np.full((50, 4), np.nan)}, ArrayError, "NaN or infinity in 50 of 50 frames"),
        ({"odometry": np.zeros((4, 3))}, ArrayError, "for 50 frames, all known"),
        ({"odometry": np.full(50, np.inf)}, ArrayError, "all known"),
        ({"min_travel_m": 0}, ConfigError, "min_travel_m=0"),
        ({"ratio": 1.5}, ConfigError, "ratio=1.5"),
    ],
)
def test_faults(change, error, message):
    given = {"features": np.ones((50, 4)), "odometry": np.zeros((50, 3)), **change}
    with pytest.raises(error, match=message):
        find_loop_closures(given.pop("features"), given.pop("odometry"), **given)
