from dataclasses import replace

import numpy as np
import pytest

from andante.data import Estimate, Hypothesis, Status
from andante.errors import ConfigError
from andante.evaluation.experiments.scenarios import Staged
from andante.evaluation.experiments.stress import Ran, ran, spoiled, summary, with_moved_objects
from andante.simulator.movables import MOVABLE_KINDS


def said(error_m, status=Status.OK):
    """A follower that is always so much off."""

    def follow(slowmap, ride, seed):
        places = [(info.reference.x_m + error_m, info.reference.y_m) for info in ride.infos]
        return [Estimate(status, "", *xy, hypotheses=(Hypothesis(*xy, 1.0),)) for xy in places]

    return follow


def test_a_run_by_hand(lap):
    assert ran(said(0.5), None, Staged(lap, 30), 0) == Ran(frames=40, ok=40, wrong=0, waited=0, left=10)
    assert ran(said(1.5), None, Staged(lap, 30), 0) == Ran(frames=40, ok=40, wrong=40, waited=None, left=10)
    assert ran(said(1.5, Status.DEGRADED), None, Staged(lap, 0), 0) == Ran(40, 0, 0, None, 40)


def test_what_is_raised_is_written_down(lap):
    def follow(slowmap, ride, seed):
        raise ZeroDivisionError("by nothing")

    assert ran(follow, None, Staged(lap, 30), 0).raised == "ZeroDivisionError: by nothing"


def test_a_summary_by_hand():
    runs = [Ran(100, 90, 1, 4, 50), Ran(100, 50, 0, None, 30), Ran(200, 0, 0, 8, 60, "ValueError: no")]
    assert summary(runs) == {
        "runs": 3,
        "recovery_median_frames": 8.0,
        "recovery_p95_frames": pytest.approx(27.8),
        "recovery_worst_frames": 30,
        "never_recovered": 1,
        "confident_wrong_share": 1 / 400,
        "ok_share": 140 / 400,
        "raised": 1,
        "errors": ["ValueError: no"],
    }


def test_a_spoiled_map_has_some_references_elsewhere(garden_map):
    worse = spoiled(garden_map, np.random.default_rng(0), share=0.2)
    before, after = garden_map.readout.xy, worse.readout.xy
    moved = (before != after).any(axis=1)
    assert 0.1 < moved.mean() <= 0.2
    assert {tuple(xy) for xy in after.tolist()} <= {tuple(xy) for xy in before.tolist()}


def test_a_map_without_references_cannot_be_spoiled(garden_map):
    formula = replace(garden_map, readout=object())
    with pytest.raises(ConfigError, match="use the default readout"):
        spoiled(formula, np.random.default_rng(0))


def test_objects_are_moved_in_one_session_and_nothing_else_changes(years):
    (moved,) = with_moved_objects(years, years.sessions[1].name).sessions
    same = years.sessions[1]
    assert moved.objects == MOVABLE_KINDS
    assert (moved.seed, moved.drive, moved.conditions) == (same.seed, same.drive, same.conditions)
    assert moved.objects_seed not in {session.seed for session in years.sessions}
