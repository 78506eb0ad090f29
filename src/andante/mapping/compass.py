"""Heading, and a second opinion on the place, from the phases of the panorama (theory 7).

Slow features see magnitudes alone. What these leave out is kept here: for every place the average signature of its
images, all turned to heading zero. How far it has to be turned to look like a new image is the robot's heading; how
alike the two then are tells whether this is the place at all, which no magnitude knows of.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree

from andante.angles import wrapped
from andante.data import FloatArray
from andante.errors import ArrayError
from andante.features import PhaseEncoder
from andante.features.phase import alike_under_turns, summit
from andante.mapping.codes import Codes
from andante.sfa.arrays import require_names

SAMPLES = 256
"""Of a turn; between them the peak is found by a parabola."""
BLENDED = 4
"""Places that are blended into what the spot between them looks like."""
ELSEWHERE_RAD = np.radians(20.0)
"""Farther from the peak than this, another one is a rival."""
CLEAR = 1.1
"""How many times higher than its rival a peak has to be for the heading to count as known."""
PERSUASION = 30.0
"""How fast, in its logarithm, what speaks for a place grows with how alike it is."""
_CHUNK_ROWS = 512


@dataclass(frozen=True, slots=True, eq=False)
class Bearings:
    """What a compass says of n images at n places.

    ``heading`` (n,) in radians in [-pi, pi), NaN where two headings are about as likely; ``peak`` (n,) how alike image
    and place are under it, from 1 (the same) to 0 (nothing in common), ``rival`` (n,) the same under the next best one.
    """

    heading: FloatArray
    peak: FloatArray
    rival: FloatArray


@dataclass(frozen=True, eq=False)
class Compass:
    """Signatures ``codes`` of m places of size ``cell_m`` at heading zero; their images lie around ``xy`` (m, 2)."""

    encoder: PhaseEncoder
    codes: Codes
    xy: FloatArray
    cell_m: float

    @classmethod
    def fit(
        cls, encoder: PhaseEncoder, phase: Codes, xy: FloatArray, heading: FloatArray, cell_m: float
    ) -> Self | None:
        """From signatures, positions (n, 2) and headings (n,) of mapped frames; ``None`` where no heading is known."""
        known = np.flatnonzero(np.isfinite(heading))
        if not len(known) or not phase.dim:
            return None
        cells, place = np.unique(np.round(xy[known] / cell_m), axis=0, return_inverse=True)
        place = place.ravel()
        sums = np.zeros((len(cells), phase.dim), dtype=np.float32)
        for start in range(0, len(known), _CHUNK_ROWS):
            rows = slice(start, start + _CHUNK_ROWS)
            aligned = encoder.turned(phase.rows(known[rows]), -heading[known[rows]])
            np.add.at(sums, place[rows], aligned)
        sums /= np.maximum(np.linalg.norm(sums, axis=1, keepdims=True), np.finfo(np.float32).tiny)
        count = np.bincount(place)
        centre = np.stack([np.bincount(place, xy[known, axis]) / count for axis in (0, 1)], axis=1)
        return cls(encoder, Codes.of(sums), centre, cell_m)

    def bearings(self, phase: NDArray[np.float32], xy: FloatArray) -> Bearings:
        """What signatures (n, dim) taken at positions (n, 2) say; a place far away is asked as well as a near one."""
        around = min(BLENDED, len(self.codes))
        distance, place = self.nearest(xy, around)
        # The nearest place counts wherever it is; others as far as they are about as near.
        weight = np.exp(-2 * (distance**2 - distance[:, :1] ** 2) / self.cell_m**2)
        blend = np.einsum("nm,nmd->nd", weight.astype(np.float32), self._rows[place])
        blend /= np.maximum(np.linalg.norm(blend, axis=1, keepdims=True), np.finfo(np.float32).tiny)
        curve = self._alike(phase, blend[:, None])[:, 0]
        at = curve.argmax(axis=1)
        left, peak, right = (curve[np.arange(len(curve)), (at + step) % SAMPLES] for step in (-1, 0, 1))
        shift = at + summit(left, peak, right)
        heading = wrapped(2 * np.pi * shift / SAMPLES)
        apart = np.abs(np.mod(np.arange(SAMPLES) - at[:, None] + SAMPLES // 2, SAMPLES) - SAMPLES // 2)
        rival = np.where(apart > ELSEWHERE_RAD / (2 * np.pi) * SAMPLES, curve, -np.inf).max(axis=1)
        return Bearings(np.where(peak > CLEAR * rival, heading, np.nan), peak, rival)

    def persuasion(self, phase: NDArray[np.float32], positions: FloatArray) -> FloatArray:
        """How much (n, c) signatures (n, dim) speak for the candidates ``positions`` (n, c, 2): one for the best."""
        n, count = positions.shape[:2]
        place = self.nearest(positions.reshape(-1, 2), 1)[1].reshape(n, count)
        peak = self._alike(phase, self._rows[place]).max(axis=2)
        return np.asarray(np.exp(PERSUASION * (peak - peak.max(axis=1, keepdims=True))))

    def _alike(self, phase: NDArray[np.float32], rows: NDArray[np.float32]) -> FloatArray:
        """How alike images (n, dim) and references (n, c, dim) are, (n, c, SAMPLES), under headings from 0 to 2 pi."""
        n, count, dim = rows.shape
        seen = self.encoder.spectra(phase)[:, None]
        stored = self.encoder.spectra(rows.reshape(-1, dim)).reshape(n, count, *seen.shape[2:])
        return alike_under_turns(seen, stored, SAMPLES)

    def nearest(self, xy: FloatArray, count: int) -> tuple[FloatArray, NDArray[np.intp]]:
        """Distances and numbers (n, count) of the places nearest to positions (n, 2)."""
        distance, place = self._tree.query(xy, k=[*range(1, count + 1)])
        return np.asarray(distance), np.asarray(place)

    @cached_property
    def _rows(self) -> NDArray[np.float32]:
        return self.codes.rows()

    @cached_property
    def _tree(self) -> KDTree:
        return KDTree(self.xy)

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        return {**self.codes.to_arrays(), "xy": self.xy, "cell": np.array([self.cell_m])}

    @classmethod
    def from_arrays(cls, encoder: PhaseEncoder, arrays: Mapping[str, NDArray[Any]]) -> Self:
        """The inverse of ``to_arrays``."""
        require_names(arrays, ("codes", "scale", "xy", "cell"), "Compass")
        if arrays["cell"].shape != (1,):
            raise ArrayError(f"a compass has one size of its places, got an array of shape {arrays['cell'].shape}")
        return cls(encoder, Codes.from_arrays(arrays), arrays["xy"], float(arrays["cell"][0]))
