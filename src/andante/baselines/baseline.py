"""What all baselines share: the map's front end, and that they always answer."""

from __future__ import annotations

from abc import ABC, abstractmethod
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from andante.data import Estimate, FloatArray, Hypothesis, ImageArray, Status
from andante.errors import BlankImageError
from andante.mapping import FrontEnd
from andante.mapping.frontend import Encoded
from andante.mapping.slow_map import Unit

Seen = Encoded | BlankImageError
"""One picture through a front end, or why it shows nothing."""


def seen_by(front_end: FrontEnd, image: ImageArray) -> Seen:
    """Grey (height, width) or BGR (height, width, 3) uint8 -> features; raises ``ImageError`` for a foreign size."""
    try:
        return front_end.encode(image)
    except BlankImageError as error:
        return error


@dataclass(frozen=True)
class Baseline(ABC):
    """A ``Localizer`` on the same features as a map; it knows no doubt, so its status is always ok.

    ``unit`` is that of the map: metres or numbered places.
    """

    front_end: FrontEnd = field(repr=False)
    unit: Unit

    @property
    @abstractmethod
    def name(self) -> str:
        """The name in tables."""

    @abstractmethod
    def position(self, features: NDArray[np.float32]) -> FloatArray:
        """(d,) -> (2,) metres, or the place number and zero."""

    @property
    @abstractmethod
    def bytes(self) -> int:
        """What has to be kept for localizing; features count one byte a number, as in maps."""

    def localize(self, image: ImageArray) -> Estimate:
        """Grey (height, width) or BGR (height, width, 3) uint8; lost only where the picture shows nothing."""
        return self.locate(self.prepare(image))

    def prepare(self, image: ImageArray) -> Seen:
        """The features of an image."""
        return seen_by(self.front_end, image)

    def locate(self, prepared: Seen) -> Estimate:
        """What was prepared -> estimate."""
        if isinstance(prepared, BlankImageError):
            return Estimate(Status.LOST, str(prepared))
        return self.estimate(prepared)

    def estimate(self, encoded: Encoded) -> Estimate:
        """The same from one picture that is encoded already."""
        x, y = (float(value) for value in self.position(encoded.features[0]))
        reason, best = f"{self.name} always answers", (Hypothesis(x, y, 1.0),)
        if self.unit == "place":
            return Estimate(Status.OK, reason, place=round(x), hypotheses=best)
        return Estimate(Status.OK, reason, x, y, hypotheses=best)
