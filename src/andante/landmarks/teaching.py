"""One gesture of a person -> labels in all frames: where a landmark lies beside an anchor (thesis 7.2).

An anchor is an object that a detector knows already, as a bicycle, put beside the landmark. The person says in one
frame where the landmark lies, in units of the anchor's box; all frames in which the anchor was found follow from it.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from typing import Protocol

import numpy as np

from andante.camera import PanoramaGeometry
from andante.errors import InputError, LearningError
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.labels import check_name
from andante.landmarks.search import MIN_FRAMES, Progress, check_long_enough, require_enough
from andante.landmarks.tracks import Chosen
from andante.landmarks.windows import clipped, visible_share
from andante.protocols import Recording

FARTHEST, LARGEST = 20.0, 20.0
"""Of an offset and of a size, in units of the anchor's box."""
SUGGESTED = ("bicycle", "suitcase", "car", "umbrella", "person", "chair", "potted plant", "sports ball")
"""Anchors that are easy to come by and to recognise; those of the thesis first (7.4)."""
_LARGE_RAD = math.radians(15.0)
_VISIBLE_SHARE = 0.5
_LISTED = 12
"""Kinds of anchor that a message names."""
_WIDEST_RAD = math.pi


class AnchorFinder(Protocol):
    """Whatever finds an anchor in a recording."""

    @property
    def names(self) -> Sequence[str]:
        """The kinds of anchor that it knows."""
        ...

    def find(
        self, recording: Recording, name: str, progress: Progress | None = None, *, chosen: Chosen | None = None
    ) -> Mapping[int, Detection]:
        """The one anchor of this kind, by index of the frames in which it was found.

        ``chosen`` tells it from another one. Raises ``AndanteError`` where there are several and nothing tells.
        """
        ...


@dataclass(frozen=True, slots=True)
class Relation:
    """Where a landmark lies beside its anchor, in units of the anchor's box.

    ``right`` and ``up`` lead from middle to middle, ``width`` and ``height`` are the landmark's size. Raises
    ``InputError`` for sizes that are not positive and for anything beyond 20 anchors.
    """

    right: float
    up: float
    width: float
    height: float

    def __post_init__(self) -> None:
        if not (abs(self.right) <= FARTHEST and abs(self.up) <= FARTHEST):
            raise InputError(
                f"a landmark {self.right:g} to the right and {self.up:g} above its anchor is no neighbour: give at "
                f"most {FARTHEST:g} times the size of the anchor's box"
            )
        if not (0.0 < self.width <= LARGEST and 0.0 < self.height <= LARGEST):
            raise InputError(
                f"a landmark of {self.width:g} x {self.height:g} times the anchor's box cannot be: give a width and a "
                f"height above 0, at most {LARGEST:g}"
            )

    @classmethod
    def between(cls, anchor: Box, landmark: Box) -> Relation:
        """How one box lies beside another."""
        return cls(*landmark.seen_from(anchor))

    def box(self, anchor: Box) -> Box:
        """The landmark beside an anchor."""
        return anchor.shifted(self.right, self.up, self.width, self.height)


@dataclass(frozen=True, slots=True)
class AnchorTrack:
    """One anchor through a recording: by index of the frame, ascending, where it was found.

    Raises ``LearningError`` where it was found in fewer than 10 frames.
    """

    name: str
    detections: Mapping[int, Detection]

    def __post_init__(self) -> None:
        require_enough(self.name, len(self.detections))

    def best_frame(self) -> int:
        """A frame to draw in: seen rather than followed, then where score and size are high.

        Larger than 15 degrees counts no more: there is no room then for a landmark that towers above its anchor, and
        what is drawn from close by fits less to frames from further away.
        """

        def merit(index: int) -> tuple[bool, float]:
            one = self.detections[index]
            return not one.followed, one.score * min(math.sqrt(one.box.width_rad * one.box.height_rad), _LARGE_RAD)

        return max(self.detections, key=merit)


@dataclass(frozen=True, slots=True)
class Lesson:
    """A landmark that was taught: its name, by which kind of anchor, how, and its box by index of the frame.

    ``anchors`` are the boxes of the anchor, also in frames in which the landmark cannot be seen.
    """

    name: str
    anchor: str
    relation: Relation
    boxes: Mapping[int, Box]
    anchors: Mapping[int, Box]

    def without(self, frames: Sequence[int]) -> Lesson:
        """The same without some frames; raises ``LearningError`` where fewer than 10 are left."""
        kept = {index: box for index, box in self.boxes.items() if index not in frames}
        if len(kept) < MIN_FRAMES:
            raise LearningError(
                f"landmark {self.name!r} would be left with {len(kept)} frames, at least {MIN_FRAMES} are needed; keep "
                "more frames or draw the landmark again"
            )
        return replace(self, boxes=kept)


def find_track(
    finder: AnchorFinder, recording: Recording, name: str, progress: Progress, chosen: Chosen | None = None
) -> AnchorTrack:
    """Look for an anchor in a recording.

    Raises ``InputError`` for a kind that the finder does not know and a frame that the recording does not have,
    ``LearningError`` where there is none, or in too few frames, and what the finder raises.
    """
    check_search(finder, recording, name, chosen)
    return AnchorTrack(name, dict(sorted(finder.find(recording, name, progress, chosen=chosen).items())))


def check_search(finder: AnchorFinder, recording: Recording, name: str, chosen: Chosen | None = None) -> None:
    """Whether a search can find anything: before the minutes that it takes.

    Raises ``InputError`` for a kind of anchor that the finder does not know and for a frame that the recording does not
    have, ``LearningError`` for a recording that is too short.
    """
    if name not in finder.names:
        usual = [kind for kind in SUGGESTED if kind in finder.names]
        alike = get_close_matches(name, finder.names, n=3)
        listed = list(dict.fromkeys([*alike, *usual])) if len(finder.names) > _LISTED else finder.names
        others = f" ({len(finder.names) - len(listed)} others are known)" if len(finder.names) > len(listed) else ""
        raise InputError(f"no detector knows an anchor {name[:40]!r}; choose one of: {', '.join(listed)}{others}")
    check_long_enough(recording)
    frames = len(recording.infos)
    if chosen is not None and not 0 <= chosen.frame < frames:
        raise InputError(
            f"frame {chosen.frame:.6g} does not exist, recording {recording.name!r} has frames 0 to {frames - 1}; "
            "choose one of them to tell two anchors apart"
        )


def teach(name: str, track: AnchorTrack, relation: Relation, geometry: PanoramaGeometry) -> Lesson:
    """The landmark's box in every frame with the anchor in which at least half of it lies in the picture.

    Boxes are cut off where the picture ends. Raises ``InputError`` for a name that cannot be one, and where the box
    lies outside of the picture in too many frames.
    """
    check_name(name)
    boxes = {index: relation.box(one.box) for index, one in track.detections.items()}
    kept = {index: part for index, box in boxes.items() if (part := _shown(box, geometry)) is not None}
    if len(kept) < MIN_FRAMES:
        raise InputError(_unusable(name, track, list(boxes.values()), len(boxes) - len(kept), geometry))
    anchors = {index: one.box for index, one in track.detections.items()}
    return Lesson(name, track.name, relation, kept, anchors)


def _unusable(name: str, track: AnchorTrack, boxes: Sequence[Box], lost: int, geometry: PanoramaGeometry) -> str:
    """Why most boxes cannot be labels."""
    often = f"in {lost} of {len(boxes)} frames"
    widest = math.degrees(float(np.median([box.width_rad for box in boxes])))
    if widest > math.degrees(_WIDEST_RAD):
        return (
            f"landmark {name!r} would be more than {math.degrees(_WIDEST_RAD):.0f} degrees wide {often}, {widest:.0f} "
            "in the median, and nothing that wide can be a landmark; choose a narrower box"
        )
    middle = math.degrees(float(np.median([box.elevation_rad for box in boxes])))
    above = middle > (geometry.min_deg + geometry.max_deg) / 2.0
    edge = (
        f"above its upper edge at {geometry.max_deg:.0f}"
        if above
        else f"below its lower edge at {geometry.min_deg:.0f}"
    )
    return (
        f"landmark {name!r} lies outside of the picture {often}, {edge} degrees of elevation; choose a box nearer to "
        f"the {track.name}"
    )


def spread(frames: Sequence[int], count: int) -> list[int]:
    """At most ``count`` of some frames, spread evenly, both ends included."""
    places = np.unique(np.linspace(0, len(frames) - 1, min(count, len(frames))).round().astype(int))
    return [frames[at] for at in places]


def nearest(frames: Sequence[int], chosen: Sequence[int]) -> dict[int, list[int]]:
    """Each of some ascending frames with the one of ``chosen``, some of them, that is next to it: by that one."""
    around: dict[int, list[int]] = {index: [] for index in chosen}
    for index in frames:
        around[min(chosen, key=lambda one: abs(one - index))].append(index)
    return around


def _shown(box: Box, geometry: PanoramaGeometry) -> Box | None:
    """What of a box can be a label."""
    if box.width_rad > _WIDEST_RAD or visible_share(box, geometry) < _VISIBLE_SHARE:
        return None
    return clipped(box, geometry)
