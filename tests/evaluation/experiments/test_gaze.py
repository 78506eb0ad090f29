import numpy as np
import pytest

from andante.evaluation.experiments.gaze import BY_LANDMARKS, HIDDEN, MOVED, WHOLE, hidden_pictures, run_gaze
from andante.evaluation.experiments.gaze_following import CHAIN, CONSTANT, SWEEP, TrueSight, following_errors
from andante.evaluation.experiments.trials import Bench
from andante.mapping.gaze import build_gaze_map
from andante.mapping.gaze_config import GazeConfig
from andante.mapping.gaze_lesson import read_drive
from andante.sequences.gaze import region_azimuths
from andante.simulator import SimulatedRecording

SEED = 5


@pytest.fixture(scope="module")
def followed(pictures, years):
    """A drive, what is true of it, and errors of following it."""
    name = years.sessions[0].name
    recording, config = Bench(years, pictures).recording(name), GazeConfig(regions=24)
    gaze = build_gaze_map([recording], config)
    drive = read_drive(recording, gaze.front_end, gaze.readout.encoder, config)
    sight = TrueSight(SimulatedRecording(years, name), drive.poses)
    return drive, sight, following_errors(drive, gaze.readout.encoder, sight)


def test_where_things_stand_is_seen_again_from_there(followed):
    drive, sight, _ = followed
    azimuth = region_azimuths(24)
    distance = sight.distances(3, azimuth)
    solid = np.isfinite(distance)
    assert solid.mean() > 0.5
    towards = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    points = drive.poses[3, :2] + distance[:, None] * towards
    assert sight.visible(3, points[solid]).mean() > 0.8
    assert sight.visible(3, points[solid] + 8 * towards[solid]).mean() < 0.3


def test_known_distances_follow_better_than_none(followed):
    _, _, errors = followed
    assert set(errors) == {SWEEP, CHAIN, CONSTANT}
    assert {name: len(ways[1.0]) for name, ways in errors.items()}[SWEEP] > 20
    assert np.median(errors[SWEEP][1.0]) < np.median(errors[CONSTANT][1.0])


def test_what_hides_depends_on_the_seed_alone(pictures, years):
    recording = Bench(years, pictures).recording(years.sessions[0].name)
    share, covers = HIDDEN["50 % hidden"]
    once, twice = (hidden_pictures(recording, share, covers, other=recording, seed=1) for _ in range(2))
    np.testing.assert_array_equal([one.picture for one in once], [one.picture for one in twice])
    assert [one.start_rad for one in once] == [one.start_rad for one in twice]
    whole = hidden_pictures(recording, 0.0, covers, other=recording, seed=1)
    np.testing.assert_array_equal(whole[4].picture, recording.load(recording.infos[4]))


def test_the_experiment_tells_all_localizers_under_everything_that_hides(cache, years, tiny):
    scale = tiny.model_copy(update={"permutations": 1})
    two = years.model_copy(update={"sessions": years.sessions[:2]})
    outcome = run_gaze(Bench(two, cache), SEED, scale)
    by_sessions = outcome.figures["by_sessions"]
    assert set(by_sessions) == {"1"}
    for by_case in by_sessions.values():
        assert set(by_case) == {*HIDDEN, MOVED}
        for by_name in by_case.values():
            assert {"1 patch", "3 patches", "24 patches, principal components", "24 patches, perfect tracker"} <= set(
                by_name
            )
            assert {WHOLE, BY_LANDMARKS} <= set(by_name)
            assert all(one["n"] == 70 for one in by_name.values())
    assert len(outcome.tables) == len(HIDDEN) + 2
    again = run_gaze(Bench(two, cache), SEED, scale)
    assert again.figures == outcome.figures
