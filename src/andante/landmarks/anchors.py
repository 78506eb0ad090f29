"""Anchors: things that a detector knows already, found all around a robot (thesis 7.2).

The detector looks at overlapping cuts. What it sees in several of them is one thing, also across the seam of the
panorama; a thing that the edge of one cut divides is whole in the next, or, where it is too wide for that, put together.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np

from andante.camera import PanoramaGeometry
from andante.data import ImageArray
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.cuts import Cuts
from andante.landmarks.yolox import AnchorDetector as AnchorDetector
from andante.landmarks.yolox import Found

PictureDetector = Callable[[ImageArray, float], Sequence[Found]]
"""BGR picture and least score -> what is in it, as ``AnchorDetector`` does."""

_EDGE_PX = 3.0
_SAME_IOU = 0.4
_SAME_SHARE = 0.65  # of the smaller box: what one cut shows in part another shows whole


@dataclass(frozen=True, slots=True)
class _Sighting:
    """A detection and whether the edge of its cut divides it."""

    detection: Detection
    divided: bool

    @property
    def rank(self) -> tuple[bool, float]:
        return self.divided, -self.detection.score


def near_and_far(geometry: PanoramaGeometry) -> tuple[Cuts, Cuts]:
    """The cuts that find a bicycle from 1.5 to 8 m: six wide ones for what is near, nine narrow ones for the rest."""
    return Cuts(geometry, count=6, wide_deg=100.0), Cuts(geometry, count=9, wide_deg=60.0)


def find_anchors(
    detector: PictureDetector, cuts: Sequence[Cuts], panorama: ImageArray, name: str, *, min_score: float = 0.3
) -> list[Detection]:
    """All things called ``name`` in a BGR panorama (H, W, 3), surest first; raises as ``cuts`` and ``detector`` do."""
    return _merged(
        _sighting(found, around, number)
        for around in cuts
        for number, cut in enumerate(around(panorama))
        for found in detector(cut, min_score)
        if found.name == name
    )


def _sighting(found: Found, cuts: Cuts, number: int) -> _Sighting:
    left, right = found.pixels[0], found.pixels[2]
    divided = left < _EDGE_PX or right > cuts.size_px - _EDGE_PX
    return _Sighting(Detection(_clipped(found, cuts, number), found.name, found.score), divided)


def _merged(sightings: Iterable[_Sighting]) -> list[Detection]:
    """One detection for each thing: whole ones win, of those the surest; divided ones that overlap are joined."""
    kept: list[_Sighting] = []
    for sighting in sorted(sightings, key=lambda one: one.rank):
        twins = [index for index, other in enumerate(kept) if _same(sighting.detection.box, other.detection.box)]
        if not twins:
            kept.append(sighting)
        elif sighting.divided and kept[twins[0]].divided:
            other = kept[twins[0]].detection
            kept[twins[0]] = _Sighting(
                Detection(_union(other.box, sighting.detection.box), other.name, other.score), divided=True
            )
    return sorted((one.detection for one in kept), key=lambda one: -one.score)


def _same(first: Box, second: Box) -> bool:
    smaller = min(first.width_rad * first.height_rad, second.width_rad * second.height_rad)
    return first.iou(second) > _SAME_IOU or first.shared_rad2(second) > _SAME_SHARE * smaller


def _union(first: Box, second: Box) -> Box:
    turn = 2.0 * np.pi * round((first.azimuth_rad - second.azimuth_rad) / (2.0 * np.pi))
    left = max(first.left_rad, second.left_rad + turn)
    right = min(first.right_rad, second.right_rad + turn)
    return Box.between(left, right, min(first.low_rad, second.low_rad), max(first.high_rad, second.high_rad))


def _clipped(found: Found, cuts: Cuts, number: int) -> Box:
    """A detector's rectangle may reach beyond its picture, where nothing was seen."""
    left, top, right, bottom = (min(max(value, 0.0), float(cuts.size_px)) for value in found.pixels)
    box = cuts.box(number, (left, top, right, bottom))
    low = max(box.low_rad, float(np.radians(cuts.geometry.min_deg)))
    high = min(box.high_rad, float(np.radians(cuts.geometry.max_deg)))
    return Box.between(box.left_rad, box.right_rad, min(low, high), high)
