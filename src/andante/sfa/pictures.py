"""Pictures to learn from, however they come: arrays, streams of batches, several recordings, turned copies.

>>> store, lengths = stored_pictures(lambda: iter([np.zeros((2, 4, 6)), np.ones((3, 4, 6))]), np.float32)
>>> len(store), store.shape, lengths
(5, (1, 4, 6), [5])
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from andante.data import Edges, IndexArray
from andante.errors import ArrayError, ConfigError
from andante.sfa.layers import Maps
from andante.sfa.map_store import ArrayMaps, MapStore, SpooledMaps

Episode = NDArray[Any] | Callable[[], Iterable[NDArray[Any]]]
"""Pictures of one recording in order: (n, height, width), or a function that opens a stream of such batches."""
Pictures = Episode | Sequence[Episode]
"""One recording or several, between which nothing is continuous."""

_GOLDEN = 0.6180339887498949
"""Share of a turn between pictures that spreads any number of them most evenly."""


def stored_pictures(pictures: Pictures, dtype: DTypeLike) -> tuple[MapStore, list[int]]:
    """All pictures with random access, and how many each recording has; raises ``ArrayError``.

    One array stays where it is. Streams go once through a temporary file, uint8 as they are and others in ``dtype``.
    """
    if not (isinstance(pictures, np.ndarray | Sequence) or callable(pictures)):
        raise ArrayError(
            f"pictures come as an array, as a function that opens a stream of batches, or as a list of these; got "
            f"{type(pictures).__name__}: hand in a function, such as lambda: stream"
        )
    episodes = [pictures] if isinstance(pictures, np.ndarray) or callable(pictures) else list(pictures)
    if len(episodes) == 1 and isinstance(episodes[0], np.ndarray):
        batch = _checked(episodes[0], None)
        return ArrayMaps(batch[:, None]), [len(batch)]
    spooled: SpooledMaps | None = None
    lengths = []
    for episode in episodes:
        before = len(spooled) if spooled else 0
        for batch in [episode] if isinstance(episode, np.ndarray) else episode():
            checked = _checked(batch, spooled)
            if spooled is None:
                kind = np.uint8 if checked.dtype == np.uint8 else dtype
                spooled = SpooledMaps((1, *checked.shape[1:]), kind)
            spooled.append(checked[:, None])
        lengths.append((len(spooled) if spooled else 0) - before)
    if spooled is None:
        raise ArrayError("there are no pictures to learn from: the stream of batches is empty")
    return spooled, lengths


def edges_in_time(lengths: Sequence[int]) -> Edges:
    """An edge from each picture to the next one of its recording."""
    first = np.arange(sum(lengths))
    first = np.delete(first, np.cumsum(lengths) - 1) if len(first) else first
    return Edges.between(first, first + 1)


class TurnedMaps:
    """Panoramas, each in ``turns`` headings a full circle apart: picture i turned r times is number i * turns + r.

    Turning the robot shifts its panorama, so copies cost nothing to record (thesis 9.2, after Metka). The first heading
    differs from picture to picture, so that all headings are seen.
    """

    def __init__(self, maps: MapStore, turns: int) -> None:
        if turns < 2:
            raise ConfigError(f"turns={turns}: a picture is learnt in at least 2 headings, or in 1, its own")
        self._maps, self._turns = maps, turns

    def __len__(self) -> int:
        return len(self._maps) * self._turns

    @property
    def shape(self) -> tuple[int, int, int]:
        """Channels, height and width of a map."""
        return self._maps.shape

    def take(self, rows: IndexArray) -> Maps:
        """Some turned pictures (m, channels, height, width)."""
        numbers, index = np.unique(rows // self._turns, return_inverse=True)
        upright, width = self._maps.take(numbers), self.shape[2]
        turned = np.empty((len(rows), *self.shape), dtype=upright.dtype)
        for out, row, source in zip(turned, rows, index, strict=True):
            share = (row % self._turns + (row // self._turns) * _GOLDEN % 1) / self._turns
            out[:] = np.roll(upright[source], round(share * width), axis=-1)
        return turned

    def edges(self, edges: Edges) -> Edges:
        """The edges of the upright pictures, each in one of the headings in turn, and the turns of each picture."""
        heading = np.arange(len(edges)) % self._turns
        rows = np.arange(len(self))
        after = rows - rows % self._turns + (rows + 1) % self._turns
        # Two headings are each other's next: one edge, not two.
        circle = Edges.between(rows, after) if self._turns > 2 else Edges.between(rows[::2], after[::2])
        between = Edges(edges.first * self._turns + heading, edges.second * self._turns + heading, edges.weight)
        return Edges.joined([between, circle])


def _checked(batch: NDArray[Any], spooled: SpooledMaps | None) -> NDArray[Any]:
    batch = np.asarray(batch)
    if batch.ndim != 3 or 0 in batch.shape:
        raise ArrayError(
            f"pictures come as (n, height, width) with at least one pixel, got shape {batch.shape}; one picture is "
            "image[None]"
        )
    if not (batch.dtype == np.uint8 or np.issubdtype(batch.dtype, np.floating)):
        raise ArrayError(f"pictures have to be uint8 or floating, got {batch.dtype}: convert them first")
    if spooled is not None and batch.shape[1:] != spooled.shape[1:]:
        raise ArrayError(
            f"all pictures need one size: got {batch.shape[2]}x{batch.shape[1]} after "
            f"{spooled.shape[2]}x{spooled.shape[1]}"
        )
    if spooled is not None and (batch.dtype == np.uint8) != (spooled.dtype == np.uint8):
        raise ArrayError(f"all pictures need one type: got {batch.dtype} after {spooled.dtype}")
    if batch.dtype != np.uint8 and not np.isfinite(batch.sum(dtype=np.float64)):
        raise ArrayError("pictures contain NaN or infinity: leave these out, or fill in the missing pixels")
    return batch
