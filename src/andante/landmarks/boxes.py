"""Boxes on the horizon circle, and what was found in them."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Box:
    """A box on the horizon circle, in radians: azimuth counter-clockwise from the robot's forward.

    `azimuth_rad` (-pi, pi] and `elevation_rad` are of its middle, `width_rad`, `height_rad` its whole size.
    """

    azimuth_rad: float
    elevation_rad: float
    width_rad: float
    height_rad: float


@dataclass(frozen=True, slots=True)
class Detection:
    """A box with a name (class of an anchor or a landmark) and a score from 0 to 1."""

    box: Box
    name: str
    score: float
    followed: bool = False  # by tracking between detections, not seen by the detector
