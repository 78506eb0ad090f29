"""Anchors: things that a detector knows already, found all around a robot (thesis 7.2).

The detector looks at overlapping cuts. What it sees in several of them is one thing, also across the seam of the
panorama; a thing that the edge of one cut divides is whole in the next, or put together where it is too wide for that.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from andante.camera import PanoramaGeometry
from andante.data import ImageArray
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.cuts import Cuts
from andante.landmarks.yolox import AnchorDetector, Found

__all__ = [
    "ALSO_TAKEN_FOR",
    "AnchorDetector",
    "PictureDetector",
    "Sighting",
    "anchors_among",
    "find_anchors",
    "look_around",
    "near_and_far",
]

PictureDetector = Callable[[ImageArray, float], Sequence[Found]]
"""BGR picture and least score -> what is in it, as ``AnchorDetector`` does."""

ALSO_TAKEN_FOR: Mapping[str, frozenset[str]] = {
    "car": frozenset({"truck", "bus"}),
    "truck": frozenset({"car", "bus"}),
    "bicycle": frozenset({"motorcycle"}),
    "motorcycle": frozenset({"bicycle"}),
    "suitcase": frozenset({"handbag", "backpack"}),
}
"""Names that a detector gives to things of another name: seen from so low down, a small car is a truck."""

_EDGE_PX = 3.0
_SAME_IOU = 0.4
_SAME_SHARE = 0.65  # of the smaller box: what one cut shows in part another shows whole
_JOINED_SHARE = 0.25


@dataclass(frozen=True, slots=True)
class Sighting:
    """A detection and whether the edge of its cut divides it."""

    detection: Detection
    divided: bool


def near_and_far(geometry: PanoramaGeometry) -> tuple[Cuts, Cuts]:
    """The cuts that find a bicycle from 1.5 to 8 m: six wide ones for what is near, nine narrow ones for the rest."""
    return Cuts(geometry, count=6, wide_deg=100.0), Cuts(geometry, count=9, wide_deg=60.0)


def find_anchors(
    detector: PictureDetector, cuts: Sequence[Cuts], panorama: ImageArray, name: str, *, min_score: float = 0.3
) -> list[Detection]:
    """All things called ``name`` in a BGR panorama (H, W, 3), surest first; raises as ``cuts`` and ``detector`` do.

    Things taken for something that ``name`` is mistaken for count as well (``ALSO_TAKEN_FOR``).
    """
    return anchors_among(look_around(detector, cuts, panorama, min_score=min_score), name)


def look_around(
    detector: PictureDetector, cuts: Sequence[Cuts], panorama: ImageArray, *, min_score: float = 0.3
) -> list[Sighting]:
    """Whatever the detector knows in all cuts of a BGR panorama (H, W, 3); raises as ``cuts`` and ``detector`` do."""
    return [
        _sighting(found, around, number)
        for around in cuts
        for number, cut in enumerate(around(panorama))
        for found in detector(cut, min_score)
    ]


def anchors_among(sightings: Iterable[Sighting], name: str) -> list[Detection]:
    """The things called ``name``, or taken for something else as above, surest first."""
    names = {name} | ALSO_TAKEN_FOR.get(name, frozenset())
    return _merged(
        replace(one, detection=replace(one.detection, name=name)) for one in sightings if one.detection.name in names
    )


def _sighting(found: Found, cuts: Cuts, number: int) -> Sighting:
    left, right = found.pixels[0], found.pixels[2]
    divided = left < _EDGE_PX or right > cuts.size_px - _EDGE_PX
    return Sighting(Detection(_clipped(found, cuts, number), found.name, found.score), divided)


def _merged(sightings: Iterable[Sighting]) -> list[Detection]:
    """One detection for each thing: parts are joined first, then whole ones win and of those the surest."""
    whole: list[Detection] = []
    parts: list[Detection] = []
    for sighting in sightings:
        (parts if sighting.divided else whole).append(sighting.detection)
    kept: list[Detection] = []
    for detection in [*sorted(whole, key=_score, reverse=True), *sorted(_joined(parts), key=_score, reverse=True)]:
        if not any(_same(detection.box, other.box) for other in kept):
            kept.append(detection)
    return sorted(kept, key=_score, reverse=True)


def _joined(parts: Iterable[Detection]) -> list[Detection]:
    """What the edges of neighbouring cuts divide, put together; the surest part gives the score."""
    joined: list[Detection] = []
    for part in sorted(parts, key=lambda one: one.box.azimuth_rad):
        whole = part
        for other in [one for one in joined if _share(one.box, whole.box) > _JOINED_SHARE]:
            joined.remove(other)
            whole = replace(max(whole, other, key=_score), box=_union(whole.box, other.box))
        joined.append(whole)
    return joined


def _score(detection: Detection) -> float:
    return detection.score


def _share(first: Box, second: Box) -> float:
    """How much of the smaller box the other one covers."""
    smaller = min(first.width_rad * first.height_rad, second.width_rad * second.height_rad)
    return first.shared_rad2(second) / smaller if smaller > 0.0 else 0.0


def _same(first: Box, second: Box) -> bool:
    return first.iou(second) > _SAME_IOU or _share(first, second) > _SAME_SHARE


def _union(first: Box, second: Box) -> Box:
    turn = 2.0 * np.pi * round((first.azimuth_rad - second.azimuth_rad) / (2.0 * np.pi))
    left = max(first.left_rad, second.left_rad + turn)
    right = min(first.right_rad, second.right_rad + turn)
    return Box.between(left, right, min(first.low_rad, second.low_rad), max(first.high_rad, second.high_rad))


def _clipped(found: Found, cuts: Cuts, number: int) -> Box:
    """A detector's rectangle may reach beyond its picture, where nothing was seen.

    What the lower edge of a cut divides goes on below it, by how much is not known: as far as cuts reach.
    """
    left, top, right, bottom = (min(max(value, 0.0), float(cuts.size_px)) for value in found.pixels)
    box = cuts.box(number, (left, top, right, bottom))
    divided = bottom > cuts.size_px - _EDGE_PX
    low = cuts.lowest_rad if divided else max(box.low_rad, float(np.radians(cuts.geometry.min_deg)))
    high = min(box.high_rad, float(np.radians(cuts.geometry.max_deg)))
    return Box.between(box.left_rad, box.right_rad, min(low, high), high)
