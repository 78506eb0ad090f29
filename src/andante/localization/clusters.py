"""Where the weight of many particles lies: clusters on a coarse grid."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.csgraph import connected_components

from andante.angles import wrapped
from andante.data import FloatArray

_THIN = 0.002
"""Cells with a smaller share of the weight join no others."""
_MAX_CELLS = 300
MAX_CLUSTERS = 8


@dataclass(frozen=True, eq=False)
class Cluster:
    """Some of the particles: mean (x, y, heading), covariance (3, 3), their share of the weight, and which they are."""

    mean: FloatArray
    covariance: FloatArray
    share: float
    member: NDArray[np.bool_]


def clusters_of(pose: FloatArray, weight: FloatArray, cell_m: float) -> list[Cluster]:
    """Particles (n, 3) with weights (n,) summing to one -> up to eight clusters, the one with the largest share first.

    Cells that touch belong together; particles in cells with hardly any weight belong to none.
    """
    cell = np.floor(pose[:, :2] / cell_m)
    # One number a cell: complex numbers are sorted by the real part, then by the imaginary one.
    corners, inverse = np.unique(cell[:, 0] + 1j * cell[:, 1], return_inverse=True)
    mass = np.bincount(inverse, weight, len(corners))
    thick = np.flatnonzero(mass >= min(_THIN, mass.max()))
    thick = thick[np.argsort(-mass[thick], kind="stable")[:_MAX_CELLS]]
    between = corners[thick, None] - corners[thick]
    near = (np.abs(between.real) <= 1) & (np.abs(between.imag) <= 1)
    count, label = connected_components(near, directed=False)
    of_cell = np.full(len(corners), -1)
    of_cell[thick] = label
    of_particle = of_cell[inverse]
    share = np.bincount(label, mass[thick], count)
    return [_cluster(pose, weight, of_particle == one) for one in np.argsort(-share, kind="stable")[:MAX_CLUSTERS]]


def _cluster(pose: FloatArray, weight: FloatArray, member: NDArray[np.bool_]) -> Cluster:
    inside, share = pose[member], weight[member]
    total = float(share.sum())
    share = share / total
    mean = share @ inside
    mean[2] = math.atan2(share @ np.sin(inside[:, 2]), share @ np.cos(inside[:, 2]))
    offset = inside - mean
    offset[:, 2] = wrapped(offset[:, 2])
    return Cluster(mean, (offset * share[:, None]).T @ offset, total, member)


def weighted_radius(xy: FloatArray, weight: FloatArray, centre: FloatArray, coverage: float = 0.9) -> float:
    """The radius around a centre that holds a share of the weight of points (n, 2)."""
    distance = np.hypot(*(xy - centre).T)
    order = np.argsort(distance)
    held = np.cumsum(weight[order])
    return float(distance[order[min(int(np.searchsorted(held, coverage * held[-1])), len(order) - 1)]])
