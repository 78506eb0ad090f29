"""What a contender may know: the one of odometry alone does not look at the truth when it maps."""

from dataclasses import replace

import numpy as np
import pytest

from andante.evaluation.experiments.cache import rendered
from andante.evaluation.experiments.contenders import PIXELS, THESIS_PIXELS, fit_odometry
from andante.evaluation.experiments.drives import encode, front_end_of
from andante.mapping import MapConfig


@pytest.fixture
def drives(cache, years):
    recordings = list(rendered(years, cache).values())
    front_end = front_end_of(recordings[0], MapConfig())
    return front_end, [encode(one, front_end, MapConfig()) for one in recordings]


def test_odometry_alone_is_laid_over_the_truth_by_a_rigid_motion(drives):
    """Turned truth gives the same map, turned: nothing but the last step has seen it."""
    front_end, (first, second, third) = drives
    plain = fit_odometry(front_end, [first, second], MapConfig()).locate(third)
    turn = np.array([[0.0, -1.0], [1.0, 0.0]])
    turned = [
        replace(one, session=replace(one.session, xy=one.session.xy @ turn.T + [5.0, 3.0])) for one in (first, second)
    ]
    moved = fit_odometry(front_end, turned, MapConfig()).locate(third)
    np.testing.assert_allclose(moved, plain @ turn.T + [5.0, 3.0], atol=1e-9)
    assert np.median(np.linalg.norm(plain - third.xy, axis=1)) < 1.0


@pytest.mark.parametrize(("contender", "within_m"), [(PIXELS, 1.0), (THESIS_PIXELS, 20.0)])
def test_a_network_is_learnt_from_the_drives_that_are_mapped(cache, years, contender, within_m):
    recordings = list(rendered(years, cache).values())
    front_end = front_end_of(recordings[0], contender.config)
    first, second, third = (encode(one, front_end, contender.config) for one in recordings)
    assert (first.features.dtype, first.features.shape) == (np.uint8, (70, 60, 600))
    fitted = contender.fit(front_end, [first, second], contender.config)
    assert front_end.lacks_network  # every trial learns its own
    found = fitted.locate(third)
    assert found.shape == (70, 2)
    assert np.median(np.linalg.norm(found - third.xy, axis=1)) < within_m
    assert fitted.bytes > 1000
