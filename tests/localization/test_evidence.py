"""What one image says."""

import numpy as np
import pytest

from andante.data import Status
from andante.errors import ImageError
from andante.localization import evidence_of
from andante.mapping import build_map


def test_it_is_what_the_map_says_with_slow_features_in_its_metric(slowmap, garden):
    for frame in garden.another_day().frames():
        evidence = evidence_of(slowmap, frame.image)
        assert evidence.estimate.as_dict() == slowmap.localize(frame.image).as_dict()
        assert evidence.estimate.hypotheses == slowmap.localize(frame.image).hypotheses
        assert evidence.slow == pytest.approx(slowmap.slow_features(frame.image) * slowmap.readout.metric)


def test_readouts_without_a_metric_leave_slow_features_as_they_are(garden, slowmap):
    config = slowmap.asked.with_values({"readout": {"kind": "polynomial", "inputs": 4}})
    polynomial = build_map(garden.two_days(), config)
    image = next(garden.another_day().frames()).image
    assert evidence_of(polynomial, image).slow == pytest.approx(polynomial.slow_features(image))


def test_a_picture_that_shows_nothing_is_lost(slowmap, garden):
    image = np.zeros_like(next(garden.another_day().frames()).image)
    evidence = evidence_of(slowmap, image)
    assert evidence.estimate.status == Status.LOST
    assert evidence.slow is None


def test_a_foreign_size_is_told(slowmap):
    with pytest.raises(ImageError):
        evidence_of(slowmap, np.zeros((5, 7), np.uint8))
