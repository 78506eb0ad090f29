import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.angles import wrapped
from andante.camera import PanoramaGeometry
from andante.errors import ConfigError
from andante.landmarks.boxes import Box
from andante.landmarks.heatmaps import Grid, decoded, targets

GRID = Grid(PanoramaGeometry(160, 48, -5.0, 55.0), 8)

angles = st.floats(-math.pi, math.pi, exclude_min=True)
seen_boxes = st.builds(
    Box, angles, st.floats(math.radians(-4), math.radians(54)), st.floats(0.05, 2), st.floats(0.05, 1)
)


@given(seen_boxes)
def test_boxes_survive_cells(box):
    back = GRID.box_of(GRID.cells_of([box])[0])
    assert abs(wrapped(back.azimuth_rad - box.azimuth_rad)) < 1e-9
    assert (back.elevation_rad, back.width_rad, back.height_rad) == pytest.approx(
        (box.elevation_rad, box.width_rad, box.height_rad)
    )


def test_the_middle_of_a_cell_is_the_middle_of_its_pixels():
    azimuths, elevations = GRID.geometry.azimuths_rad(), GRID.geometry.elevations_rad()
    box = Box(azimuths[24:32].mean(), elevations[16:24].mean(), 2 * math.pi / 20, math.radians(10))
    assert GRID.cells_of([box])[0] == pytest.approx([3, 2, 1, 1])


@given(seen_boxes)
def test_what_is_asked_of_the_network_decodes_to_the_box(box):
    cells = GRID.cells_of([box])
    wanted = targets(cells[None], GRID)
    heat, found = decoded(wanted.heat[0], wanted.shape[0])
    assert heat[0] == 1.0
    assert GRID.box_of(found[0]).iou(box) > 0.999


def test_the_heat_is_a_gaussian_around_the_nearest_cell():
    cells = np.array([[[0.3, 2.4, 12.0, 8.0]]])
    wanted = targets(cells, GRID)
    for row in range(GRID.rows):
        for column in range(GRID.columns):
            across = min(column, 20 - column)  # around the horizon, from column 0
            heat = math.exp(-0.5 * (across / (0.54 * 12 / 6)) ** 2 - 0.5 * ((row - 2) / (0.54 * 8 / 6)) ** 2)
            assert wanted.heat[0, 0, row, column] == pytest.approx(heat, abs=1e-6)
            assert wanted.weight[0, 0, row, column] == pytest.approx(heat if heat >= 0.15 else 0, abs=1e-6)
            if heat >= 0.15:
                right = 0.3 - (column if column < 10 else column - 20)
                told = [right, 2.4 - row, math.log(12), math.log(8)]
                assert wanted.shape[0, 0, :, row, column] == pytest.approx(told, abs=1e-5)


def test_a_landmark_that_is_not_there_asks_for_cold():
    wanted = targets(np.full((2, 3, 4), np.nan), GRID)
    assert all((part == 0).all() for part in (wanted.heat, wanted.shape, wanted.weight))
    assert np.isnan(GRID.cells_of([None])).all()


@given(seen_boxes, st.integers(0, 19))
def test_targets_turn_with_the_robot(box, turn):
    cells = GRID.cells_of([box])[None]
    turned = cells + np.array([turn, 0, 0, 0])
    turned[..., 0] %= 20
    first, second = targets(cells, GRID), targets(turned, GRID)
    if abs(cells[0, 0, 0] % 1 - 0.5) > 1e-6:  # between two cells rounding may choose either
        assert np.allclose(np.roll(first.heat, turn, axis=-1), second.heat, atol=1e-5)
        assert np.allclose(np.roll(first.shape, turn, axis=-1), second.shape, atol=1e-5)


def test_a_panorama_must_be_filled_by_whole_cells():
    with pytest.raises(ConfigError, match="multiples of 8 px, got 100 x 48"):
        Grid(PanoramaGeometry(100, 48), 8)
