"""Slow features over the places of a garden: spatial firing maps (thesis 9.2, figure 9.1 a)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from andante.data import FloatArray, Trajectory
from andante.errors import ArrayError, LearningError, MissingExtraError, RecordingError
from andante.mapping import Progress, SlowMap
from andante.protocols import Recording
from andante.recordings import map_frames
from andante.sfa import one_thread


@dataclass(frozen=True, slots=True)
class SpatialMaps:
    """Values of k features on a grid of places.

    ``values`` (k, rows, columns) with NaN where nobody was; ``x_m`` (columns,) and ``y_m`` (rows,) ascend.
    """

    values: FloatArray
    x_m: FloatArray
    y_m: FloatArray

    @property
    def places(self) -> tuple[FloatArray, FloatArray]:
        """Positions (n, 2) where all features are known and their values (n, k)."""
        known = np.isfinite(self.values).all(axis=0)
        x, y = np.meshgrid(self.x_m, self.y_m)
        return np.stack([x[known], y[known]], axis=1), self.values[:, known].T


def slow_feature_maps(
    slowmap: SlowMap, recording: Recording, count: int = 8, *, progress: Progress | None = None
) -> SpatialMaps:
    """The first ``count`` slow features of every picture of a recording that was taken on a grid of places.

    Each place of the grid has the mean of its pictures, so that several headings average. Raises ``RecordingError``
    without reference poses and where the poses form no grid.
    """
    slowmap = slowmap.for_recording(recording)
    with one_thread():
        infos, slow = [], []
        for info, features in map_frames(recording, lambda frame: slowmap.slow_features(frame.image)[:count]):
            infos.append(info)
            slow.append(features)
            if progress is not None:
                progress(recording.name, len(slow), len(recording.infos))
    poses = Trajectory.of(infos, "reference")
    if not poses.known.all() or not len(poses):
        raise RecordingError(f"recording {recording.name!r} has frames without reference poses; maps need all of them")
    return spatial_maps(poses.xy_m, np.stack(slow))


def spatial_maps(xy_m: ArrayLike, values: ArrayLike) -> SpatialMaps:
    """Values (n, k) at positions (n, 2) on a square grid -> maps; raises ``RecordingError`` where there is none."""
    xy, values = np.asarray(xy_m, np.float64), np.asarray(values, np.float64)
    if xy.ndim != 2 or xy.shape[1] != 2 or values.ndim != 2 or len(xy) != len(values) or not len(xy):
        raise ArrayError(f"maps need positions (n, 2) and values (n, k), got shapes {xy.shape} and {values.shape}")
    lines = [np.unique(xy[:, axis].round(6)) for axis in (0, 1)]
    if any(len(line) < 2 for line in lines) or len(lines[0]) * len(lines[1]) > 20 * len(xy):
        raise RecordingError(
            f"{len(xy)} positions on {len(lines[0])} x {len(lines[1])} lines form no grid; "
            "take the pictures with andante simulate --trajectory grid"
        )
    columns, rows = (np.searchsorted(line, xy[:, axis].round(6)) for axis, line in enumerate(lines))
    shape = (len(lines[1]), len(lines[0]))
    cells, counts = rows * shape[1] + columns, np.zeros(shape[0] * shape[1])
    np.add.at(counts, cells, 1.0)
    sums = np.zeros((shape[0] * shape[1], values.shape[1]))
    np.add.at(sums, cells, values)
    with np.errstate(invalid="ignore"):
        means = sums / counts[:, None]
    return SpatialMaps(np.ascontiguousarray(means.T).reshape(-1, *shape), lines[0], lines[1])


def axis_correlations(xy_m: FloatArray, first: FloatArray, second: FloatArray) -> tuple[float, float, float]:
    """How monotone two features are along two orthogonal axes: |r| of the first, |r| of the second, the first axis.

    Positions (n, 2) and values (n,). The axes are turned, by the angle in radians that is returned, to where the
    smaller of the two Pearson correlations is largest: what an optimal pair of slow features in open space reaches
    (Franzius et al. 2007) is close to 1.
    """
    angles = np.linspace(0.0, np.pi, 180, endpoint=False)
    along = xy_m @ np.stack([np.cos(angles), np.sin(angles)])
    across = xy_m @ np.stack([-np.sin(angles), np.cos(angles)])
    pairs = np.stack([np.abs(_correlations(along, first)), np.abs(_correlations(across, second))])
    best = int(np.argmax(pairs.min(axis=0)))
    return float(pairs[0, best]), float(pairs[1, best]), float(angles[best])


@dataclass(frozen=True, slots=True, eq=False)
class SparseCode:
    """Slow features (n, k) -> sparse units (n, c): (slow - mean) @ weights."""

    mean: FloatArray
    weights: FloatArray

    def transform(self, slow: FloatArray) -> FloatArray:
        """(n, k) -> (n, c), strongest where a unit fires."""
        return np.asarray((slow - self.mean) @ self.weights, np.float64)


def sparse_code(slow: ArrayLike, units: int, *, seed: int = 0) -> SparseCode:
    """Turn slow features (n, k) of a drive into units that fire rarely and much: place cells (Franzius et al. 2007).

    FastICA of scikit-learn; a unit's sign is that of its skewness. Raises ``MissingExtraError`` without scikit-learn,
    ``LearningError`` for more units than features or where the search does not end.
    """
    try:
        from sklearn.decomposition import FastICA
        from sklearn.exceptions import ConvergenceWarning
    except ImportError:
        raise MissingExtraError("scikit-learn", "sklearn") from None
    import warnings

    slow = np.asarray(slow, np.float64)
    if slow.ndim != 2 or not 1 <= units <= slow.shape[1]:
        raise LearningError(f"{units} sparse units need at least as many slow features (n, k), got shape {slow.shape}")
    ica = FastICA(units, whiten="unit-variance", max_iter=2000, tol=1e-3, random_state=seed)
    with warnings.catch_warnings():
        warnings.simplefilter("error", ConvergenceWarning)
        try:
            found = ica.fit_transform(slow)
        except ConvergenceWarning:
            raise LearningError("the sparse code does not settle; use fewer units or more frames") from None
    skewness = (found**3).mean(axis=0)
    return SparseCode(ica.mean_, np.asarray(ica.components_.T * np.where(skewness < 0.0, -1.0, 1.0), np.float64))


def _correlations(columns: FloatArray, values: FloatArray) -> FloatArray:
    """Pearson correlations (m,) of columns (n, m) with values (n,)."""
    columns, values = columns - columns.mean(axis=0), values - values.mean()
    scale = np.linalg.norm(columns, axis=0) * np.linalg.norm(values)
    return np.asarray(values @ columns / np.maximum(scale, 1e-12), np.float64)
