"""Where something lies in what a robot sees, in angles: the same for every camera and resolution."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Box:
    """A box in radians: azimuth counter-clockwise from the robot's forward, in (-pi, pi], elevation from the horizon.

    Both are those of its middle; width and height are its whole size.
    """

    azimuth_rad: float
    elevation_rad: float
    width_rad: float
    height_rad: float


@dataclass(frozen=True, slots=True)
class Detection:
    """Something of a known name in a box; ``followed`` where a tracker bridged a gap of the detector."""

    box: Box
    name: str
    score: float
    followed: bool = False
