"""The whole image and its landmarks: agreeing, disagreeing, and one of them silent."""

import numpy as np
import pytest

from andante.data import Estimate, Hypothesis, Status
from andante.mapping.landmark_joint import joined
from andante.mapping.uncertainty import RADIUS_OF_90_PERCENT


def estimate(x: float, sigma: float, heading: float | None = 0.0, status: Status = Status.OK) -> Estimate:
    covariance = np.diag([sigma**2, sigma**2, np.nan if heading is None else 0.01])
    radius = RADIUS_OF_90_PERCENT * sigma
    hypotheses = (Hypothesis(x, 0.0, 0.8, heading), Hypothesis(x + 5, 0.0, 0.2))
    return Estimate(status, f"at {x:g}", x, 0.0, heading, covariance, radius, likeness=0.5, hypotheses=hypotheses)


LOST = Estimate(Status.LOST, "nothing seen")
OFF_MAP = Estimate(Status.OFF_MAP, "no mapped place", likeness=0.01)


def test_both_agree_and_the_surer_one_counts_more():
    both = joined(estimate(0.0, 0.1), estimate(0.1, 0.15))
    assert both.x_m == pytest.approx(0.1 * (1 - 0.75) / (1 + 2.25 - 1.5))
    assert both.status is Status.OK
    assert both.reason == "at 0; at 0.1"


def test_what_comes_from_one_picture_is_never_surer_than_the_surer_half():
    for first, second in ((0.1, 0.1), (0.1, 0.2), (0.3, 0.05)):
        both = joined(estimate(0.0, first), estimate(0.05, second))
        assert both.radius_m == pytest.approx(RADIUS_OF_90_PERCENT * min(first, second))


def test_equals_meet_in_the_middle_and_one_twice_as_unsure_adds_nothing():
    assert joined(estimate(0.0, 0.1), estimate(0.1, 0.1)).x_m == pytest.approx(0.05)
    assert joined(estimate(0.0, 0.1), estimate(0.1, 0.2)).x_m == pytest.approx(0.0)
    assert joined(estimate(0.0, 0.3), estimate(0.1, 0.1)).x_m == pytest.approx(0.1)


def test_where_they_disagree_the_surer_one_counts_degraded():
    both = joined(estimate(0.0, 0.1), estimate(9.0, 0.3))
    assert (both.x_m, both.status) == (0.0, Status.DEGRADED)
    assert "disagree by 9 m" in both.reason
    assert any(one.x_m == 9.0 for one in both.hypotheses)
    other = joined(estimate(0.0, 0.4), estimate(9.0, 0.3))
    assert (other.x_m, other.likeness) == (9.0, 0.5)


def test_the_silent_one_changes_nothing_but_the_reason():
    whole = estimate(1.0, 0.1)
    alone = joined(whole, LOST)
    assert (alone.x_m, alone.radius_m, alone.status) == (whole.x_m, whole.radius_m, Status.OK)
    assert alone.reason == "at 1; nothing seen"
    found = joined(LOST, estimate(2.0, 0.1))
    assert (found.x_m, found.status) == (2.0, Status.OK)
    assert joined(LOST, LOST).status is Status.LOST


def test_off_the_map_only_sure_landmarks_say_otherwise():
    assert joined(OFF_MAP, estimate(2.0, 0.1, status=Status.DEGRADED)).status is Status.OFF_MAP
    found = joined(OFF_MAP, estimate(2.0, 0.1))
    assert (found.x_m, found.likeness) == (2.0, 0.01)


def test_headings_join_across_the_seam_or_stay_unknown():
    both = joined(estimate(0.0, 0.1, np.pi - 0.1), estimate(0.0, 0.1, -np.pi + 0.1))
    assert abs(both.heading_rad) == pytest.approx(np.pi)
    assert joined(estimate(0.0, 0.1, None), estimate(0.0, 0.1, 0.3)).heading_rad == pytest.approx(0.3)
    unknown = joined(estimate(0.0, 0.1, None), estimate(0.0, 0.1, None))
    assert unknown.heading_rad is None
    assert np.isnan(unknown.covariance[2, 2])


def test_weights_sum_to_one():
    for pair in ((estimate(0.0, 0.1), estimate(0.1, 0.2)), (estimate(0.0, 0.1), estimate(9.0, 0.2))):
        assert sum(one.weight for one in joined(*pair).hypotheses) == pytest.approx(1.0)
