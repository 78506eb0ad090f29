"""The picture of landmarks: names where they stand, and what is asked for where none helps."""

from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from andante.evaluation.landmark_map import landmark_map, landmark_png
from andante.mapping.landmark_lesson import LandmarkCalibration
from andante.mapping.landmarks import LandmarkMap

CALIBRATION = LandmarkCalibration(0.2, 2.0, 2.0, 0.2, sessions=False)


def map_of(radius, names=("shed",), geometry=True):
    x = np.linspace(0, 20, len(radius))
    models = tuple(
        SimpleNamespace(name=name, geometry=SimpleNamespace(x_m=5.0 * k, y_m=4.0) if geometry else None)
        for k, name in enumerate(names)
    )
    return LandmarkMap(models, CALIBRATION, None, np.column_stack([x, 0 * x, radius]))


def texts(figure):
    return [one.get_text() for one in figure.axes[0].texts]


def test_landmarks_have_names_and_weak_places_ask():
    radius = np.where(np.arange(100) < 50, 0.1, np.inf)
    figure = landmark_map(map_of(radius, ("shed", "oak")))
    assert texts(figure) == ["shed", "oak", *["teach one here"] * 3]
    # The second half of the drive, in cells of two metres.
    assert len(figure.axes[0].patches) == pytest.approx(5, abs=1)
    assert figure.axes[0].get_legend() is not None


def test_where_all_is_well_nothing_is_asked():
    figure = landmark_map(map_of(np.full(40, 0.1)))
    assert texts(figure) == ["shed"]
    assert len(figure.axes[0].patches) == 0


@pytest.mark.parametrize("radius", [np.full(40, np.inf), np.full(40, 1e-3), np.full(1, 9.0)])
def test_all_radii_can_be_drawn_and_places_may_be_unknown(radius):
    picture = cv2.imdecode(np.frombuffer(landmark_png(map_of(radius, geometry=False)), np.uint8), cv2.IMREAD_COLOR)
    assert picture.shape[0] > 500
    assert picture.std() > 1
