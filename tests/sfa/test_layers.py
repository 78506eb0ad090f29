"""Grids of receptive fields and what they see (thesis tables 5.1 and 5.2)."""

import numpy as np
import pytest

from andante.errors import ConfigError
from andante.sfa import LANDMARK_LAYERS, PANORAMA_LAYERS, Layer, grids_of
from andante.sfa.layers import Grid


def sizes(layers, shape, **options):
    return [(grid.columns, grid.rows, grid.input_dim) for grid in grids_of(layers, shape, **options)]


def test_tables_of_the_thesis():
    assert sizes(PANORAMA_LAYERS, (60, 600)) == [(99, 9, 144), (48, 3, 180), (15, 1, 252), (1, 1, 240)]
    assert [layer.output_dim for layer in PANORAMA_LAYERS] == [12, 14, 16, 8]
    assert sizes(LANDMARK_LAYERS, (120, 120)) == [(23, 23, 100), (10, 10, 300), (4, 4, 192), (1, 1, 192)]
    assert [layer.output_dim for layer in LANDMARK_LAYERS] == [12, 12, 12, 8]


def test_a_panorama_has_a_field_at_every_stride_around_the_circle():
    assert sizes(PANORAMA_LAYERS, (60, 600), wrap=True) == [(100, 9, 144), (50, 3, 180), (16, 1, 252), (1, 1, 256)]


@pytest.mark.parametrize("wrap", [False, True])
def test_fields_hold_what_lies_below_them(wrap):
    maps = np.random.default_rng(0).integers(0, 255, (2, 3, 7, 10)).astype(np.uint8)
    grid = Grid((3, 7, 10), field=(4, 3), stride=(2, 2), wrap=wrap)
    assert (grid.rows, grid.columns) == (3, 5 if wrap else 4)
    fields = grid.fields(maps, np.float32)
    assert fields.shape == (36, 2 * grid.positions)
    assert fields.dtype == np.float32
    around = np.concatenate([maps, maps], axis=-1)
    columns = [
        around[n, :, 2 * row : 2 * row + 3, 2 * column : 2 * column + 4].ravel()
        for n in range(2)
        for row in range(grid.rows)
        for column in range(grid.columns)
    ]
    np.testing.assert_array_equal(fields, np.array(columns).T)


def test_fields_of_a_view_are_those_of_a_copy():
    maps = np.random.default_rng(1).normal(size=(5, 6, 2, 3)).transpose(3, 2, 0, 1)
    grid = Grid((2, 5, 6), field=(3, 2), stride=(1, 3), wrap=False)
    np.testing.assert_array_equal(grid.fields(maps, float), grid.fields(maps.copy(), float))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"output_dim": 0}, "output_dim=0: has to be at least 1"),
        ({"output_dim": 4, "field": (0, 2)}, r"field=\(0, 2\): has to be at least 1"),
        ({"output_dim": 4, "stride": (1, 0)}, r"stride=\(1, 0\): has to be at least 1"),
        ({"output_dim": 6, "reduced_dim": 2}, "output_dim=6: 2 reduced signals have only 5 terms"),
        ({"output_dim": 4, "noise": -1.0}, "noise=-1.0: has to be a finite variance"),
        ({"output_dim": 4, "residual": 1.0}, r"residual=1.0: has to be a share in \[0, 1\)"),
        ({"output_dim": 4, "clip": 0.0}, "clip=0.0: has to be above 0, or None"),
    ],
)
def test_layers_out_of_range(values, message):
    with pytest.raises(ConfigError, match=message):
        Layer(**values)


def test_layers_that_do_not_fit():
    with pytest.raises(ConfigError, match="at least one layer"):
        grids_of([], (10, 10))
    with pytest.raises(ConfigError, match="layer 1 has receptive fields of 12x12 on a map of 600x9"):
        grids_of(PANORAMA_LAYERS, (9, 600))
    with pytest.raises(ConfigError, match="layer 2 cannot reduce 4 signals to reduced_dim=20"):
        grids_of([Layer(4, field=(5, 5)), Layer(2)], (5, 5))
