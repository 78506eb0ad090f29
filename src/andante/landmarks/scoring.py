"""From heat to a score that means something: the probability that a found place is the right one.

A logistic curve through places that were right and wrong on held-out pictures (Platt 1999, "Probabilistic outputs for
support vector machines", with his targets, which keep the curve finite where the two are told apart completely).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.special import expit

from andante.data import FloatArray
from andante.errors import LearningError

_LEAST_THRESHOLD = 0.25


@dataclass(frozen=True, slots=True)
class Score:
    """``sigmoid(slope * heat + offset)``, believed from ``threshold`` on."""

    slope: float
    offset: float
    threshold: float

    def of(self, heat: FloatArray) -> FloatArray:
        """Scores of heats as logits, of one shape."""
        return np.asarray(expit(self.slope * heat + self.offset), np.float64)


NEVER = Score(1.0, -50.0, 1.0)
"""Of a landmark that is not to be found at all."""


def fitted(heat: FloatArray, right: NDArray[np.bool_], false_positives: float) -> Score:
    """The score of held-out places with ``heat`` (n,) that were ``right`` (n,) or not.

    At most the share ``false_positives`` of the wrong ones reaches the threshold, which is never below 0.25: right
    places of another season score lower than those of any held-out picture, and a map looks at a view before it
    believes it. Raises ``LearningError`` where right places are no hotter than wrong ones, so that no threshold tells
    them apart.
    """
    hits, misses = int(right.sum()), int((~right).sum())
    if not hits or not misses or heat[right].mean() <= heat[~right].mean():
        raise LearningError(
            f"{hits} right and {misses} wrong places on held-out pictures cannot be told apart; teach the landmark "
            "from more places, choose a region that looks like nothing else, or learn for longer"
        )
    target = np.where(right, (hits + 1.0) / (hits + 2.0), 1.0 / (misses + 2.0))
    middle, scale = heat.mean(), heat.std() + 1e-9
    standard = (heat - middle) / scale

    def cost(curve: FloatArray) -> tuple[float, FloatArray]:
        logit = curve[0] * standard + curve[1]
        apart = expit(logit) - target
        value = (np.logaddexp(0.0, logit) - target * logit).mean()
        return float(value), np.array([(apart * standard).mean(), apart.mean()])

    slope, offset = minimize(cost, np.array([1.0, 0.0]), jac=True, method="BFGS").x
    score = Score(float(slope / scale), float(offset - slope * middle / scale), _LEAST_THRESHOLD)
    wrong = float(np.quantile(score.of(heat[~right]), 1.0 - false_positives))
    return Score(score.slope, score.offset, max(_LEAST_THRESHOLD, wrong))
