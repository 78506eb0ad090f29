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

    def localize(self, image: ImageArray) -> Estimate:
        """Grey (height, width) or BGR (height, width, 3) uint8; lost only where the picture shows nothing."""
        try:
            encoded = self.front_end.encode(image)
        except BlankImageError as error:
            return Estimate(Status.LOST, str(error))
        return self.estimate(encoded)

    def estimate(self, encoded: Encoded) -> Estimate:
        """The same from one picture that is encoded already."""
        x, y = (float(value) for value in self.position(encoded.features[0]))
        reason, best = f"{self.name} always answers", (Hypothesis(x, y, 1.0),)
        if self.unit == "place":
            return Estimate(Status.OK, reason, place=round(x), hypotheses=best)
        return Estimate(Status.OK, reason, x, y, hypotheses=best)
