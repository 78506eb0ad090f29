"""The whole image and its landmarks: seen where they are expected, elsewhere, and one of the two silent."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from andante.data import Estimate, Hypothesis, Status
from andante.landmarks.boxes import Box
from andante.mapping.landmark_geometry import Geometry
from andante.mapping.landmark_joint import joined
from andante.mapping.landmark_sights import Sight
from andante.mapping.uncertainty import RADIUS_OF_90_PERCENT

TOP_M = 2.0
NORTH, EAST = (0.0, 6.0), (6.0, 0.0)
LOST = Estimate(Status.LOST, "nothing seen")
OFF_MAP = Estimate(Status.OFF_MAP, "no mapped place", likeness=0.01)


def estimate(
    x: float, sigma: float, heading: float | None = 0.0, status: Status = Status.OK, heading_sigma: float = 0.003
) -> Estimate:
    covariance = np.diag([sigma**2, sigma**2, np.nan if heading is None else heading_sigma**2])
    radius = RADIUS_OF_90_PERCENT * sigma
    hypotheses = (Hypothesis(x, 0.0, 0.8, heading), Hypothesis(x + 5, 0.0, 0.2))
    return Estimate(status, f"at {x:g}", x, 0.0, heading, covariance, radius, likeness=0.5, hypotheses=hypotheses)


def sight_of(thing: tuple[float, float] | None, pose=(0.0, 0.0, 0.0), off: float = 0.0) -> Sight:
    """A thing as it is seen from a pose, half a degree more or less when it was mapped; ``None`` stands nowhere."""
    x, y = thing or NORTH
    away = np.array([x - pose[0], y - pose[1]])
    top = float(np.arctan(TOP_M / np.linalg.norm(away)))
    azimuth = float(np.angle(np.exp(1j * (np.arctan2(away[1], away[0]) - pose[2] + off))))
    geometry = None if thing is None else Geometry(x, y, np.radians(0.5), np.log(TOP_M), 0.05)
    return Sight(SimpleNamespace(geometry=geometry), Box(azimuth, top / 2, 0.1, top), np.zeros(2), np.eye(2), 1.0)


def test_a_landmark_moves_the_pose_across_its_direction():
    # The robot is at the origin, the image puts it 0.4 m to the east.
    both = joined(estimate(0.4, 0.4), LOST, [sight_of(NORTH)])
    assert abs(both.x_m) < 0.1
    assert both.status is Status.OK
    assert both.reason == "at 0.4; nothing seen"
    assert both.covariance[0, 0] < 0.1 * 0.4**2
    assert both.radius_m < RADIUS_OF_90_PERCENT * 0.4
    assert both.hypotheses[0].x_m == both.x_m


def test_several_say_more():
    one = joined(estimate(0.4, 0.4), LOST, [sight_of(NORTH)])
    two = joined(estimate(0.4, 0.4), LOST, [sight_of(NORTH), sight_of(EAST)])
    assert two.radius_m < one.radius_m
    assert np.hypot(two.x_m, two.y_m) < 0.06


def test_one_at_a_wrong_place_hardly_counts():
    right = joined(estimate(0.1, 0.2), LOST, [sight_of(NORTH), sight_of(EAST)])
    both = joined(estimate(0.1, 0.2), LOST, [sight_of(NORTH), sight_of(EAST), sight_of(EAST, off=1.0)])
    assert (both.x_m, both.y_m) == pytest.approx((right.x_m, right.y_m), abs=0.03)
    assert both.status is Status.OK


def test_where_none_is_at_its_place_the_whole_image_counts_degraded():
    landmarks = estimate(9.0, 0.1)
    both = joined(estimate(0.0, 0.1), landmarks, [sight_of(NORTH, off=0.5)])
    assert (both.x_m, both.status, both.radius_m) == (0.0, Status.DEGRADED, estimate(0.0, 0.1).radius_m)
    assert both.reason == "at 0; no landmark is where that expects it"
    assert any(one.x_m == 9.0 for one in both.hypotheses)


def test_what_looks_like_nothing_mapped_casts_no_doubt_from_elsewhere():
    strange = replace(sight_of(NORTH, off=0.5), likeness=0.2)
    both = joined(estimate(0.0, 0.1), LOST, [strange])
    assert (both.x_m, both.status, both.reason) == (0.0, Status.OK, "at 0; nothing seen")
    assert joined(estimate(0.0, 0.1), LOST, [strange, sight_of(EAST, off=0.5)]).status is Status.DEGRADED
    # Where it is expected, its direction counts.
    assert joined(estimate(0.4, 0.4), LOST, [replace(sight_of(NORTH), likeness=0.2)]).x_m < 0.1


def test_unless_it_was_not_sure_and_the_landmarks_are():
    unsure = estimate(0.0, 0.1, status=Status.DEGRADED)
    both = joined(unsure, estimate(9.0, 0.1), [sight_of(NORTH, off=0.5)])
    assert (both.x_m, both.status, both.likeness) == (9.0, Status.DEGRADED, 0.5)
    assert any(one.x_m == 0.0 for one in both.hypotheses)
    still = joined(unsure, estimate(9.0, 0.1, status=Status.DEGRADED), [sight_of(NORTH, off=0.5)])
    assert (still.x_m, still.status) == (0.0, Status.DEGRADED)


def test_landmarks_that_agree_make_an_unsure_image_sure():
    unsure = estimate(0.1, 0.2, status=Status.DEGRADED)
    assert joined(unsure, estimate(0.0, 0.2), [sight_of(NORTH)]).status is Status.OK
    assert joined(unsure, LOST, [sight_of(NORTH)]).status is Status.DEGRADED
    assert joined(unsure, estimate(4.0, 0.2), [sight_of(NORTH)]).status is Status.DEGRADED


def test_what_stands_nowhere_or_is_not_seen_changes_nothing_but_the_reason():
    whole = estimate(1.0, 0.1)
    for sights in ([], [sight_of(None)]):
        alone = joined(whole, LOST, sights)
        assert (alone.x_m, alone.radius_m, alone.status) == (whole.x_m, whole.radius_m, Status.OK)
        assert alone.reason == "at 1; nothing seen"
        assert alone.hypotheses == whole.hypotheses


def test_without_the_whole_image_landmarks_alone():
    found = joined(LOST, estimate(2.0, 0.1), [sight_of(NORTH)])
    assert (found.x_m, found.status) == (2.0, Status.OK)
    assert joined(LOST, LOST, []).status is Status.LOST


def test_off_the_map_only_sure_landmarks_say_otherwise():
    assert joined(OFF_MAP, estimate(2.0, 0.1, status=Status.DEGRADED), []).status is Status.OFF_MAP
    found = joined(OFF_MAP, estimate(2.0, 0.1), [])
    assert (found.x_m, found.likeness) == (2.0, 0.01)


@pytest.mark.parametrize("heading", [np.pi - 0.001, -np.pi + 0.001])
def test_headings_are_refined_across_the_seam(heading):
    seen = [sight_of(thing, (0.0, 0.0, np.pi)) for thing in (NORTH, EAST)]
    both = joined(estimate(0.0, 0.05, heading, heading_sigma=0.05), LOST, seen)
    assert abs(both.heading_rad) == pytest.approx(np.pi, abs=2e-3)
    assert both.covariance[2, 2] < 0.05**2


def test_landmarks_tell_the_heading_that_an_image_does_not():
    both = joined(estimate(0.0, 0.1, None), LOST, [sight_of(NORTH, (0.0, 0.0, 0.7))])
    assert both.heading_rad == pytest.approx(0.7)
    assert np.isfinite(both.covariance).all()


def test_weights_sum_to_one():
    for off in (0.0, 0.5):
        both = joined(estimate(0.0, 0.1), estimate(0.1, 0.2), [sight_of(NORTH, off=off)])
        assert sum(one.weight for one in both.hypotheses) == pytest.approx(1.0)
