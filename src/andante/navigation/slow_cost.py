"""How far a place is from the goal, judged by slow features alone (thesis 9.3; theory 6)."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from andante.data import FloatArray
from andante.errors import ConfigError

_LEAST_DELTA = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class SlowCost:
    """The weighted distance to ``goal`` (k,): sqrt(sum_k ``weight``_k (y_k - goal_k)^2); weights (k,) are squared
    scales.

    Raises ``ConfigError`` where there are not as many weights as features, or one is negative.
    """

    goal: FloatArray
    weight: FloatArray

    def __post_init__(self) -> None:
        if self.goal.ndim != 1 or self.goal.shape != self.weight.shape or not (self.weight >= 0.0).all():
            raise ConfigError(
                f"a cost needs one weight of 0 or more for each slow feature of the goal (k,), got shapes "
                f"{self.weight.shape} and {self.goal.shape}"
            )

    @classmethod
    def plain(cls, goal: FloatArray, count: int = 2) -> SlowCost:
        """The Euclidean distance in the ``count`` slowest features; two in the thesis (9.4)."""
        return cls(goal, (np.arange(len(goal)) < count).astype(np.float64))

    @classmethod
    def commute(cls, goal: FloatArray, deltas: FloatArray) -> SlowCost:
        """The truncated commute-time distance of the training graph (theory 6): features count 1 / delta, squared."""
        return cls.spectral(goal, deltas, 1.0)

    @classmethod
    def biharmonic(cls, goal: FloatArray, deltas: FloatArray) -> SlowCost:
        """The truncated biharmonic distance (Lipman, Rustamov and Funkhouser, ACM TOG 29, 2010): 1 / delta^2, squared.

        In the plane the commute-time distance grows as a logarithm, so that far from the goal its slope is lost in the
        noise. This one grows almost as the way does, and still knows of obstacles.
        """
        return cls.spectral(goal, deltas, 2.0)

    @classmethod
    def spectral(cls, goal: FloatArray, deltas: FloatArray, power: float) -> SlowCost:
        """Weights delta^-power, in such units that an edge of the training graph is 1 long in the root mean square.

        Where an edge joins an image with the next one, costs near the goal count the steps of the training drive.
        """
        weight = np.maximum(deltas, _LEAST_DELTA) ** -power
        return cls(goal, weight / (weight @ np.maximum(deltas, _LEAST_DELTA)))

    def comparable(self, count: int = 2) -> SlowCost:
        """The same in other units: between two random places it is as large as ``plain`` of ``count`` features.

        So the thesis' threshold means the same for both, as all features have unit variance.
        """
        return SlowCost(self.goal, self.weight * (count / self.weight.sum()))

    def of(self, slow: FloatArray) -> float:
        """Slow features (k,) -> their distance to the goal."""
        return float(np.sqrt(self.weight @ (slow - self.goal) ** 2))

    def scaled(self, slow: FloatArray) -> FloatArray:
        """Slow features (k,) as an offset to the goal (k,) whose length is the cost."""
        offset: FloatArray = np.sqrt(self.weight) * (slow - self.goal)
        return offset
