"""Moments of the signals in all receptive fields of all pictures, merged: weight sharing in one sum.

Every receptive field of every picture is a sample; an edge between two pictures joins each field of one with the same
field of the other, so that time never crosses positions, nor recordings. Pictures are taken in blocks of a
size that depends on the grid alone, hence no batch size a caller chooses changes a bit of the result.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from andante.data import Edges, FloatArray, IndexArray
from andante.errors import ArrayError
from andante.sfa.layers import Maps
from andante.sfa.map_store import MapStore
from andante.sfa.moments import Moments
from andante.sfa.shared_node import Signals
from andante.sfa.threads import in_order

_BLOCK_FIELDS = 7680
"""Receptive fields at a time: small enough for the caches, large enough for matrix products at full speed. From 8000
on OpenBLAS takes twice as long for a product with itself."""
_STRETCH_BLOCKS = 8
"""Blocks that one thread takes one after the other; where a stretch begins, the map before it is prepared again."""
_ORIGIN_MAPS = 8
_FAR = 4.0
"""Deviations between the mean of a signal and zero that make an offset."""

SignalsOf = Callable[[Maps], Signals]
"""Maps (n, channels, height, width) -> signals (d, n, P), a fresh array."""


@dataclass(slots=True, eq=False)
class _Sums:
    """Float64 sums over blocks whose products are taken in the blocks' own type, around ``origin`` (d, 1, 1)."""

    origin: Signals
    total: FloatArray
    gram: FloatArray
    edge_gram: FloatArray
    count: int = 0
    edge_weight: float = 0.0
    n_edges: int = 0

    @classmethod
    def around(cls, origin: Signals) -> _Sums:
        dim = len(origin)
        return cls(origin, np.zeros(dim), np.zeros((dim, dim)), np.zeros((dim, dim)))

    def add_samples(self, x: Signals) -> None:
        rows = x.reshape(len(x), -1)
        self.total += rows.sum(axis=1)
        self.gram += rows @ rows.T
        self.count += rows.shape[1]

    def add_pairs(self, x: Signals) -> None:
        """Take in maps 2 s and 2 s + 1, and an edge of weight one between the two.

        With their sum a and difference d, x x^T + x' x'^T = (a a^T + d d^T) / 2: the product of differences serves
        samples and edges, which saves a quarter of all products where edges run along time.
        """
        even, odd = x[:, ::2], x[:, 1::2]
        a, d = (even + odd).reshape(len(x), -1), (odd - even).reshape(len(x), -1)
        products = (d @ d.T).astype(np.float64)
        self.edge_gram += products
        self.gram += 0.5 * ((a @ a.T).astype(np.float64) + products)
        self.total += a.sum(axis=1)
        self.count += 2 * a.shape[1]
        self.edge_weight += a.shape[1]
        self.n_edges += a.shape[1]

    def add_differences(self, dx: Signals, weight: FloatArray) -> None:
        if (weight != 1).any():
            dx *= np.sqrt(weight)[:, None].astype(dx.dtype)
        rows = dx.reshape(len(dx), -1)
        self.edge_gram += rows @ rows.T
        positions = dx.shape[2]
        self.edge_weight += float(weight.sum()) * positions
        self.n_edges += len(weight) * positions

    def add(self, other: _Sums) -> None:
        """Take in the sums of other samples around the same origin."""
        self.total += other.total
        self.gram += other.gram
        self.edge_gram += other.edge_gram
        self.count += other.count
        self.edge_weight += other.edge_weight
        self.n_edges += other.n_edges

    def moments(self) -> Moments:
        offset = self.total / self.count
        return Moments(
            float(self.count),
            self.origin.ravel().astype(np.float64) + offset,
            self.gram - np.outer(offset, self.total),
            self.edge_weight,
            self.edge_gram,
            self.count,
            self.n_edges,
        )


def field_moments(
    store: MapStore, edges: Edges, signals_of: SignalsOf, positions: int, report: Callable[[int], None]
) -> Moments:
    """The moments of ``signals_of`` all maps at P = ``positions``, with ``edges`` between maps.

    Every edge costs about as much as a map; edges far longer than a block read and prepare their other end once
    more. ``report`` is told how many maps are done.
    """
    block = block_length(positions)
    ends = _sorted_edges(edges, len(store))
    origin = _origin_of(store, signals_of)

    def stretch(start: int) -> _Sums:
        return _stretch_sums(store, ends, signals_of, origin, range(start, start + _STRETCH_BLOCKS * block, block))

    total = _Sums.around(origin)
    starts = range(0, len(store), _STRETCH_BLOCKS * block)
    for start, sums in zip(starts, in_order(stretch, starts), strict=True):
        total.add(sums)
        report(min(start + starts.step, len(store)))
    return total.moments()


def _stretch_sums(
    store: MapStore,
    ends: tuple[IndexArray, IndexArray, FloatArray],
    signals_of: SignalsOf,
    origin: Signals,
    starts: range,
) -> _Sums:
    """The sums over some blocks one after the other, and over the edges whose higher end is in them."""
    low, high, weight = ends
    sums = _Sums.around(origin)
    previous: Signals | None = None
    for start in starts:
        rows = np.arange(start, min(start + starts.step, len(store)))
        if len(rows) == 0:
            break
        own = signals_of(store.take(rows))
        if origin.any():
            own -= origin
        here = np.arange(*np.searchsorted(high, [start, start + starts.step]))
        pairs = _pairs(low[here] - start, high[here] - start, weight[here], len(rows) // 2)
        sums.add_pairs(own[:, : 2 * len(pairs)])
        sums.add_samples(own[:, 2 * len(pairs) :])
        here = np.delete(here, pairs)
        blocks = _Blocks(store, signals_of, origin, start, own, previous)
        for chosen, far in blocks.ends(low[here]):
            near = _columns(own, high[here][chosen] - start)
            sums.add_differences(near - far, weight[here][chosen])
        previous = own
    return sums


def block_length(positions: int) -> int:
    """Maps to take at a time where each has so many receptive fields: an even number, or one."""
    return max(1, _BLOCK_FIELDS // positions // 2 * 2)


@dataclass(frozen=True, slots=True, eq=False)
class _Blocks:
    """Where the signals of the other end of an edge are: in this block, in the one before, or to be made."""

    store: MapStore
    signals_of: SignalsOf
    origin: Signals
    start: int
    own: Signals
    previous: Signals | None

    def ends(self, low: IndexArray) -> Iterator[tuple[IndexArray, Signals]]:
        """Which of the edges, and the signals (d, m, P) at their lower ends ``low``, in pieces of bounded size."""
        block, before = self.own.shape[1], 0 if self.previous is None else self.previous.shape[1]
        near = np.flatnonzero(low >= self.start)
        for chosen in _pieces(near, 2 * block):
            yield chosen, _columns(self.own, low[chosen] - self.start)
        if self.previous is not None:
            just_before = np.flatnonzero((low >= self.start - before) & (low < self.start))
            for chosen in _pieces(just_before, 2 * block):
                yield chosen, _columns(self.previous, low[chosen] - (self.start - before))
        far = np.flatnonzero(low < self.start - before)
        # Edges to the same map stand together, so that it is read once.
        far = far[np.argsort(low[far], kind="stable")]
        for chosen in _pieces(far, block):
            maps, index = np.unique(low[chosen], return_inverse=True)
            signals = self.signals_of(self.store.take(maps))
            if self.origin.any():
                signals -= self.origin
            yield chosen, _columns(signals, index)


def _origin_of(store: MapStore, signals_of: SignalsOf) -> Signals:
    """Where to put zero (d, 1, 1) so that products lose no digits to an offset: a few maps tell it well enough.

    Signals that lie around zero anyway are left as they are; differences do not feel it.
    """
    few = signals_of(store.take(np.unique(np.linspace(0, len(store) - 1, _ORIGIN_MAPS).astype(np.int64))))
    mean = few.mean(axis=(1, 2), keepdims=True)
    far = np.abs(mean) > _FAR * few.std(axis=(1, 2), keepdims=True)
    return mean if far.any() else np.zeros_like(mean)


def _sorted_edges(edges: Edges, n: int) -> tuple[IndexArray, IndexArray, FloatArray]:
    """Lower ends, higher ends and weights, ordered by the higher and then the lower end."""
    low, high = np.minimum(edges.first, edges.second), np.maximum(edges.first, edges.second)
    if len(edges) and (low.min() < 0 or high.max() >= n):
        raise ArrayError(f"edges join pictures {low.min()}..{high.max()}, but there are pictures 0..{n - 1}")
    if not (np.isfinite(edges.weight).all() and (edges.weight >= 0).all()):
        raise ArrayError(f"weights have to be {len(edges)} finite numbers >= 0, as those of edges in time are")
    order = np.lexsort((low, high))
    return low[order], high[order], edges.weight[order]


def _pairs(low: IndexArray, high: IndexArray, weight: FloatArray, count: int) -> IndexArray:
    """An edge of weight one for each of ``count`` pairs of maps 2 s and 2 s + 1, or none where one lacks it."""
    candidates = np.flatnonzero((high % 2 == 1) & (high - low == 1) & (weight == 1))
    found, first = np.unique(high[candidates], return_index=True)
    return candidates[first] if len(found) == count else candidates[:0]


def _pieces(indices: IndexArray, length: int) -> Iterator[IndexArray]:
    return (indices[i : i + length] for i in range(0, len(indices), length))


def _columns(signals: Signals, indices: IndexArray) -> Signals:
    """(d, n, P) -> (d, m, P); a view where the indices follow each other evenly, as in time."""
    step = int(indices[1] - indices[0]) if len(indices) > 1 else 1
    if step > 0 and (np.diff(indices) == step).all():
        return signals[:, indices[0] : indices[-1] + 1 : step]
    return np.take(signals, indices, axis=1)
