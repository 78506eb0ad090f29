import json

import numpy as np
import pytest

from andante.data import Estimate, FrameInfo, Hypothesis, Pose2D, Status
from andante.evaluation import LocalizedFrame, Run
from andante.evaluation.experiments.told import TOLD_COLUMNS, Told
from andante.evaluation.experiments.track_plots import binned_coverage
from andante.evaluation.figures import figures_of_run


@pytest.fixture
def said():
    """Estimates of twenty frames with all statuses, one without any hypothesis, and their infos."""
    rng = np.random.default_rng(2)
    estimates, infos = [], []
    for k in range(20):
        status = list(Status)[k % 4]
        x, y, heading = rng.normal(0, 1, 3).tolist()
        pose = (x, y, heading) if status.has_pose else ()
        radius = {"radius_m": 1.0} if status.has_pose else {}
        hypotheses = () if k == 3 else (Hypothesis(x, y, 1.0, heading),)
        estimates.append(Estimate(status, "", *pose, **radius, hypotheses=hypotheses))
        infos.append(FrameInfo(k, "", float(k), reference=Pose2D(0.0, 0.0, 0.1)))
    return estimates, infos


def test_its_figures_are_those_of_a_run(said):
    told = Told.of(*said).figures()
    run = figures_of_run(Run(tuple(LocalizedFrame(i, e, 0.0) for e, i in zip(*said, strict=True))), "m")
    for key in ("n", "mean_m", "median_m", "p95_m", "max_m", "share_over_1m", "coverage_90", "confident_wrong_share"):
        assert told[key] == pytest.approx(getattr(run, key)), key
    assert told["heading_median_deg"] == pytest.approx(run.heading_median_deg)
    assert told["heading_p95_deg"] == pytest.approx(run.heading_p95_deg)
    assert told["answered_share"] == pytest.approx(1 - run.lost_share)


def test_it_survives_json(said):
    told = Told.of(*said)
    again = Told.from_dict(json.loads(json.dumps(told.as_dict(), allow_nan=False)))
    np.testing.assert_allclose(again.xy, told.xy, atol=1e-4)
    np.testing.assert_allclose(again.errors, told.errors, atol=2e-4)
    assert again.status.tolist() == told.status.tolist()
    assert np.isnan(again.xy[3]).all()


def test_joined_and_cells(said):
    told = Told.of(*said)
    twice = Told.joined([told, told])
    assert twice.figures()["n"] == 40
    for key in ("mean_m", "max_m", "coverage_90", "answered_share"):
        assert twice.figures()[key] == pytest.approx(told.figures()[key])
    assert len(told.cells()) == len(TOLD_COLUMNS)


def test_settled_and_surely_wrong_exclude_each_other(said):
    told = Told.of(*said)
    ok = told.status == "ok"
    assert (told.settled | told.confident_and_wrong).tolist() == (ok & np.isfinite(told.errors)).tolist()
    assert not (told.settled & told.confident_and_wrong).any()


def test_coverage_in_bins(said):
    told = Told.of(*said)
    radii, shares = binned_coverage(told)
    assert len(radii) == len(shares) <= 8
    assert ((shares >= 0) & (shares <= 1)).all()
    nothing = Told.of([Estimate(Status.LOST, "")], said[1][:1])
    assert len(binned_coverage(nothing)[0]) == 0
    assert nothing.figures()["mean_m"] is None
