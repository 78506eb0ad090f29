"""Where an image was taken that nobody drove by: the map imagines what should be seen from there.

Drives along the border of a lawn see all around it. What their panoramas show, and how far away that is (``stereo``),
makes a cloud of things, each with a position and with what it looks like. From any spot the direction and the height
under which each should be seen follow, and so does the view as a whole. An image is compared with views imagined from a
grid of spots as it is with mapped ones, under all headings at once; between spots a parabola decides.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy import fft, sparse

from andante.angles import wrapped
from andante.data import FloatArray, IndexArray
from andante.errors import ArrayError
from andante.features import PhaseEncoder
from andante.features.phase import ComplexArray, summit
from andante.mapping.codes import Codes
from andante.mapping.stereo import COLUMNS, DIRECTIONS, column_at, shift_between, sweep
from andante.mapping.thinning import thinned_by_place
from andante.sfa.arrays import require_names

SAMPLES = 128
"""Of a turn; between them the heading is found by a parabola."""
_THINGS, _FRAMES, _FEWEST = 4000, 240, 8
_MARGIN_RADII = 2.0
_CELLS, _FINEST_RADII = 900, 1.1
_CLOSEST_RADII = 0.6
_MOST_GROWN = 1.2
"""Things that are nearer or farther than they were seen from by more than this (its exponential) are not imagined."""
_CHUNK = 64


@dataclass(frozen=True, slots=True)
class Spot:
    """Where a view was imagined that is most like an image; ``alike`` from 1 (the same) to 0 (nothing in common).

    ``alike_mirrored`` is the same for the mirror image, wherever that fits best.
    """

    x_m: float
    y_m: float
    heading_rad: float
    alike: float
    alike_mirrored: float


@dataclass(frozen=True, slots=True, eq=False)
class Drives:
    """n mapped frames: signatures ``phase``, ``poses`` (n, 3) in metres and radians, NaN where unknown, and sessions.

    ``radius_m`` is that of a place.
    """

    encoder: PhaseEncoder
    phase: Codes
    poses: FloatArray
    session: IndexArray
    radius_m: float

    def __len__(self) -> int:
        return len(self.poses)

    def subset(self, chosen: NDArray[np.intp]) -> Drives:
        """Some of the frames."""
        return replace(self, phase=self.phase.subset(chosen), poses=self.poses[chosen], session=self.session[chosen])


@dataclass(frozen=True, eq=False)
class Scenery:
    """m things: ``codes`` (m, bands) of how each looks, ``xy`` (m, 2), ``distance_m`` (m,) from which it looks so.

    Views are imagined between the corners ``area`` (2, 2); ``radius_m`` is that of a place.
    """

    encoder: PhaseEncoder
    codes: Codes
    xy: NDArray[np.float32]
    distance_m: NDArray[np.float32]
    area: FloatArray
    radius_m: float

    @classmethod
    def fit(cls, drives: Drives, *, seed: int = 0) -> Self | None:
        """``None`` where headings are unknown, or drives too short to tell how far away anything is."""
        drives = drives.subset(np.flatnonzero(np.isfinite(drives.poses).all(axis=1)))
        if len(drives) < _FEWEST:
            return None
        drives = drives.subset(_spread_out(drives))
        encoder, xy, radius_m = drives.encoder, drives.poses[:, :2], drives.radius_m
        pictures = encoder.pictures(encoder.turned(drives.phase.rows(), -drives.poses[:, 2]), COLUMNS)
        distance, weight = np.empty((len(drives), COLUMNS)), np.empty((len(drives), COLUMNS))
        for own in (drives.session == one for one in np.unique(drives.session)):
            ranges = sweep(encoder, pictures[own], xy[own], radius_m)
            distance[own], weight[own] = ranges.distance_m, ranges.weight
        worth = int((weight > 0).sum())
        if worth < _FEWEST:
            return None
        share = weight.ravel() / weight.sum()
        things = np.random.default_rng(seed).choice(weight.size, min(_THINGS, worth), replace=False, p=share)
        looks = pictures.transpose(0, 2, 1).reshape(-1, encoder.bands)[things]
        where = (xy[:, None] + distance[..., None] * DIRECTIONS).reshape(-1, 2)[things]
        margin = _MARGIN_RADII * radius_m
        area = np.stack([xy.min(axis=0) - margin, xy.max(axis=0) + margin])
        away = distance.ravel()[things].astype(np.float32)
        return cls(encoder, Codes.of(looks), where.astype(np.float32), away, area, radius_m)

    def search(self, phase: NDArray[np.float32], least_alike: float = -1.0) -> Spot | None:
        """The spot for one signature (dim,), wherever it is and whichever way the robot looks.

        ``None`` where no view is as much alike as ``least_alike``.
        """
        seen = self.encoder.spectra(phase[None])[0]
        curves = self._alike(seen)
        peaks = curves.max(axis=1).reshape(self._grid)
        if peaks.max() < least_alike:
            return None
        i, j = (int(index) for index in np.unravel_index(int(peaks.argmax()), self._grid))
        aside = np.array([_summit(peaks[:, j], i), _summit(peaks[i], j)])
        x, y = (self._spots[i, j] + self._step * aside).tolist()
        curve = curves[i * self._grid[1] + j]
        at = int(curve.argmax())
        turn = at + _summit(np.roll(curve, SAMPLES // 2 - at), SAMPLES // 2)
        heading = wrapped(2 * np.pi * turn / SAMPLES)
        # Left and right exchanged, the coefficients of a row are conjugated.
        return Spot(x, y, heading, float(peaks[i, j]), float(self._alike(np.conj(seen)).max()))

    def _alike(self, seen: ComplexArray) -> NDArray[np.float32]:
        """How alike one image (bands, K) and all views are under every turn: (spots, SAMPLES)."""
        products = (seen.T[:, None] @ self._views)[:, 0]
        spectrum = np.zeros((products.shape[1], SAMPLES // 2 + 1), dtype=np.complex64)
        spectrum[:, 1 : len(products) + 1] = products.T
        return np.asarray(fft.irfft(spectrum, SAMPLES, axis=-1) * np.float32(SAMPLES / 2), dtype=np.float32)

    @cached_property
    def _step(self) -> float:
        """Of the grid of spots: coarser in a large garden, so that time and memory stay bounded."""
        return float(max(_FINEST_RADII * self.radius_m, np.sqrt(np.prod(self.area[1] - self.area[0]) / _CELLS)))

    @cached_property
    def _spots(self) -> FloatArray:
        """(rows, columns, 2)."""
        axes = [np.arange(low, high + self._step, self._step) for low, high in self.area.T]
        return np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1)

    @property
    def _grid(self) -> tuple[int, int]:
        return self._spots.shape[0], self._spots.shape[1]

    @cached_property
    def _views(self) -> ComplexArray:
        """(K, bands, spots): signatures of what should be seen at heading zero, conjugated."""
        spots, looks = self._spots.reshape(-1, 2).astype(np.float32), self.codes.rows()
        looks /= np.maximum(np.linalg.norm(looks, axis=1, keepdims=True), np.finfo(np.float32).tiny)
        starts = range(0, len(spots), _CHUNK)
        parts = [self.encoder.encoded(self._imagined(spots[start : start + _CHUNK], looks)) for start in starts]
        return np.ascontiguousarray(np.conj(self.encoder.spectra(np.concatenate(parts))).transpose(2, 1, 0))

    def _imagined(self, spots: NDArray[np.float32], looks: NDArray[np.float32]) -> NDArray[np.float32]:
        """Panoramas (s, bands, COLUMNS) of things that look (m, bands), from spots (s, 2)."""
        bands = looks.shape[1]
        seen = self.xy - spots[:, None]
        there = np.maximum(np.hypot(seen[..., 0], seen[..., 1]), np.float32(_CLOSEST_RADII * self.radius_m))
        grown = np.log(self.distance_m / there)
        spot, thing = np.nonzero(np.abs(grown) < _MOST_GROWN)
        seen, there, grown = seen[spot, thing], there[spot, thing], grown[spot, thing]
        # What was seen from about as far away still looks the same; and what is near hides what is behind it.
        weight = np.exp(-2 * grown**2) / np.sqrt(there)
        up = shift_between(self.encoder, self.distance_m[thing], there)
        column = spot * COLUMNS + column_at(np.arctan2(seen[:, 1], seen[:, 0]))
        shape = len(spots) * COLUMNS
        view = np.zeros((shape, bands), dtype=np.float32)
        for shift in np.unique(up).tolist():
            moved = up == shift
            above, below = max(-shift, 0), max(shift, 0)
            parts = looks[:, below : bands - above]
            picked = sparse.csr_array((weight[moved], (column[moved], thing[moved])), shape=(shape, len(looks)))
            view[:, above : bands - below] += picked @ parts
        total = np.bincount(column, weight, minlength=shape)
        # Columns of which more is known count more.
        view /= np.sqrt(np.maximum(total, np.finfo(np.float32).tiny)).astype(np.float32)[:, None]
        return np.ascontiguousarray(view.reshape(len(spots), COLUMNS, bands).transpose(0, 2, 1))

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        return {
            **self.codes.to_arrays(),
            "xy": self.xy,
            "distance": self.distance_m,
            "area": self.area,
            "radius": np.array([self.radius_m]),
        }

    @classmethod
    def from_arrays(cls, encoder: PhaseEncoder, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The inverse of ``to_arrays``."""
        require_names(arrays, ("codes", "scale", "xy", "distance", "area", "radius"), "Scenery")
        if arrays["radius"].shape != (1,):
            raise ArrayError(f"a scenery has one radius of a place, got an array of shape {arrays['radius'].shape}")
        codes, radius = Codes.from_arrays(arrays), float(arrays["radius"][0])
        return cls(encoder, codes, arrays["xy"], arrays["distance"], arrays["area"], radius)


def _spread_out(drives: Drives) -> IndexArray:
    """One frame for each place and session, and not too many of all."""
    xy, session = drives.poses[:, :2], drives.session
    cells = np.column_stack([np.round(xy / drives.radius_m), session])
    first = np.sort(np.unique(cells, axis=0, return_index=True)[1])
    return first[thinned_by_place(xy[first], session[first], _FRAMES)]


def _summit(line: NDArray[np.floating[Any]], at: int) -> float:
    """How far from the best of some samples a parabola through it and its neighbours has its top; 0 at the rim."""
    if not 0 < at < len(line) - 1:
        return 0.0
    return float(np.clip(summit(*line[at - 1 : at + 2].tolist()), -0.5, 0.5))
