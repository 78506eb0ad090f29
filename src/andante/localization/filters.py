"""What a tracker asks of its filter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, Hypothesis
from andante.localization.judge import Belief
from andante.localization.motion import Step
from andante.localization.sighting import Sighting
from andante.localization.trail import Trail

UNKNOWN_HEADING_RAD2 = 0.35
"""A heading of a larger variance is none."""


@dataclass(frozen=True, eq=False)
class Gauss:
    """Mean (x, y, heading) and covariance (3, 3) of the place that is believed in most."""

    mean: FloatArray
    covariance: FloatArray

    @property
    def variance_m2(self) -> float:
        """Of the position, along an average axis."""
        return float(self.covariance[0, 0] + self.covariance[1, 1]) / 2

    @property
    def heading_known(self) -> bool:
        """Whether the headings have a direction at all."""
        return bool(self.covariance[2, 2] < UNKNOWN_HEADING_RAD2)


@dataclass(frozen=True, eq=False)
class Weighted:
    """A sighting, and how much of it is news (``Novelty``).

    Its likelihood has bells to the power of ``sharpness`` above a ``floor``, and is taken to the power of ``decision``;
    ``contradicts`` says whether it speaks for another place than the prediction.
    """

    sighting: Sighting
    sharpness: float
    decision: float
    floor: float
    contradicts: bool

    def likelihood(self, pose: FloatArray) -> FloatArray:
        """(n, 3) x, y, heading -> (n,)."""
        return self.sighting.likelihood(pose, self.sharpness, self.floor) ** self.decision


class Filter(Protocol):
    """Where the robot may be, as a distribution; empty until the first sighting."""

    @property
    def best(self) -> Gauss | None:
        """The place that is believed in most; ``None`` while empty."""
        ...

    @property
    def belief(self) -> Belief | None:
        """What decides how far it is believed."""
        ...

    @property
    def hypotheses(self) -> tuple[Hypothesis, ...]:
        """All places, best first."""
        ...

    def move(self, step: Step) -> None:
        """Follow odometry."""
        ...

    def correct(self, seen: list[Weighted], trail: Trail, *, doubt: float) -> None:
        """Take in what was seen; ``doubt`` from 0 to 1 says how much lately contradicted the prediction."""
        ...

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Its state, for a file."""
        ...

    @property
    def generator_state(self) -> dict[str, Any] | None:
        """That of its generator, as plain values; ``None`` where it draws nothing."""
        ...

    def resume(self, arrays: Mapping[str, NDArray[np.float64]], generator: dict[str, Any] | None) -> None:
        """The inverse of both; raises ``ArrayError`` or another ``ValueError``, ``KeyError`` or ``TypeError``."""
        ...
