"""Maps of all pictures with random access, in memory that does not grow with their number.

Learning goes over the pictures several times, and an edge may join any two of them. What does not come as an array is
written once to an unnamed temporary file, which is gone with its last user; plain reads instead of a memory map keep
the pages out of this process.
"""

from __future__ import annotations

import os
import tempfile
import weakref
from typing import Any, Protocol

import numpy as np
from numpy.typing import DTypeLike, NDArray

from andante.data import IndexArray
from andante.sfa.layers import Maps


class MapStore(Protocol):
    """n maps (channels, height, width)."""

    def __len__(self) -> int:
        """Number of maps n."""
        ...

    @property
    def shape(self) -> tuple[int, int, int]:
        """Channels, height and width of a map."""
        ...

    def take(self, rows: IndexArray) -> Maps:
        """Some maps (m, channels, height, width), in the order asked for."""
        ...


class ArrayMaps:
    """Maps that are in memory already, or in a memory map: (n, channels, height, width)."""

    def __init__(self, maps: Maps) -> None:
        self._maps = maps

    def __len__(self) -> int:
        return len(self._maps)

    @property
    def shape(self) -> tuple[int, int, int]:
        """Channels, height and width of a map."""
        channels, height, width = self._maps.shape[1:]
        return channels, height, width

    def take(self, rows: IndexArray) -> Maps:
        """Some maps in order; a view where they follow each other."""
        maps: Maps = self._maps[rows[0] : rows[-1] + 1] if _consecutive(rows) else self._maps[rows]
        return maps


class SpooledMaps:
    """Maps in a temporary file: appended in batches, read in any order."""

    def __init__(self, shape: tuple[int, int, int], dtype: DTypeLike) -> None:
        self._shape = shape
        self._dtype = np.dtype(dtype)
        self._bytes = int(np.prod(shape)) * self._dtype.itemsize
        self._file = tempfile.TemporaryFile(buffering=0)  # noqa: SIM115 (it lives as long as this object)
        weakref.finalize(self, self._file.close)
        self._count = 0

    def __len__(self) -> int:
        return self._count

    @property
    def shape(self) -> tuple[int, int, int]:
        """Channels, height and width of a map."""
        return self._shape

    @property
    def dtype(self) -> np.dtype[Any]:
        """Type of the numbers in the file."""
        return self._dtype

    def append(self, maps: Maps) -> None:
        """Write (m, channels, height, width) behind those that are there."""
        data = np.ascontiguousarray(maps, dtype=self._dtype).data.cast("B")
        position = self._count * self._bytes
        while data:
            written = os.pwrite(self._file.fileno(), data, position)
            data, position = data[written:], position + written
        self._count += len(maps)

    def take(self, rows: IndexArray) -> Maps:
        """Some maps in order."""
        maps = np.empty((len(rows), *self._shape), dtype=self._dtype)
        runs = np.flatnonzero(np.diff(rows) != 1) + 1
        for start, stop in zip([0, *runs], [*runs, len(rows)], strict=True):
            self._read(maps[start:stop], int(rows[start]))
        return maps

    def _read(self, maps: NDArray[Any], row: int) -> None:
        data, position = maps.data.cast("B"), row * self._bytes
        while data:
            count = os.preadv(self._file.fileno(), [data], position)
            if count == 0:
                raise EOFError(f"the temporary file of {self._count} maps ends before map {row}")
            data, position = data[count:], position + count


def _consecutive(rows: IndexArray) -> bool:
    return bool(len(rows) == rows[-1] - rows[0] + 1 and (np.diff(rows) == 1).all())
