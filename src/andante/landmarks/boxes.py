"""Boxes on the horizon circle, and what was found in them.

A panorama has no left and right end, so a box is kept by its middle and its size: it may lie across the seam.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from andante.angles import wrapped
from andante.errors import InputError

SAME_PLACE_IOU = 0.3
"""A found box that shares less than this with the true one is another place."""
_TURN = 2.0 * np.pi


@dataclass(frozen=True, slots=True)
class Box:
    """A box on the horizon circle, in radians: azimuth counter-clockwise from the robot's forward.

    ``azimuth_rad`` (-pi, pi] and ``elevation_rad`` are of its middle, ``width_rad``, ``height_rad`` its whole size.
    """

    azimuth_rad: float
    elevation_rad: float
    width_rad: float
    height_rad: float

    @classmethod
    def between(cls, left_rad: float, right_rad: float, low_rad: float, high_rad: float) -> Box:
        """From its edges; the box reaches clockwise from ``left_rad`` to ``right_rad``, less than once around."""
        width = float(np.mod(left_rad - right_rad, _TURN))
        return cls(_turned(left_rad - width / 2.0), (low_rad + high_rad) / 2.0, width, high_rad - low_rad)

    @property
    def left_rad(self) -> float:
        """Azimuth of the edge that is on the left in a picture; not wrapped, so that left - width = right."""
        return self.azimuth_rad + self.width_rad / 2.0

    @property
    def right_rad(self) -> float:
        """Azimuth of the edge that is on the right in a picture; not wrapped."""
        return self.azimuth_rad - self.width_rad / 2.0

    @property
    def low_rad(self) -> float:
        """Elevation of the lower edge."""
        return self.elevation_rad - self.height_rad / 2.0

    @property
    def high_rad(self) -> float:
        """Elevation of the upper edge."""
        return self.elevation_rad + self.height_rad / 2.0

    def shifted(self, right: float, up: float, width: float, height: float) -> Box:
        """The box of a landmark beside this one of an anchor: offset and size in units of this box's size.

        ``right`` is to the right in the picture: clockwise seen from above (thesis 7.2). A landmark that would reach
        further than once around ends where it began.
        """
        return Box(
            _turned(self.azimuth_rad - right * self.width_rad),
            self.elevation_rad + up * self.height_rad,
            min(width * self.width_rad, _TURN),
            height * self.height_rad,
        )

    def seen_from(self, anchor: Box) -> tuple[float, float, float, float]:
        """The (right, up, width, height) with which ``anchor.shifted`` gives this box.

        Raises ``InputError`` where the anchor has no size to measure in.
        """
        if not (anchor.width_rad > 0.0 and anchor.height_rad > 0.0):
            raise InputError(
                f"an anchor's box needs a width and a height to measure in, got {anchor.width_rad:g} x "
                f"{anchor.height_rad:g} rad; choose another frame"
            )
        return (
            wrapped(anchor.azimuth_rad - self.azimuth_rad) / anchor.width_rad,
            (self.elevation_rad - anchor.elevation_rad) / anchor.height_rad,
            self.width_rad / anchor.width_rad,
            self.height_rad / anchor.height_rad,
        )

    def shared_rad2(self, other: Box) -> float:
        """The area that two boxes share, in the plane of azimuth and elevation."""
        height = min(self.high_rad, other.high_rad) - max(self.low_rad, other.low_rad)
        if height <= 0.0:
            return 0.0
        # Two wide boxes can meet on both sides of the circle, so each turn counts by itself.
        width = sum(
            max(min(self.left_rad, other.left_rad + turn) - max(self.right_rad, other.right_rad + turn), 0.0)
            for turn in (-_TURN, 0.0, _TURN)
        )
        return float(width * height)

    def iou(self, other: Box) -> float:
        """Intersection over union, from 0 to 1; the same wherever on the circle the two lie."""
        shared = self.shared_rad2(other)
        union = self.width_rad * self.height_rad + other.width_rad * other.height_rad - shared
        return shared / union if union > 0.0 else 0.0


@dataclass(frozen=True, slots=True)
class Detection:
    """A box with a name (class of an anchor or a landmark) and a score from 0 to 1."""

    box: Box
    name: str
    score: float
    followed: bool = False
    """By tracking between detections, not seen by the detector."""


def _turned(azimuth_rad: float) -> float:
    """The same azimuth in (-pi, pi]."""
    turned = -wrapped(-azimuth_rad)
    return turned if turned > -np.pi else float(np.pi)  # rounding may end on the open side
