"""Features in one byte a number: how far off, and nothing depends on what else is there."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from andante.errors import ArrayError
from andante.mapping import codes as codes_module
from andante.mapping.codes import LARGEST_CODE, Codes

SHAPES = hnp.array_shapes(min_dims=2, max_dims=2, max_side=12)
NUMBERS = st.floats(-1e6, 1e6, width=32, allow_subnormal=False)
ROWS = hnp.arrays(np.float32, SHAPES, elements=NUMBERS)


def units(n: int = 40, dim: int = 300, power: float = 1.0) -> np.ndarray:
    rng = np.random.default_rng(dim)
    rows = np.sign(rng.normal(size=(n, dim))) * np.abs(rng.normal(size=(n, dim))) ** power
    return (rows / np.linalg.norm(rows, axis=1, keepdims=True)).astype(np.float32)


@given(ROWS)
def test_no_number_is_further_off_than_half_a_step(rows):
    """A step of the root is 1 / 127, so v is off by at most 2 sqrt(v) half a step, plus what half a step squared is."""
    found, scale = Codes.of(rows).rows(), np.abs(rows).max(axis=1, keepdims=True).astype(np.float64)
    half = 0.5 / LARGEST_CODE
    bound = scale * (2 * np.sqrt(np.abs(rows) / np.where(scale > 0, scale, 1)) * half + half**2)
    assert (np.abs(found - rows.astype(np.float64)) <= bound * (1 + 1e-4) + 1e-30).all()


@pytest.mark.parametrize(("power", "bound"), [(1.0, 0.012), (2.0, 0.012), (3.0, 0.012)])
def test_unit_vectors_stay_where_they_were(power, bound):
    rows = units(power=power)
    off = np.linalg.norm(Codes.of(rows).rows() - rows, axis=1)
    assert off.max() < bound


def test_features_of_the_garden_are_off_by_less_than_a_tenth_of_the_step_to_the_next(slowmap, garden):
    features = np.array([slowmap.front_end.features(garden.panorama(pose)) for pose in garden.loop(60)])
    off = np.linalg.norm(Codes.of(features).rows() - features, axis=1)
    assert off.max() < 0.1 * np.median(np.linalg.norm(np.diff(features, axis=0), axis=1))


@given(ROWS)
def test_signs_zeros_and_the_largest_number_survive(rows):
    codes = Codes.of(rows)
    found = codes.rows()
    assert codes.codes.dtype == np.int8
    assert (codes.scale.dtype, found.dtype) == (np.float32, np.float32)
    assert codes.codes.min(initial=0) >= -LARGEST_CODE
    assert (found * rows >= 0).all()
    assert (found[rows == 0] == 0).all()
    largest = np.abs(rows) == np.abs(rows).max(axis=1, keepdims=True)
    np.testing.assert_array_equal(found[largest], rows[largest])


@given(ROWS)
def test_the_opposite_has_the_opposite_codes(rows):
    codes, opposite = Codes.of(rows), Codes.of(-rows)
    np.testing.assert_array_equal(opposite.codes, -codes.codes)
    np.testing.assert_array_equal(opposite.rows(), -codes.rows())


@given(ROWS)
def test_codes_of_codes_are_the_codes(rows):
    codes = Codes.of(rows)
    again = Codes.of(codes.rows())
    np.testing.assert_array_equal(again.rows(), codes.rows())


def test_rows_of_zeros_and_no_rows():
    rows = np.zeros((3, 4), np.float32)
    rows[1, 2] = -2.0
    codes = Codes.of(rows)
    np.testing.assert_array_equal(codes.rows(), rows)
    np.testing.assert_array_equal(codes.scale, [0, 2, 0])
    empty = Codes.of(np.empty((0, 4), np.float32))
    assert (len(empty), empty.dim, empty.rows().shape, list(empty.chunks())) == (0, 4, (0, 4), [])


@given(ROWS, st.data())
def test_no_row_knows_of_any_other(rows, data):
    chosen = np.array(data.draw(st.lists(st.integers(0, len(rows) - 1), min_size=1)))
    codes, alone = Codes.of(rows), Codes.of(rows[chosen])
    for part in (codes.subset(chosen), alone):
        np.testing.assert_array_equal(part.codes, alone.codes)
        np.testing.assert_array_equal(part.scale, alone.scale)
        np.testing.assert_array_equal(part.rows(), codes.rows(chosen))
    np.testing.assert_array_equal(codes.rows(chosen), codes.rows()[chosen])


@given(ROWS, st.data())
def test_parts_joined_are_the_whole(rows, data):
    cuts = sorted(data.draw(st.lists(st.integers(0, len(rows)), max_size=3)))
    whole, parts = Codes.of(rows), [Codes.of(part) for part in np.split(rows, cuts)]
    joined = Codes.joined(parts)
    assert (len(joined), joined.dim) == rows.shape
    np.testing.assert_array_equal(joined.codes, whole.codes)
    np.testing.assert_array_equal(joined.scale, whole.scale)


@pytest.mark.parametrize("size", [1, 7, 40, 512])
def test_chunks_are_all_rows_in_order(monkeypatch, size):
    monkeypatch.setattr(codes_module, "_CHUNK_ROWS", size)
    codes = Codes.of(units(40, 5))
    chunks = list(codes.chunks())
    assert [covered.start for covered, _ in chunks] == list(range(0, 40, size))
    assert max(len(rows) for _, rows in chunks) <= size
    np.testing.assert_array_equal(np.concatenate([rows for _, rows in chunks]), codes.rows())
    for covered, rows in chunks:
        np.testing.assert_array_equal(rows, codes.rows(covered))


def test_masks_and_slices_choose_rows():
    codes = Codes.of(units(10, 5))
    mask = np.arange(10) % 3 == 0
    np.testing.assert_array_equal(codes.rows(mask), codes.rows()[mask])
    np.testing.assert_array_equal(codes.subset(slice(2, 6)).rows(), codes.rows()[2:6])


def test_arrays_hold_everything():
    codes = Codes.of(units(10, 5))
    again = Codes.from_arrays(codes.to_arrays())
    np.testing.assert_array_equal(again.rows(), codes.rows())
    for missing in ("codes", "scale"):
        arrays = {name: array for name, array in codes.to_arrays().items() if name != missing}
        with pytest.raises(ArrayError, match=f"Codes lacks the stored arrays {missing}"):
            Codes.from_arrays(arrays)
