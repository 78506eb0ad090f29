import json
import math

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.data import Estimate, FrameInfo, Hypothesis, Pose2D, Status
from andante.errors import ArrayError
from andante.evaluation import ErrorFigures, LocalizedFrame, PlaceFigures, Run, figures_of
from andante.evaluation.figures import best_guess, best_heading, errors_of, figures_of_run, heading_errors_of

finite = st.floats(0, 100, allow_nan=False)


def frame(index, error, status=Status.OK, *, radius_m=None, truth=True):
    """A frame at the origin whose best guess is ``error`` metres to the right; None for no guess at all."""
    info = FrameInfo(index, f"{index}.jpg", float(index), reference=Pose2D(0.0, 0.0) if truth else None)
    hypotheses = () if error is None else (Hypothesis(error, 0.0, 0.7), Hypothesis(99.0, 0.0, 0.3))
    pose = (error, 0.0) if status.has_pose else (None, None)
    radius_m = radius_m if status.has_pose else None
    return LocalizedFrame(info, Estimate(status, "", *pose, radius_m=radius_m, hypotheses=hypotheses), 0.002)


def test_figures_by_hand():
    figures = figures_of(np.array([0.0, 0.5, 1.0, 1.5, 4.0]))
    assert figures == ErrorFigures(
        n_errors=5, median_m=1.0, mean_m=1.4, p95_m=pytest.approx(3.5), max_m=4.0, share_over_1m=0.4, share_over_3m=0.2
    )


def test_places_by_hand():
    figures = figures_of(np.array([0.0, 1.0, 3.0, 11.0]), "place")
    assert figures.median_m is figures.max_m is figures.share_over_1m is None
    assert figures.places == PlaceFigures(
        median=2.0, mean=3.75, p95=pytest.approx(9.8), max=11.0, share_within_1=0.5, share_within_3=0.75,
        share_within_10=0.75,
    )  # fmt: skip


@pytest.mark.parametrize("unit", ["m", "place"])
def test_no_errors_are_nothing_known(unit):
    figures = figures_of(np.empty(0), unit)
    assert figures.n_errors == 0
    assert figures.median_m is None
    assert figures.places == (PlaceFigures() if unit == "place" else None)


@given(st.lists(finite, min_size=1, max_size=30))
def test_figures_are_ordered_and_shares_are_shares(errors):
    figures = figures_of(np.array(errors))
    assert figures.median_m <= figures.p95_m <= figures.max_m == max(errors)
    assert figures.mean_m <= figures.max_m * (1 + 1e-12)
    assert 0 <= figures.share_over_3m <= figures.share_over_1m <= 1


@pytest.mark.parametrize("errors", [np.array([1.0, np.nan]), np.array([np.inf]), np.zeros((2, 2))])
def test_unknown_errors_are_refused(errors):
    with pytest.raises(ArrayError, match=r"finite numbers of shape \(n,\).*drop unknown ones first"):
        figures_of(errors)


@settings(max_examples=25)
@given(st.lists(st.tuples(finite, st.sampled_from(list(Status))), min_size=1, max_size=20))
def test_saying_lost_improves_nothing(said):
    honest = Run(tuple(frame(i, error) for i, (error, _) in enumerate(said)))
    coy = Run(tuple(frame(i, error, status) for i, (error, status) in enumerate(said)))
    for key in ("n", "n_errors", "median_m", "mean_m", "p95_m", "max_m", "share_over_1m", "share_over_3m"):
        assert getattr(figures_of_run(coy, "m"), key) == getattr(figures_of_run(honest, "m"), key)


def test_answers_losses_and_pictures_without_a_guess_are_told_apart():
    run = Run((
        frame(0, 0.1, Status.OK, radius_m=0.2),
        frame(1, 0.3, Status.DEGRADED, radius_m=0.2),
        frame(2, 5.0, Status.LOST),
        frame(3, 8.0, Status.OFF_MAP),
        frame(4, None, Status.LOST),
        frame(5, 50.0, Status.OK, radius_m=0.1, truth=False),
    ), wall_s=0.6)  # fmt: skip
    figures = figures_of_run(run, "m")
    assert (figures.n, figures.n_errors, figures.unlocalized) == (5, 4, 1)
    assert figures.max_m == 8.0
    assert figures.lost_share == pytest.approx(3 / 5)
    assert figures.statuses == {"ok": 1, "degraded": 1, "lost": 2, "off_map": 1}
    assert figures.answered == figures_of(np.array([0.1, 0.3]))
    assert figures.coverage_90 == 0.5
    assert figures.ms_per_image == pytest.approx(100)
    assert figures.ms_localize == pytest.approx(2)
    assert figures.heading_median_deg is None


def test_confident_and_wrong_counts_all_frames_with_truth():
    run = Run((frame(0, 0.1), frame(1, 1.5), frame(2, 9.0, Status.DEGRADED), frame(3, 9.0, truth=False), frame(4, 1.0)))
    assert figures_of_run(run, "m").confident_wrong_share == 0.25


def heading(index, degrees, truth, status=Status.OK):
    """A frame that takes itself to look ``degrees`` counter-clockwise from x, and looks ``truth``; None for unknown."""
    radians, true = (None if one is None else math.radians(one) for one in (degrees, truth))
    info = FrameInfo(index, f"{index}.jpg", float(index), reference=Pose2D(0.0, 0.0, true))
    pose = (0.0, 0.0, radians) if status.has_pose else ()
    return LocalizedFrame(info, Estimate(status, "", *pose, hypotheses=(Hypothesis(0.0, 0.0, 1.0, radians),)), 0.0)


def test_headings_by_hand():
    run = Run((
        heading(0, 10, 8),
        heading(1, -179, 179),
        heading(2, 400, 36),
        heading(3, 90, -90, Status.LOST),
        heading(4, None, 3),
        heading(5, 3, None),
    ))  # fmt: skip
    figures = figures_of_run(run, "m")
    assert figures.heading_median_deg == pytest.approx(3.0)
    assert figures.heading_mean_deg == pytest.approx((2 + 2 + 4 + 180) / 4)
    assert figures.heading_p95_deg == pytest.approx(np.quantile([2, 2, 4, 180], 0.95))
    assert figures.heading_max_deg == pytest.approx(180)


@given(st.floats(-720, 720), st.floats(-720, 720))
def test_headings_are_never_more_than_half_a_turn_off(said, true):
    (off,) = heading_errors_of(Run((heading(0, said, true),)))
    assert 0 <= off <= 180 + 1e-9
    assert math.cos(math.radians(off)) == pytest.approx(math.cos(math.radians(said - true)), abs=1e-6)


def test_a_pose_counts_before_the_hypothesis_that_it_was_made_from():
    smoothed = Estimate(Status.OK, "", 1.0, 2.0, 0.5, hypotheses=(Hypothesis(8.0, 8.0, 1.0, 2.0),))
    assert best_guess(smoothed, "m") == (1.0, 2.0)
    assert best_heading(smoothed) == 0.5


def test_without_radius_there_is_no_coverage():
    assert figures_of_run(Run((frame(0, 0.1),)), "m").coverage_90 is None


@pytest.mark.parametrize("run", [Run(()), Run((frame(0, None, Status.LOST),)), Run((frame(0, 1.0, truth=False),))])
@pytest.mark.parametrize("unit", ["m", "place"])
def test_what_is_unknown_is_null_in_json(run, unit):
    values = figures_of_run(run, unit).as_dict()
    assert json.loads(json.dumps(values, allow_nan=False)) == values
    assert values["median_m"] is None


def test_places_are_whole_numbers():
    estimate = Estimate(Status.LOST, "", hypotheses=(Hypothesis(6.6, 0.3, 1.0),))
    assert best_guess(estimate, "place") == (7.0, 0.0)
    assert best_guess(estimate, "m") == (6.6, 0.3)
    run = Run((LocalizedFrame(FrameInfo(0, "a", 0.0, place=4), estimate, 0.0),))
    assert errors_of(run, "place").tolist() == [3.0]
    assert math.isnan(best_guess(Estimate(Status.LOST, ""), "m")[0])
