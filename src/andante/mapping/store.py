"""Feature vectors of a whole recording session, spilt to disk before they fill the memory."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from types import TracebackType
from typing import Self

import numpy as np
from numpy.typing import NDArray

from andante.data import IndexArray

_IN_MEMORY_BYTES = 16 * 2**20
_CHUNK_ROWS = 512


class FeatureStore:
    """Rows of float32 features in the order they came; at most 16 MB of them stay in memory.

    A map of 1,000 frames never touches the disk, one of 10,000 uses a temporary file that vanishes with the
    store. Use it as a context manager.
    """

    def __init__(self, dim: int) -> None:
        self.dim = dim
        self.rows = 0
        self._file = tempfile.SpooledTemporaryFile(max_size=_IN_MEMORY_BYTES)  # noqa: SIM115 (closed in __exit__)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._file.close()

    def extend(self, rows: NDArray[np.float32]) -> None:
        """Add vectors (m, dim)."""
        self._file.seek(0, 2)
        self._file.write(np.ascontiguousarray(rows, dtype=np.float32).tobytes())
        self.rows += len(rows)

    def chunks(self) -> Iterator[tuple[slice, NDArray[np.float32]]]:
        """All rows in pieces: (rows covered, array (m, dim))."""
        for start in range(0, self.rows, _CHUNK_ROWS):
            stop = min(start + _CHUNK_ROWS, self.rows)
            yield slice(start, stop), self._read(start, stop)

    def take(self, indices: IndexArray) -> NDArray[np.float32]:
        """Chosen rows (len(indices), dim)."""
        out = np.empty((len(indices), self.dim), dtype=np.float32)
        for row, index in zip(out, indices, strict=True):
            row[:] = self._read(int(index), int(index) + 1)[0]
        return out

    def _read(self, start: int, stop: int) -> NDArray[np.float32]:
        self._file.seek(start * self.dim * 4)
        data = self._file.read((stop - start) * self.dim * 4)
        return np.frombuffer(data, dtype=np.float32).reshape(stop - start, self.dim)
