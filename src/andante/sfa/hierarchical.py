"""Learning a hierarchical network of slow feature nodes from whole pictures, layer by layer (thesis 3.4 and 5.1.1).

>>> rng = np.random.default_rng(0)
>>> waves = np.sin(np.arange(300)[:, None, None] * rng.uniform(0.01, 0.5, (8, 8)) + rng.uniform(0, 6, (8, 8)))
>>> layers = [Layer(3, field=(4, 4), stride=(2, 2), reduced_dim=5), Layer(2, reduced_dim=6)]
>>> network = HierarchicalSFA(layers, deviation_floor=None).fit(waves)
>>> network.transform(waves).shape, network.transform(waves[0]).shape
((300, 2), (2,))
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from andante.data import Edges, FloatArray
from andante.errors import ArrayError, ConfigError, NotFittedError
from andante.sfa.hierarchy import HierarchicalModel
from andante.sfa.layer_lesson import LayerLesson, Progress
from andante.sfa.layers import PANORAMA_LAYERS, Layer, grids_of
from andante.sfa.map_store import MapStore
from andante.sfa.pictures import Pictures, TurnedMaps, edges_in_time, stored_pictures
from andante.sfa.quadratic import QuadraticModel


class HierarchicalSFA:
    """A network of shared quadratic nodes on whole pictures (thesis 5.1.1); the defaults are table 5.1.

    ``layers`` from the pictures upwards. ``wrap``: panoramas close around their sides, and receptive fields cross the
    seam. ``deviation_floor``: of the patch normalisation in the first layer, in units of the pixels (grey levels), or
    ``None`` to leave pixels as they are. ``turns``: each panorama is learnt in so many simulated headings with edges
    between them, so that outputs do not depend on the heading. ``ridge`` as in ``solve_slow``, for both steps of
    every node. ``double`` computes in float64, at half the speed; float32 blocks are summed in float64 in any case.

    After learning: ``model_`` (frozen), ``deltas_`` (k,).
    """

    _model: HierarchicalModel | None = None

    def __init__(
        self,
        layers: Sequence[Layer] = PANORAMA_LAYERS,
        *,
        wrap: bool = False,
        deviation_floor: float | None = 20.0,
        turns: int = 1,
        ridge: float = 0.0,
        double: bool = False,
    ) -> None:
        self.layers = layers
        self.wrap = wrap
        self.deviation_floor = deviation_floor
        self.turns = turns
        self.ridge = ridge
        self.double = double

    @property
    def model_(self) -> HierarchicalModel:
        """The frozen result of learning; raises ``NotFittedError`` before."""
        if self._model is None:
            raise NotFittedError("this HierarchicalSFA has not learnt yet: call fit first")
        return self._model

    @property
    def deltas_(self) -> FloatArray:
        """(k,) mean squared difference of each output along the edges it was learnt on, slowest first."""
        return self.model_.deltas

    def fit(
        self,
        pictures: Pictures,
        *,
        edges: Edges | None = None,
        progress: Progress | None = None,
        on_layer: Callable[[HierarchicalModel], None] | None = None,
        resume: HierarchicalModel | None = None,
    ) -> Self:
        """Learn from pictures (n, height, width), uint8 or floating, or from functions that stream batches of them.

        A list holds recordings one after the other. Without ``edges`` each picture is joined with the next one of its
        recording; ``edges`` index all pictures in order. The size of batches changes nothing, and memory does not
        grow with the number of pictures that are streamed; they and what layers make of them go through temporary
        files (36 kB and then at most 43 kB a picture for table 5.1).

        ``on_layer`` is handed the network so far after every layer; ``resume`` goes on from such a network.
        Raises ``ArrayError`` for pictures or edges that cannot be used, ``ConfigError`` for settings that do not fit
        them, ``LearningError`` for data without enough variance or edges.
        """
        report = progress or _silent
        self._model = None
        maps, edges = self._material(pictures, edges)
        lessons, network = self._lessons(maps, report), None
        if resume is not None:
            self._require_same_start(resume, maps)
        for lesson in lessons:
            if resume is not None and lesson.number <= len(resume.layers):
                network = resume.first(lesson.number)
            else:
                # One node learns from all positions; then its outputs are what the next layer learns from.
                network = self._extended(network, lesson.learn(maps, edges), lesson)
                if on_layer is not None:
                    on_layer(network)
            if lesson is not lessons[-1]:
                maps = lesson.outputs(maps, network.nodes[-1])
        self._model = network
        return self

    def transform(self, pictures: NDArray[Any]) -> FloatArray:
        """Slow features (k,) of a picture (height, width), or (n, k) of (n, height, width); see ``model_``."""
        return self.model_.transform(pictures, dtype=self._dtype)

    @property
    def _dtype(self) -> np.dtype[Any]:
        return np.dtype(np.float64 if self.double else np.float32)

    def _material(self, pictures: Pictures, edges: Edges | None) -> tuple[MapStore, Edges]:
        """All pictures, also in other headings, and the edges between them."""
        maps, lengths = stored_pictures(pictures, self._dtype)
        if len(maps) < 2:
            raise ArrayError("there is 1 picture: slow features need at least 2, of which one follows the other")
        edges = edges_in_time(lengths) if edges is None else edges
        if self.turns == 1:
            return maps, edges
        turned = TurnedMaps(maps, self.turns)
        return turned, turned.edges(edges)

    def _lessons(self, maps: MapStore, report: Progress) -> list[LayerLesson]:
        floor = self.deviation_floor
        if floor is not None and not 0 <= floor < np.inf:
            raise ConfigError(
                f"deviation_floor={floor}: has to be a finite number >= 0 in units of the pixels, or None"
            )
        grids = grids_of(self.layers, maps.shape[1:], wrap=self.wrap)
        return [
            LayerLesson(number, layer, grid, floor if number == 1 else None, self.ridge, self._dtype, report)
            for number, (layer, grid) in enumerate(zip(self.layers, grids, strict=True), start=1)
        ]

    def _extended(
        self, network: HierarchicalModel | None, node: QuadraticModel, lesson: LayerLesson
    ) -> HierarchicalModel:
        below = () if network is None else network.nodes
        shape = lesson.grid.shape[1:] if network is None else network.shape
        nodes = (*below, node)
        return HierarchicalModel(tuple(self.layers[: lesson.number]), nodes, shape, self.wrap, self.deviation_floor)

    def _require_same_start(self, network: HierarchicalModel, maps: MapStore) -> None:
        count = len(network.layers)
        found = network.layers, network.shape, network.wrap, network.deviation_floor
        if found != (tuple(self.layers[:count]), maps.shape[1:], self.wrap, self.deviation_floor):
            raise ConfigError(
                f"cannot resume: the network so far has {count} layers for {network.shape[1]}x{network.shape[0]} "
                "pictures that are not the first ones asked for here; use the same layers, pictures, wrap and "
                "deviation_floor, or start anew"
            )


def _silent(stage: str, done: int, total: int) -> None:
    """No progress is shown."""
