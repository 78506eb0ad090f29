"""Headings from the last few images and the way between them."""

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.localization.motion import Step
from andante.localization.trail import Trail


def walked(steps, rotation, offset):
    """A trail along steps whose frame lies rotated and moved in the map, and the true place and heading at its end."""
    trail = Trail.empty()
    cos, sin = math.cos(rotation), math.sin(rotation)
    for step in steps:
        trail = trail.moved(step)
        x, y = trail.pose.x_m, trail.pose.y_m
        here = np.array([cos * x - sin * y, sin * x + cos * y]) + offset
        trail = trail.with_place(*here.tolist())
    return trail, here, trail.pose.heading_rad + rotation


@given(st.floats(-3.1, 3.1), st.integers(0, 20))
def test_the_heading_is_found_whatever_frame_odometry_has(rotation, seed):
    rng = np.random.default_rng(seed)
    steps = [Step(0.2, 0.0, turn) for turn in rng.normal(0, 0.1, 15)]
    trail, here, heading = walked(steps, rotation, rng.normal(0, 9, 2))
    told, deviation = trail.heading(here)
    assert math.remainder(told - heading, 2 * math.pi) == pytest.approx(0, abs=1e-6)
    assert 0 < deviation < 0.5
    assert trail.consistent(3)
    drawn = trail.headings(np.tile(here, (200, 1)), rng)
    off = np.abs(np.angle(np.exp(1j * (drawn - heading))))
    assert np.mean(off < 0.6) > 0.4


def test_places_that_contradict_the_way_tell_nothing():
    trail, here, _ = walked([Step(0.2)] * 10, 0.5, np.zeros(2))
    assert trail.heading(here + 5) is None
    elsewhere = trail.moved(Step(0.2)).with_place(40.0, 0.0)
    assert not elsewhere.consistent(3)
    assert elsewhere.heading(np.array([40.0, 0.0])) is None


def test_short_or_cut_trails_tell_nothing():
    trail, here, _ = walked([Step(0.05)] * 3, 0.5, np.zeros(2))
    assert trail.heading(here) is None
    trail, here, _ = walked([Step(0.2)] * 10, 0.5, np.zeros(2))
    assert trail.moved(Step(known=False)).heading(here) is None
    assert not Trail.empty().consistent(3)


def test_a_robot_at_rest_adds_nothing():
    trail, here, _ = walked([Step(0.2)] * 10, 0.5, np.zeros(2))
    assert trail.with_place(*(here + 0.01).tolist()) is trail


def test_images_that_slide_along_another_way_do_not_fit():
    straight, _, _ = walked([Step(0.2)] * 8, 0.5, np.zeros(2))
    assert straight.misfit_m == pytest.approx(0, abs=1e-9)
    assert straight.begun_anew().misfit_m == 0
    bent = Trail.empty()
    for n in range(8):
        bent = bent.moved(Step(0.2)).with_place(0.2 * min(n, 4), 0.0)
    assert bent.misfit_m > 0.15
    assert Trail.empty().misfit_m == 0


def test_the_misfit_is_the_smallest_over_all_turns():
    rng = np.random.default_rng(0)
    trail, way, seen = Trail.empty(), [], []
    for turn in rng.normal(0, 0.4, 6):
        trail = trail.moved(Step(0.2, 0.0, turn))
        way.append(complex(trail.pose.x_m, trail.pose.y_m))
        seen.append(way[-1] * np.exp(0.7j) + complex(*rng.normal(0, 0.1, 2)))
        trail = trail.with_place(seen[-1].real, seen[-1].imag)
    way, seen = np.array(way) - np.mean(way), np.array(seen) - np.mean(seen)
    turns = np.exp(1j * np.linspace(-np.pi, np.pi, 20_000))
    slow = np.sqrt((np.abs(seen - turns[:, None] * way) ** 2).mean(axis=1)).min()
    assert trail.misfit_m == pytest.approx(slow, abs=1e-6)
