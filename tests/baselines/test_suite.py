from dataclasses import replace

import numpy as np
import pytest

from andante.baselines import fit_baselines
from andante.data import Status
from andante.protocols import Localizer


@pytest.fixture(scope="module")
def baselines(slowmap, make_drive):
    return fit_baselines(slowmap, [make_drive(2), make_drive(1)])


def test_there_are_four_localizers(baselines):
    assert [one.name for one in baselines] == ["nearest-1", "nearest-5", "pca + same readout", "ridge regression"]
    assert all(isinstance(one, Localizer) for one in baselines)


def test_they_find_the_way_round_the_ring(baselines, make_drive):
    drive = make_drive(3)
    for baseline in baselines:
        errors = []
        for info in drive.infos:
            estimate = baseline.localize(drive.load(info))
            assert estimate.status is Status.OK
            assert (estimate.hypotheses[0].x_m, estimate.hypotheses[0].y_m) == (estimate.x_m, estimate.y_m)
            assert estimate.radius_m is None
            errors.append(np.hypot(estimate.x_m - info.reference.x_m, estimate.y_m - info.reference.y_m))
        assert np.median(errors) < 1.5, baseline.name


def test_a_blank_picture_is_lost(baselines):
    for baseline in baselines:
        estimate = baseline.localize(np.zeros((12, 64), np.uint8))
        assert estimate.status is Status.LOST
        assert estimate.hypotheses == ()


def test_a_map_of_places_gets_places(slowmap, make_drive, baselines):
    encoded = slowmap.front_end.encode(make_drive(3).load(make_drive(3).infos[0]))
    for baseline in baselines:
        estimate = replace(baseline, unit="place").estimate(encoded)
        assert estimate.place == round(estimate.hypotheses[0].x_m)
        assert estimate.x_m is None
