"""What the landmarks in one image say of the pose, each for itself and together."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray
from andante.landmarks.boxes import Box
from andante.mapping.landmark_fusion import by_covariance, by_inverse_error, inflation
from andante.mapping.landmark_geometry import Geometry, adjusted
from andante.mapping.landmark_model import LandmarkModel
from andante.mapping.located import Located
from andante.mapping.uncertainty import RADIUS_OF_90_PERCENT

Fusion = Literal["covariance", "inverse-error"]
_FAMILIAR = 0.6
"""Likeness below which views of the development gardens led anywhere: a thing before the landmark, a wrong box."""
_MEDIAN_SHARE = 1.1774  # of the radius of a round Gaussian, in deviations along an axis: half of it is inside


@dataclass(frozen=True, slots=True)
class Sight:
    """One landmark in one image: its box, and where it says that the robot is.

    ``xy`` (2,) has ``covariance`` (2, 2); ``agreement`` is the share of the evidence of its slow features behind it,
    ``likeness`` from 0 to 1 how much the view is like a mapped one.
    """

    model: LandmarkModel
    box: Box
    xy: FloatArray
    covariance: FloatArray
    agreement: float
    likeness: float = 1.0

    @property
    def familiar(self) -> bool:
        """Whether the view is like one that was mapped; if not, its position is worth nothing, its box maybe."""
        return self.likeness >= _FAMILIAR

    @property
    def radius_m(self) -> float:
        """Of a circle that holds 90 % of such a Gaussian, were it round."""
        return float(RADIUS_OF_90_PERCENT * np.sqrt(np.trace(self.covariance) / 2))


def sights_in(model: LandmarkModel, boxes: Sequence[Box], located: Located) -> list[Sight]:
    """One landmark in n images, where its views were ``located`` (n)."""
    columns = (located.xy, located.covariance, located.agreement.tolist(), located.likeness.tolist())
    return [Sight(model, box, *row) for box, *row in zip(boxes, *columns, strict=True)]


def trusted(sights: Sequence[Sight]) -> list[Sight]:
    """Those whose views are like mapped ones, or all where none is: then the best that can be guessed."""
    return [one for one in sights if one.familiar] or list(sights)


@dataclass(frozen=True, slots=True, eq=False)
class Fused:
    """A pose (3,) with NaN for an unknown heading, and its covariance (3, 3), not yet calibrated."""

    pose: FloatArray
    covariance: FloatArray

    @property
    def sigma_m(self) -> float:
        """Expected distance to the truth, before calibration."""
        return float(np.sqrt(np.trace(self.covariance[:2, :2])))

    @property
    def sigma_rad(self) -> float:
        """Expected deviation of the heading, before calibration; NaN where it is unknown."""
        return float(np.sqrt(self.covariance[2, 2]))


def fused(sights: Sequence[Sight], fusion: Fusion, correlation: float) -> Fused:
    """What m >= 1 landmarks say together.

    By covariance: as correlated as held-out errors were, and with the angles between them and how high they reach. By
    inverse error: as in thesis 7.3.3, positions alone; the heading follows from where the boxes are.
    """
    xy = np.array([one.xy for one in sights])
    covariance = np.array([one.covariance for one in sights])
    boxes = [one.box for one in sights]
    things = [one.model.geometry for one in sights if one.model.geometry is not None]
    if fusion == "inverse-error":
        errors = np.array([one.model.error_m for one in sights])
        mean = by_inverse_error(xy, errors)
        spread = np.eye(2) * (len(errors) / (1.0 / errors).sum() / _MEDIAN_SHARE) ** 2
    elif len(things) == len(sights):
        found = adjusted(xy, covariance * inflation(len(sights), correlation), boxes, things)
        return Fused(found.pose, found.covariance)
    else:
        mean, spread = by_covariance(xy, covariance, correlation)
    return _with_heading(mean, spread, [(one.box, one.model.geometry) for one in sights])


def _with_heading(xy: FloatArray, covariance: FloatArray, seen: Sequence[tuple[Box, Geometry | None]]) -> Fused:
    """A position, and the heading in which landmarks at known places would be seen where they are seen from there."""
    turns, precision = list[float](), list[float]()
    for box, thing in seen:
        if thing is not None:
            away = np.array([thing.x_m, thing.y_m]) - xy
            turns.append(float(np.arctan2(away[1], away[0])) - box.azimuth_rad)
            apart = np.sqrt(np.trace(covariance) / 2) / max(float(np.linalg.norm(away)), 0.3)
            precision.append(1.0 / (thing.bearing_rad**2 + apart**2))
    heading, variance = np.nan, np.nan
    if turns:
        weight = np.array(precision)
        heading = wrapped(float(np.angle((weight * np.exp(1j * np.array(turns))).sum())))
        variance = 1.0 / weight.max()
    whole = np.full((3, 3), np.nan)
    whole[:2, :2] = covariance
    whole[2, 2] = variance
    return Fused(np.array([*xy, heading]), whole)
