import numpy as np
import pytest

from andante.mapping.gaze_calibration import covered, least_margin


def test_above_the_least_margin_few_are_wrong():
    rng = np.random.default_rng(0)
    margin = rng.uniform(0, 10, 300)
    wrong = rng.uniform(0, 10, 300) > margin + 3
    for share in (0.01, 0.1):
        least = least_margin(margin, wrong, share)
        assert wrong[margin >= least].mean() <= share
        below = margin[margin < least]
        assert not len(below) or wrong[margin >= below.max()].mean() > share


def test_where_nothing_is_wrong_everything_is_answered():
    margin = np.array([3.0, 0.5, 2.0])
    assert least_margin(margin, np.zeros(3, bool), 0.01) == 0.5


def test_where_the_largest_margin_is_wrong_nothing_is_answered():
    margin = np.array([3.0, 0.5, 2.0])
    assert least_margin(margin, margin == 3, 0.01) > 3


@pytest.mark.parametrize("share", [0.0, 0.25, 0.5])
def test_a_share_of_the_horizon_comes_from_elsewhere(share):
    fields = np.arange(5 * 40 * 2, dtype=np.float32).reshape(5, 40, 2)
    before = fields.copy()
    hidden = covered(fields, 3, share, np.random.default_rng(7))
    assert (hidden != fields[3]).all(axis=1).sum() == pytest.approx(share * 40, abs=1)
    np.testing.assert_array_equal(fields, before)
