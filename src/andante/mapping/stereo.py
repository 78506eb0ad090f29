"""How far away things are that a drive passes: every column of a panorama is looked for in others of the same drive.

A plane sweep (Collins 1996) over the columns of panoramas at heading zero. A thing at some distance in the direction of
a column stands in other directions, and higher or lower, seen from elsewhere along the drive: of all distances, the one
is right under which the columns where it should be seen look alike.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.features import PhaseEncoder
from andante.features.phase import summit

COLUMNS = 120
"""Of a panorama: one for 3 degrees, as much as its signature can tell apart."""
MOST_SHIFT = 4
"""Bands by which a thing may move up or down: it gets nearer by up to 2.4 times."""
_CONTEXT = (-1, 0, 1)
_NEIGHBOURS = 10
_NEAREST, _FARTHEST = 0.7, 10.0
"""Neighbours, in place radii: nearer ones see everything in the same direction, farther ones see other things."""
_DISTANCES = np.geomspace(1.7, 85.0, 18)
"""Tried, in place radii."""
_LEAST_ALIKE = 0.4

AZIMUTHS = np.pi - 2 * np.pi * (np.arange(COLUMNS) + 0.5) / COLUMNS
DIRECTIONS = np.stack([np.cos(AZIMUTHS), np.sin(AZIMUTHS)], axis=1)


@dataclass(frozen=True, slots=True, eq=False)
class Ranges:
    """For n panoramas, the ``distance_m`` (n, COLUMNS) of what each column shows; ``weight`` is 0 for no idea."""

    distance_m: FloatArray
    weight: FloatArray


def described(pictures: NDArray[np.float32], shift: int = 0) -> NDArray[np.float32]:
    """Pictures (n, bands, COLUMNS) -> columns with their neighbours (n, COLUMNS, 3 bands), each of length one.

    ``shift`` moves all things up by so many bands before, as if they were nearer.
    """
    moved = pictures
    if shift:
        moved = np.zeros_like(pictures)
        keep = pictures.shape[1] - abs(shift)
        if shift > 0:
            moved[:, :keep] = pictures[:, shift:]
        else:
            moved[:, -keep:] = pictures[:, :keep]
    around = np.concatenate([np.roll(moved, -step, axis=2) for step in _CONTEXT], axis=1).transpose(0, 2, 1)
    length = np.linalg.norm(around, axis=2, keepdims=True)
    return np.ascontiguousarray(around / np.maximum(length, 1e-6), dtype=np.float32)


def all_shifts(pictures: NDArray[np.float32], encoder: PhaseEncoder) -> NDArray[np.float32]:
    """(n, bands, COLUMNS) -> (2 m + 1, n, COLUMNS, 3 bands) for shifts by -m..m, m as ``most_shift`` says."""
    most = most_shift(encoder)
    return np.stack([described(pictures, shift) for shift in range(-most, most + 1)])


def most_shift(encoder: PhaseEncoder) -> int:
    """By how many bands things are followed up and down: none where the elevations of the bands are not known."""
    return 0 if encoder.band_step is None else min(MOST_SHIFT, encoder.bands - 1)


def shift_between(
    encoder: PhaseEncoder, before: NDArray[np.floating[Any]], after: NDArray[np.floating[Any]]
) -> NDArray[np.intp]:
    """How many bands up a thing moves whose distance changes, limited to what is followed."""
    most = most_shift(encoder)
    if encoder.band_step is None:
        return np.zeros(np.broadcast_shapes(before.shape, after.shape), dtype=np.intp)
    return np.clip(np.rint(np.log(before / after) / encoder.band_step), -most, most).astype(np.intp)


def column_at(azimuth: NDArray[np.floating[Any]]) -> NDArray[np.intp]:
    """The column that looks there."""
    column: NDArray[np.intp] = np.rint((np.pi - azimuth) * (COLUMNS / (2 * np.pi)) - 0.5).astype(np.intp) % COLUMNS
    return column


def sweep(encoder: PhaseEncoder, pictures: NDArray[np.float32], xy: FloatArray, radius_m: float) -> Ranges:
    """Of panoramas (n, bands, COLUMNS) at heading zero, taken at ``xy`` (n, 2) in one drive."""
    shifted, most = all_shifts(pictures, encoder), most_shift(encoder)
    distances = radius_m * _DISTANCES
    rays = DIRECTIONS[:, None] * distances[:, None]
    alike = np.zeros((len(xy), COLUMNS, len(distances)), dtype=np.float32)
    for i in range(len(xy)):
        apart = np.linalg.norm(xy - xy[i], axis=1)
        near = np.flatnonzero((apart > _NEAREST * radius_m) & (apart < _FARTHEST * radius_m))
        if not len(near):
            continue
        near = near[np.linspace(0, len(near) - 1, min(len(near), _NEIGHBOURS)).astype(np.intp)]
        seen = xy[i] + rays - xy[near, None, None]
        there = np.maximum(np.linalg.norm(seen, axis=-1), 1e-3)
        up = shift_between(encoder, distances, there)
        column = column_at(np.arctan2(seen[..., 1], seen[..., 0]))
        # What moved up on the way to the other panorama is moved down again.
        other = shifted[most - up, near[:, None, None], column]
        alike[i] = np.einsum("ncde,ce->cd", other, shifted[most, i]) / len(near)
    return _peaks(alike, np.log(distances))


def _peaks(alike: NDArray[np.float32], logarithms: FloatArray) -> Ranges:
    """The best distance of every column, between those tried by a parabola."""
    best = np.clip(alike.argmax(axis=2), 1, alike.shape[2] - 2)
    low, top, high = (np.take_along_axis(alike, (best + step)[..., None], 2)[..., 0] for step in (-1, 0, 1))
    between = np.clip(summit(low, top, high, least_bend=1e-6), -1, 1)
    distance = np.exp(logarithms[0] + (best + between) * (logarithms[1] - logarithms[0]))
    # Alike at one distance and not at others: a wall without end looks alike at all of them.
    clear = top - np.median(alike, axis=2)
    weight = np.maximum(top - _LEAST_ALIKE, 0) * np.maximum(clear, 0)
    return Ranges(distance.astype(np.float64), weight.astype(np.float64))
