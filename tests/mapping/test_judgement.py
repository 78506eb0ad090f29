"""Every status, and the words that go with it."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.data import Status
from andante.mapping.calibration import Calibration
from andante.mapping.judgement import judge
from andante.mapping.located import Located
from andante.mapping.locating import Sighting

BOUNDS = Calibration("sessions", 2.0, degraded_below=0.5, lost_below=0.4, off_map_below=0.3, usual_likeness=0.8)


def sighting(likeness: float, agreement: float, xy: tuple[float, float] = (1.0, 2.0)) -> Sighting:
    one = np.ones(1)
    located = Located(
        np.array([xy]), np.eye(2)[None], one, agreement * one, np.empty((1, 0, 2)), np.empty((1, 0)), spread=one
    )
    return Sighting(located, likeness * one, one, None)


@pytest.mark.parametrize(
    ("likeness", "agreement", "status", "reason"),
    [
        (0.9, 0.95, Status.OK, "likeness 0.90 where 0.80 is usual, 95% of the evidence agrees"),
        (0.6, 0.8, Status.DEGRADED, "not much more like this place than like others: likeness 0.60 where 0.80 is "
         "usual, 80% of the evidence agrees"),
        (0.9, 0.35, Status.LOST, "several places look like this: 35% of the evidence agrees, at least 40% is needed"),
        (0.2, 0.95, Status.OFF_MAP, "no mapped place looks like this: likeness 0.20 where 0.80 is usual, and places "
         "that are not in the map reach 0.30"),
        (0.2, 0.1, Status.OFF_MAP, "no mapped place looks like this"),
    ],
)  # fmt: skip
def test_statuses_and_their_reasons(likeness, agreement, status, reason):
    found, why = judge(sighting(likeness, agreement), BOUNDS)
    assert found is status
    assert why.startswith(reason)
    assert "\n" not in why


@pytest.mark.parametrize(("likeness", "agreement"), [(0.3, 1.0), (0.5, 1.0), (0.9, 0.4)])
def test_who_just_reaches_a_bound_has_passed_it(likeness, agreement):
    assert judge(sighting(likeness, agreement), BOUNDS)[0].has_pose


def test_what_is_usual_is_left_out_where_nobody_knows():
    bounds = Calibration("sessions", 2.0, 0.5, 0.4, 0.3)
    assert judge(sighting(0.9, 0.95), bounds)[1] == "likeness 0.90, 95% of the evidence agrees"


def test_a_map_that_knows_nothing_foreign_is_never_sure():
    bounds = Calibration("none", 3.0, 0.0, 0.0, 0.0)
    status, reason = judge(sighting(1.0, 1.0), bounds)
    assert status is Status.DEGRADED
    assert "has not learnt what places look like that are not in it" in reason


@pytest.mark.parametrize("place", ["likeness", "agreement", "x", "y"])
@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_numbers_that_are_none_are_lost(place, value):
    values = {"likeness": 0.9, "agreement": 0.9, "x": 0.0, "y": 0.0} | {place: value}
    status, reason = judge(sighting(values["likeness"], values["agreement"], (values["x"], values["y"])), BOUNDS)
    assert status is Status.LOST
    assert "is the map damaged?" in reason


@given(st.floats(0, 1), st.floats(0, 1), st.floats(0, 1), st.floats(0, 1))
def test_more_of_either_is_never_worse(likeness, agreement, more_likeness, more_agreement):
    rank = [Status.OFF_MAP, Status.LOST, Status.DEGRADED, Status.OK].index
    less = judge(sighting(min(likeness, more_likeness), min(agreement, more_agreement)), BOUNDS)[0]
    more = judge(sighting(max(likeness, more_likeness), max(agreement, more_agreement)), BOUNDS)[0]
    assert rank(less) <= rank(more)
