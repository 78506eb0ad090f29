import numpy as np
import pytest

from andante.errors import ConfigError
from andante.simulator.border import Border

SQUARE = [(-5, -5), (5, -5), (5, 5), (-5, 5)]


def test_rounding_keeps_the_middle_of_the_sides_and_cuts_the_corners():
    border = Border.rounded(SQUARE, 0.8)
    assert border.inside_m([(0.0, -5.0)])[0] == pytest.approx(0.0, abs=0.02)
    assert border.inside_m([(-5.0, -5.0)])[0] < -0.2
    assert 36.0 < border.length_m < 40.0


def test_an_inset_line_is_inside_by_its_offset_everywhere():
    border = Border.rounded(SQUARE, 0.8)
    for offset in (0.3, 2.0, -0.5):
        distance = border.inside_m(border.inset(offset).points_m)
        np.testing.assert_allclose(distance, offset, atol=0.08)


def test_it_runs_counter_clockwise_and_points_are_equally_far_apart():
    points = Border.rounded(SQUARE, 0.8).points_m
    after = np.roll(points, -1, 0)
    assert (points[:, 0] * after[:, 1] - points[:, 1] * after[:, 0]).sum() > 0
    steps = np.linalg.norm(after - points, axis=1)
    assert steps.max() - steps.min() < 0.01


def test_an_offset_that_leaves_nothing_is_an_error():
    with pytest.raises(ConfigError, match="an offset of 20 m leaves nothing of this border; use a smaller one"):
        Border.rounded(SQUARE, 0.8).inset(20.0)
