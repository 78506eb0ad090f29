"""An imagined view against the mapped ones."""

import numpy as np
import pytest

from andante.data import Estimate, Hypothesis, Status
from andante.mapping.off_path import ViewBounds, weighed
from andante.mapping.scenery import Spot
from andante.mapping.uncertainty import RADIUS_OF_90_PERCENT, covariance_of

BOUNDS = ViewBounds(alike_above=0.1, radius_factor=0.2, heading_factor=0.02)


def on_path() -> Estimate:
    covariance = covariance_of(np.array([[2.0, 0.5], [0.5, 1.0]]), 0.2, 0.01)
    hypotheses = (Hypothesis(1.0, 0.0, 1.0, 0.3),)
    return Estimate(Status.OK, "", 1.0, 0.0, 0.3, covariance, 0.2, likeness=0.7, hypotheses=hypotheses)


@pytest.mark.parametrize("peak", [0.8, 0.62, 0.57, 0.4])
def test_the_covariance_is_that_of_the_radius_whichever_is_believed(peak):
    """Also where a view that is elsewhere makes the mapped place less certain."""
    before = on_path()
    estimate = weighed(before, peak, Spot(3.0, 1.0, -2.0, 0.5, 0.1), BOUNDS)
    deviation = estimate.radius_m / RADIUS_OF_90_PERCENT
    assert np.trace(estimate.covariance[:2, :2]) == pytest.approx(2 * deviation**2)
    assert np.linalg.eigvalsh(estimate.covariance).min() > 0
    assert sum(one.weight for one in estimate.hypotheses) == pytest.approx(1)
    assert estimate.radius_m >= before.radius_m
    assert (estimate.x_m == 1.0) == (peak > 0.575)
