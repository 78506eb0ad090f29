"""What a map says of images: where slow features put them, and what the phases of the panorama think of that."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.mapping.compass import Bearings, Compass
from andante.mapping.located import Hidden, Located, Readout, Witness, tempered
from andante.mapping.readout import LocalReadout

DOUBT = 1.4
"""How fast errors grow as an image gets less like its place: fitted to their 90 % quantile in development gardens."""


@dataclass(frozen=True, slots=True, eq=False)
class Sighting:
    """n images located: ``likeness`` (n,) to the place where they are put, all that is known of it taken together.

    ``sigma`` (n,) is the expected error before calibration; ``bearings`` are ``None`` for maps without a compass.
    """

    located: Located
    likeness: FloatArray
    sigma: FloatArray
    bearings: Bearings | None

    @property
    def doubt(self) -> FloatArray:
        """(n,) how much less certain all is than it would be of an image just like its place."""
        return doubt_of(self.bearings, len(self.likeness))


@dataclass(frozen=True, slots=True, eq=False)
class Locator:
    """A readout and, where headings were mapped, a compass."""

    readout: Readout
    compass: Compass | None

    def sight(
        self, slow: FloatArray, spread: FloatArray, phase: NDArray[np.float32], hidden: Hidden | None = None
    ) -> Sighting:
        """Slow features (n, k), distances from the average (n,) and phases (n, p) -> n positions.

        What is ``hidden`` is left out.
        """
        compass = self.compass
        witness = None if compass is None else _witness(compass, phase)
        located = self.readout.locate(slow, witness, hidden)
        likeness = tempered(located.likeness, spread, located.spread)
        bearings = None
        if compass is not None:
            somewhere = np.where(np.isfinite(located.xy), located.xy, 0.0)
            bearings = compass.bearings(phase, somewhere)
            likeness = likeness * np.clip(bearings.peak, 0.0, 1.0)
        return Sighting(located, likeness, located.sigma * doubt_of(bearings, len(slow)), bearings)

    def strangers(self, slow: FloatArray, spread: FloatArray, phase: NDArray[np.float32], hidden: Hidden) -> FloatArray:
        """Likeness (m,) that images would have were their own places not mapped; none of a regression."""
        if not isinstance(self.readout, LocalReadout):
            return np.empty(0)
        sighting = self.sight(slow, spread, phase, hidden)
        return sighting.likeness[np.isfinite(sighting.located.xy).all(axis=1)]


def doubt_of(bearings: Bearings | None, count: int) -> FloatArray:
    """(count,) one where an image is just like its place or nothing is known of that, more where it is not."""
    if bearings is None:
        return np.ones(count)
    return np.asarray(np.exp(DOUBT * (1.0 - np.clip(bearings.peak, 0.0, 1.0))))


def _witness(compass: Compass, phase: NDArray[np.float32]) -> Witness:
    return lambda rows, positions: compass.persuasion(phase[rows], positions)
