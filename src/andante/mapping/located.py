"""What every readout answers, and what it has to offer."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.errors import ArrayError
from andante.sfa.arrays import require_names


@dataclass(frozen=True, eq=False)
class Located:
    """Positions for n images.

    ``xy`` (n, 2) in metres (or places), ``covariance`` (n, 2, 2) uncalibrated, ``likeness`` (n,) from 1 (looks
    just like a mapped place) to 0 (no more like the nearest reference than like any), ``agreement`` (n,) the share of
    the evidence that speaks for this position. ``candidates`` (n, m, 2), best first, with ``weights`` (n, m) are what
    else was considered; those that speak for ``xy`` weigh nothing here, so that weights and agreement sum to one.
    ``spread`` (n,) is how far from the average the features of the mapped images lie that these resemble, infinite
    where that is not known.
    """

    xy: FloatArray
    covariance: FloatArray
    likeness: FloatArray
    agreement: FloatArray
    candidates: FloatArray
    weights: FloatArray
    spread: FloatArray

    @classmethod
    def joined(cls, parts: Sequence[Located]) -> Located:
        """One after the other."""
        if len(parts) == 1:
            return parts[0]
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))

    @property
    def sigma(self) -> FloatArray:
        """(n,) root of the covariance's trace: the expected distance to the truth, before calibration."""
        sigma: FloatArray = np.sqrt(np.trace(self.covariance, axis1=1, axis2=2))
        return sigma


Witness = Callable[[slice, FloatArray], FloatArray]
"""How much (m, c) the images of some rows speak for candidate positions (m, c, 2), beyond their slow features."""


@dataclass(frozen=True, slots=True, eq=False)
class Hidden:
    """References to do without: those within ``radius`` of the spot ``around`` (n, 2) of each image."""

    around: FloatArray
    radius: float


class Readout(Protocol):
    """Slow features (n, k) -> positions."""

    def locate(self, slow: FloatArray, witness: Witness | None = None, hidden: Hidden | None = None) -> Located:
        """(n, k) -> n positions with their uncertainty.

        A readout that weighs references asks the ``witness`` and leaves out what is ``hidden``; a regression cannot.
        """
        ...

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file."""
        ...


def tempered(likeness: FloatArray, spread: FloatArray, expected: FloatArray) -> FloatArray:
    """Likeness (n,) of images ``spread`` (n,) from the average, where mapped ones of their kind lie ``expected`` (n,).

    Slow features see only what varies along the mapped drives, and what is foreign can fall near some reference in
    their space. Likeness is a share of squared distance there; here it becomes one of the whole.
    """
    share: FloatArray = likeness / np.maximum(1.0, spread / expected) ** 2
    return share


def named_arrays(arrays: Mapping[str, NDArray[Any]], names: tuple[str, ...], count: int) -> list[NDArray[Any]]:
    """The arrays of these names, and ``numbers`` (count,); raises ``ArrayError`` where one is missing."""
    require_names(arrays, (*names, "numbers"), "this readout")
    if arrays["numbers"].shape != (count,):
        raise ArrayError(f"this readout has {count} numbers, got an array of shape {arrays['numbers'].shape}")
    return [arrays[name] for name in (*names, "numbers")]
