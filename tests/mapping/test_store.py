"""Features go in and come out the same, on disk or not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.mapping import store as store_module
from andante.mapping.store import FeatureStore


def rows_of(sizes: list[int], dim: int) -> list[np.ndarray]:
    rng = np.random.default_rng(sum(sizes) + dim)
    return [rng.normal(size=(size, dim)).astype(np.float32) for size in sizes]


@given(st.lists(st.integers(0, 40), max_size=6), st.integers(1, 7), st.data())
def test_rows_come_out_as_they_went_in(sizes, dim, data):
    parts = rows_of(sizes, dim)
    whole = np.concatenate([np.empty((0, dim), np.float32), *parts])
    with FeatureStore(dim) as store:
        for part in parts:
            store.extend(part)
        assert store.rows == len(whole)
        chunks = list(store.chunks())
        for covered, rows in chunks:
            np.testing.assert_array_equal(rows, whole[covered])
        assert sum(len(rows) for _, rows in chunks) == len(whole)
        if len(whole):
            chosen = data.draw(st.lists(st.integers(0, len(whole) - 1), max_size=10))
            np.testing.assert_array_equal(store.take(np.array(chosen, dtype=np.int64)), whole[chosen])


def test_long_stores_go_to_the_disk_and_read_the_same(monkeypatch):
    monkeypatch.setattr(store_module, "_IN_MEMORY_BYTES", 1000)
    monkeypatch.setattr(store_module, "_CHUNK_ROWS", 16)
    parts = rows_of([10, 30, 25], 8)
    whole = np.concatenate(parts)
    with FeatureStore(8) as store:
        for part in parts:
            store.extend(part)
            assert store._file._rolled == (store.rows * 8 * 4 > 1000)
            np.testing.assert_array_equal(store.take(np.array([0, store.rows - 1])), whole[[0, store.rows - 1]])
        np.testing.assert_array_equal(np.concatenate([rows for _, rows in store.chunks()]), whole)
        assert [covered.stop - covered.start for covered, _ in store.chunks()] == [16, 16, 16, 16, 1]


def test_strided_and_double_rows_are_stored_as_they_read():
    rows = np.arange(48.0).reshape(6, 8)[::2, ::-1]
    with FeatureStore(8) as store:
        store.extend(rows)
        np.testing.assert_array_equal(store.take(np.arange(3)), rows.astype(np.float32))


def test_the_file_is_gone_with_the_store():
    with FeatureStore(3) as store:
        store.extend(np.ones((2, 3), np.float32))
    with pytest.raises(ValueError, match="closed file"):
        store.take(np.array([0]))
