"""What is known of one landmark: where the robot is when it looks like this, and where it stands itself."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, ImageArray, IndexArray
from andante.errors import ArrayError, LearningError
from andante.features.illumination import Surroundings, patch_normalised, window_px
from andante.landmarks.boxes import Box
from andante.landmarks.views import ViewWindow
from andante.mapping.compact import CompactModel
from andante.mapping.landmark_config import LandmarkConfig
from andante.mapping.landmark_geometry import Geometry
from andante.mapping.learning import Ground, Recipe, learn_slow
from andante.mapping.located import Located
from andante.mapping.readout import LocalReadout, fit_readout
from andante.sfa import pca_of_samples
from andante.sfa.arrays import require_names

_PCA_SAMPLE = 800
_CONTRAST_FLOOR = 10.0
_BLOCK = 256
LEAST_VIEWS = 20
"""Of a landmark: with fewer there is nothing to learn its looks from."""


@dataclass(frozen=True, slots=True, eq=False)
class Views:
    """The views of one landmark in the frames that show it.

    ``pictures`` (n, height, width) uint8 in ``window``, ``boxes`` (n), ``frame`` (n,) the numbers of the frames,
    ascending.
    """

    name: str
    window: ViewWindow
    pictures: ImageArray
    boxes: tuple[Box, ...]
    frame: IndexArray

    def subset(self, chosen: NDArray[np.bool_]) -> Views:
        """Those views of which ``chosen`` (n,) is true."""
        boxes = tuple(box for box, keep in zip(self.boxes, chosen.tolist(), strict=True) if keep)
        return Views(self.name, self.window, self.pictures[chosen], boxes, self.frame[chosen])


@dataclass(frozen=True, eq=False)
class LandmarkModel:
    """One landmark: its ``window``, slow features of its views, what they say of the position, and its ``geometry``.

    ``window_share`` is that of the local normalisation, 0 for none. ``scale`` times the covariance of the readout is
    what held-out errors have; ``error_m`` is their median. ``geometry`` is ``None`` where the drives had no headings.
    """

    name: str
    window: ViewWindow
    window_share: float
    model: CompactModel
    readout: LocalReadout
    geometry: Geometry | None
    scale: float = 1.0
    error_m: float = 1.0

    @property
    def view_dim(self) -> int:
        """Numbers of an encoded view."""
        return self.window.width_px * self.window.height_px * (2 if self.window_share else 1)

    def slow_features(self, pictures: ImageArray) -> FloatArray:
        """Views (n, height, width) uint8 -> (n, k)."""
        parts = [
            self.model.transform(encoded(pictures[start : start + _BLOCK], self.window_share))
            for start in range(0, len(pictures), _BLOCK)
        ]
        return np.concatenate([np.empty((0, self.model.output_dim)), *parts])

    def locate(self, pictures: ImageArray) -> Located:
        """Views (n, height, width) uint8 -> n positions of the robot, their covariance calibrated."""
        return self.located(self.slow_features(pictures))

    def located(self, slow: FloatArray) -> Located:
        """The same from their slow features (n, k)."""
        located = self.readout.locate(slow)
        return replace(located, covariance=located.covariance * self.scale)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file; the name is kept elsewhere."""
        window = self.window
        numbers = [window.width_rad, window.low_rad, window.high_rad, window.width_px, window.height_px]
        numbers += [float(window.follows_elevation), self.window_share, self.scale, self.error_m]
        arrays = {f"model.{name}": array for name, array in self.model.to_arrays().items()}
        arrays |= {f"readout.{name}": array for name, array in self.readout.to_arrays().items()}
        arrays["numbers"] = np.array(numbers)
        arrays["geometry"] = np.array([] if self.geometry is None else self.geometry.numbers)
        return arrays

    @classmethod
    def from_arrays(cls, name: str, arrays: Mapping[str, NDArray[Any]]) -> LandmarkModel:
        """The inverse of ``to_arrays``; raises ``ArrayError`` for arrays that do not belong together."""
        require_names(arrays, ("numbers", "geometry"), f"landmark {name!r}")
        numbers, geometry = arrays["numbers"], arrays["geometry"]
        if numbers.shape != (9,) or geometry.shape not in ((0,), (5,)):
            raise ArrayError(f"landmark {name!r} has arrays of shapes {numbers.shape} and {geometry.shape}")
        width, low, high, columns, rows, follows, share, scale, error = numbers.tolist()
        window = ViewWindow(width, low, high, int(columns), int(rows), bool(follows))
        return cls(
            name,
            window,
            share,
            CompactModel.from_arrays(_section("model", arrays)),
            LocalReadout.from_arrays(_section("readout", arrays)),
            Geometry(*geometry.tolist()) if len(geometry) else None,
            scale,
            error,
        )


def encoded(pictures: ImageArray, window_share: float) -> NDArray[np.float32]:
    """Views (n, height, width) uint8 -> (n, height * width) whose brightness and contrast no longer count.

    Those of the whole view, and with a ``window_share`` above 0 also those of every part of it as large.
    """
    views = pictures.astype(np.float32)
    mean, deviation = views.mean(axis=(1, 2), keepdims=True), views.std(axis=(1, 2), keepdims=True)
    flat = np.asarray((views - mean) / (deviation + np.float32(_CONTRAST_FLOOR))).reshape(len(views), -1)
    if not window_share:
        return flat
    around = Surroundings.of(views, window_px(pictures.shape[1:], (window_share, window_share)), wrap=False)
    local = patch_normalised(around, _CONTRAST_FLOOR).reshape(len(views), -1)
    return np.hstack([flat, local]).astype(np.float32)


def learn_landmark(views: Views, ground: Ground, poses: FloatArray, config: LandmarkConfig) -> LandmarkModel:
    """One landmark from its views (n), the ``ground`` (n) of their frames and the ``poses`` (n, 3) of these.

    Raises ``LearningError`` for too few views.
    """
    if len(views.frame) < LEAST_VIEWS:
        raise LearningError(
            f"landmark {views.name!r} is seen in {len(views.frame)} frames, at least {LEAST_VIEWS} are needed; "
            "record a drive that passes it, or leave it out"
        )
    x = encoded(views.pictures, config.window_share)
    sample = np.unique(np.linspace(0, len(x) - 1, min(len(x), _PCA_SAMPLE)).astype(np.int64))
    pca = pca_of_samples(x[sample], min(config.pca_components, len(sample) - 1))
    recipe = Recipe(
        order="places",
        expansion="linear",
        reduced_dim=0,
        slow_features=config.slow_features,
        ridge=0.0,
        edge_ridge=config.edge_ridge,
        invariance=config.invariance,
    )
    learnt = learn_slow(pca.transform(x).astype(np.float32), ground, recipe, config.seed)
    model = CompactModel.of(learnt.model.after(pca))
    readout = fit_readout(
        model.transform(x),
        ground.xy,
        ground.session,
        metric=learnt.metric,
        config=config.readout,
        consensus_m=config.readout.consensus_m or 2 * ground.radius,
        spread=model.spread(x),
    )
    assert isinstance(readout, LocalReadout)
    geometry = Geometry.fit(views.boxes, poses)
    return LandmarkModel(views.name, views.window, config.window_share, model, readout, geometry)


def boxes_array(boxes: Sequence[Box]) -> FloatArray:
    """(n, 4) azimuth, elevation, width, height in radians."""
    return np.array([(b.azimuth_rad, b.elevation_rad, b.width_rad, b.height_rad) for b in boxes]).reshape(-1, 4)


def _section(prefix: str, arrays: Mapping[str, NDArray[Any]]) -> dict[str, NDArray[Any]]:
    start = f"{prefix}."
    return {name.removeprefix(start): array for name, array in arrays.items() if name.startswith(start)}
