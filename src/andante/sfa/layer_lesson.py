"""How one layer of a hierarchical network learns: two passes over the maps below it, and one to hand its own on."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from numpy.typing import DTypeLike

from andante.data import Edges
from andante.errors import LearningError
from andante.sfa.eigen import RANK_TOLERANCE
from andante.sfa.field_moments import SignalsOf, block_length, field_moments
from andante.sfa.layers import Grid, Layer, Maps
from andante.sfa.map_store import MapStore, SpooledMaps
from andante.sfa.model import AffineModel
from andante.sfa.moments import Moments
from andante.sfa.quadratic import QuadraticModel
from andante.sfa.residual import with_residual
from andante.sfa.shared_node import AffineRows, SharedNode, Signals, expanded_rows, fields_of, maps_of
from andante.sfa.solver import solve_slow
from andante.sfa.threads import in_order

Progress = Callable[[str, int, int], None]
"""Told what is going on, how many pictures are done and of how many."""

_SINGLE_RANK_TOLERANCE = 1e-6
"""Products of float32 leave about 1e-7 of the largest variance where there is none."""
_SINGLE_TREMBLING = 1e-5
"""A field that always sees the same, such as burnt-out sky, gives outputs that differ by float32 rounding alone."""


@dataclass(frozen=True, slots=True, eq=False)
class LayerLesson:
    """What it takes to teach layer ``number`` (from 1): where it looks, how it computes, whom it tells."""

    number: int
    layer: Layer
    grid: Grid
    deviation_floor: float | None
    ridge: float
    dtype: DTypeLike
    report: Progress

    def learn(self, maps: MapStore, edges: Edges) -> QuadraticModel:
        """The node that all receptive fields share; raises ``LearningError`` that names the layer."""
        layer = self.layer
        # The slowest linear signals of the receptive fields, so that the expansion stays small.
        reduce = self._solve(
            self._moments(maps, edges, self._fields, "reduces"), layer.reduced_dim, self.grid.input_dim
        )
        ready = AffineRows.of(reduce, self.dtype)

        def terms_of(some: Maps) -> Signals:
            return _by_map(expanded_rows(ready(self._columns(some))), len(some))

        # The slowest polynomials of degree two in these.
        moments = self._moments(maps, edges, terms_of, "expands")
        return QuadraticModel(reduce, self._solve(moments, layer.output_dim, layer.reduced_dim, layer.noise))

    def outputs(self, maps: MapStore, node: QuadraticModel) -> SpooledMaps:
        """What this layer makes of all maps, for the next one."""
        ready = SharedNode.of(node, self.layer.clip, self.dtype)

        block, stage = block_length(self.grid.positions), f"layer {self.number} hands on"
        spooled = SpooledMaps((self.layer.output_dim, self.grid.rows, self.grid.columns), self.dtype)

        def outputs_from(start: int) -> Maps:
            some = maps.take(np.arange(start, min(start + block, len(maps))))
            return maps_of(self.grid, ready(self._columns(some)))

        for outputs in in_order(outputs_from, range(0, len(maps), block)):
            spooled.append(outputs)
            self.report(stage, len(spooled), len(maps))
        return spooled

    def _columns(self, maps: Maps) -> Signals:
        return fields_of(self.grid, maps, self.deviation_floor, self.dtype)

    def _fields(self, maps: Maps) -> Signals:
        return _by_map(self._columns(maps), len(maps))

    def _moments(self, maps: MapStore, edges: Edges, signals_of: SignalsOf, doing: str) -> Moments:
        stage = f"layer {self.number} {doing}"
        return field_moments(
            maps, edges, signals_of, self.grid.positions, lambda done: self.report(stage, done, len(maps))
        )

    def _solve(self, moments: Moments, outputs: int, signals: int, noise: float = 0.0) -> AffineModel:
        """The slowest features, and where asked for what they leave unsaid of the first ``signals`` signals."""
        carried_on = int(self.layer.residual * outputs)
        # Noise of a given variance, in the units in which the solver takes it: the mean variance of the signals.
        mean_variance = float(np.trace(moments.covariance)) / moments.dim
        ridge = self.ridge + (noise / mean_variance if noise else 0.0)
        double = np.dtype(self.dtype) == np.float64
        tolerance, trembling = (RANK_TOLERANCE, 0.0) if double else (_SINGLE_RANK_TOLERANCE, _SINGLE_TREMBLING)
        try:
            slow = solve_slow(moments, outputs - carried_on, ridge=ridge, rank_tolerance=tolerance, trembling=trembling)
            return with_residual(slow, moments, carried_on, signals)
        except LearningError as error:
            raise LearningError(f"layer {self.number} of the network: {error}") from error


def _by_map(signals: Signals, n: int) -> Signals:
    """(d, n * P) -> (d, n, P)."""
    return signals.reshape(len(signals), n, -1)
