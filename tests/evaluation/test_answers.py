import json

import numpy as np
import pytest

from andante.data import Estimate, FrameInfo, Hypothesis, Pose2D, Status
from andante.evaluation.alignment import Alignment
from andante.evaluation.answers import Answers


def frames(count: int, *, truth=None, heading=0.5):
    return [
        FrameInfo(at, f"{at}.png", at * 1.0, reference=Pose2D(float(at), 0.0, heading) if at != truth else None)
        for at in range(count)
    ]


def said(errors):
    """Estimates that far to the left of frame k at (k, 0); none where the error is ``None``."""
    return [
        Estimate(Status.LOST, "nothing seen")
        if error is None
        else Estimate(Status.OK, "", float(at), error, 0.5 + 0.1, hypotheses=(Hypothesis(float(at), error, 1.0, 0.6),))
        for at, error in enumerate(errors)
    ]


def test_figures_of_all_frames():
    errors = [0.1, 0.2, 0.3, 2.0, 4.0]
    figures = Answers.of(frames(5), said(errors), [(0.001, 0.002, 0.003)] * 5).figures()
    assert figures.n == 5
    assert (figures.median_m, figures.q75_m) == (pytest.approx(0.3), pytest.approx(2.0))
    assert (figures.mean_m, figures.max_m) == (pytest.approx(np.mean(errors)), pytest.approx(4.0))
    assert (figures.share_over_1m, figures.share_over_3m) == (pytest.approx(0.4), pytest.approx(0.2))
    assert (figures.lost_share, figures.unanswered_share) == (0, 0)
    assert figures.heading_median_deg == pytest.approx(np.degrees(0.1))
    assert figures.ms_per_image == pytest.approx(6)
    assert figures.as_dict()["ms_per_image"] == pytest.approx(6)


def test_calling_oneself_lost_improves_nothing():
    estimates = said([0.1, 0.2, 5.0])
    lost = [Estimate(Status.LOST, "unsure", hypotheses=one.hypotheses) for one in estimates]
    one, other = Answers.of(frames(3), estimates).figures(), Answers.of(frames(3), lost).figures()
    assert (other.median_m, other.max_m, other.heading_median_deg) == (one.median_m, one.max_m, one.heading_median_deg)
    assert (one.lost_share, other.lost_share) == (0, 1)


def test_no_answer_is_infinitely_wrong():
    figures = Answers.of(frames(5), said([0.1, None, 0.3, None, 0.2])).figures()
    assert figures.median_m == pytest.approx(0.3)
    assert (figures.q75_m, figures.p95_m) == (None, None)
    assert (figures.share_over_1m, figures.share_over_3m, figures.unanswered_share) == (0.4, 0.4, 0.4)
    assert figures.mean_m == pytest.approx(0.2)
    silent = Answers.of(frames(2), said([None, None])).figures()
    assert (silent.median_m, silent.mean_m, silent.max_m, silent.heading_median_deg) == (None, None, None, None)
    json.dumps(silent.as_dict(), allow_nan=False)


def test_frames_without_truth_do_not_count():
    assert Answers.of(frames(4, truth=2), said([0.1, 0.1, 9.0, 0.1])).figures().max_m == pytest.approx(0.1)


def test_times_that_were_not_told_apart():
    figures = Answers.of(frames(2), said([0.1, 0.1])).figures()
    assert (figures.decode_ms, figures.locate_ms, figures.ms_per_image) == (None, None, None)


def test_kept_and_read_again():
    answers = Answers.of(frames(4, heading=None), said([0.1, None, 0.3, 2.0]), [(0.1, 0.2, 0.3)] * 4)
    again = Answers.from_dict(json.loads(json.dumps(answers.as_dict(), allow_nan=False)))
    assert again.figures() == answers.figures()
    assert np.array_equal(again.xy, answers.xy, equal_nan=True)


def test_laid_over_the_truth():
    answers = Answers.of(frames(3), said([0.0, 0.0, 0.0]))
    turned = answers.laid_by(Alignment(np.pi / 2, (1.0, 2.0), 0.0, "test"))
    assert np.allclose(turned.xy, [(1, 2), (1, 3), (1, 4)])
    assert np.allclose(turned.heading_rad, answers.heading_rad + np.pi / 2)
