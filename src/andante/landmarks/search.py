"""One anchor through all frames of a recording: detected, outliers removed, followed where it was missed."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from threading import Lock

import numpy as np

from andante.camera import PanoramaGeometry
from andante.data import FloatArray, ImageArray, Trajectory
from andante.errors import ConfigError, ImageError, InputError, LearningError
from andante.landmarks.anchors import PictureDetector, Sighting, anchors_among, look_around, near_and_far
from andante.landmarks.boxes import Detection
from andante.landmarks.coco_names import COCO_NAMES
from andante.landmarks.following import MAX_GAP, fill_gaps
from andante.landmarks.standing import standing_still
from andante.landmarks.surroundings import Surroundings
from andante.landmarks.tracks import Chosen, one_anchor
from andante.landmarks.turning import Spectrum, horizon_spectrum, turn_between
from andante.landmarks.windows import elevations_rad
from andante.protocols import Recording
from andante.recordings import ordered_map

MIN_FRAMES = 10
"""An anchor seen in fewer frames teaches nothing."""
_AT_THE_EDGE_RAD = float(np.radians(0.5))
_WHOLE_SHARE = 0.25

Progress = Callable[[int, int], None]
"""Called with frames searched and frames in all."""


@dataclass
class _Seen:
    """What was seen in the first frames of a recording, as far as it was looked at."""

    recording: Recording
    sightings: list[list[Sighting] | None] = field(default_factory=list)  # of a frame; None where it cannot be read
    turn_rad: list[float] = field(default_factory=list)  # since frame 0
    last: Spectrum | None = None
    lock: Lock = field(default_factory=Lock)


class AnchorSearch:
    """Finds the anchor of one class in recordings, with an ``AnchorDetector``.

    ``every`` n-th frame is looked at by the detector, the others are followed. ``min_score`` is the least score of a
    detection. ``workers`` threads share the work. Everything that was seen in the last recording is kept, so that a
    search for another anchor in it takes no time, and one that was stopped goes on where it was.
    """

    def __init__(
        self, detector: PictureDetector, *, every: int = 1, min_score: float = 0.3, workers: int | None = None
    ) -> None:
        if not 1 <= every <= MAX_GAP:
            raise ConfigError(f"every = {every} is not allowed; look at every frame (1) up to every {MAX_GAP}th")
        self._detector, self._every, self._min_score, self._workers = detector, every, min_score, workers
        self._seen: _Seen | None = None

    @property
    def names(self) -> Sequence[str]:
        """The kinds of anchor that it knows."""
        return COCO_NAMES

    def find(
        self, recording: Recording, name: str, progress: Progress | None = None, *, chosen: Chosen | None = None
    ) -> dict[int, Detection]:
        """The one anchor called ``name`` by frame index, ascending, ``followed`` where the detector did not see it.

        Where the recording has reference poses, what lies in another direction than the place to which most detections
        point is left out. So are frames in which the lower or upper end of the picture cuts it off, where enough others
        remain.

        ``chosen`` tells it from another one of its kind. Raises ``ConfigError`` for a name that no detector knows,
        ``LearningError`` where it is in fewer than 10 frames, ``InputError`` where there are two, and where most frames
        show one that stands elsewhere than what is chosen.
        """
        if name not in COCO_NAMES:
            raise ConfigError(f"an anchor {name!r} is not known; known are {', '.join(COCO_NAMES)}")
        surroundings, seen = Surroundings(recording), self._seen
        if seen is None or seen.recording is not recording:
            self._seen = seen = _Seen(recording)
        with seen.lock:
            self._look(seen, surroundings, progress)
        detections = {
            index: anchors_among(sightings, name)
            for index, sightings in enumerate(seen.sightings)
            if sightings is not None
        }
        poses = _poses(recording)
        track = _still(one_anchor(detections, np.array(seen.turn_rad), chosen, poses), poses, chosen)
        require_enough(name, len(track))
        filled = fill_gaps(track, _readable(surroundings), surroundings.geometry, len(recording.infos))
        return _whole(filled, surroundings.geometry)

    def _look(self, seen: _Seen, surroundings: Surroundings, progress: Progress | None) -> None:
        """Look at all frames that were not looked at."""
        cuts = near_and_far(surroundings.geometry)

        def look(index: int) -> tuple[Spectrum, list[Sighting]] | None:
            try:
                panorama = surroundings(index)
            except ImageError:
                return None  # a picture that cannot be read shows no anchor
            if index % self._every:
                return horizon_spectrum(panorama), []
            return horizon_spectrum(panorama), look_around(self._detector, cuts, panorama, min_score=self._min_score)

        begin, frames = len(seen.sightings), len(seen.recording.infos)
        if progress is not None and begin:
            progress(begin, frames)
        for index, looked in enumerate(ordered_map(look, range(begin, frames), self._workers), begin):
            turn = seen.turn_rad[-1] if index else 0.0
            if looked is not None:
                turn += 0.0 if seen.last is None else turn_between(seen.last, looked[0])
                seen.last = looked[0]
            seen.turn_rad.append(turn)
            seen.sightings.append(None if looked is None else looked[1])
            if progress is not None:
                progress(index + 1, frames)


def _still(track: dict[int, Detection], poses: FloatArray, chosen: Chosen | None) -> dict[int, Detection]:
    """What stands still in a track; raises ``InputError`` where that is not what was ``chosen``."""
    still = standing_still(track, poses)
    if chosen is not None and chosen.frame in track and chosen.frame not in still:
        raise InputError(
            f"what was chosen in frame {chosen.frame} stands elsewhere than what most of {_frames(len(track))} show; "
            "choose another frame, or drive past it for longer"
        )
    return still


def _whole(track: dict[int, Detection], geometry: PanoramaGeometry) -> dict[int, Detection]:
    """Without the frames in which the picture ends within the anchor: of a part nobody knows how large the whole is.

    A camera that sees nothing below the horizon cuts off anchors in all frames, and alike; those are kept.
    """
    lowest, highest = elevations_rad(geometry)
    whole = {
        index: one
        for index, one in track.items()
        if one.box.low_rad > lowest + _AT_THE_EDGE_RAD and one.box.high_rad < highest - _AT_THE_EDGE_RAD
    }
    return whole if len(whole) >= max(MIN_FRAMES, _WHOLE_SHARE * len(track)) else track


def _poses(recording: Recording) -> FloatArray:
    """(n, 3) reference poses; odometry drifts away from where a thing was seen before."""
    known = Trajectory.of(recording.infos, "reference")
    return np.column_stack([known.xy_m, known.heading_rad])


def _readable(surroundings: Surroundings) -> Callable[[int], ImageArray]:
    """Panoramas where a picture that cannot be read is black, in which every track is lost."""

    def panorama(index: int) -> ImageArray:
        try:
            return surroundings(index)
        except ImageError:
            geometry = surroundings.geometry
            return np.zeros((geometry.height_px, geometry.width_px, 3), np.uint8)

    return panorama


def check_long_enough(recording: Recording) -> None:
    """Raise ``LearningError`` for a recording in which no anchor can be found often enough: before the search."""
    if len(recording.infos) < MIN_FRAMES:
        raise LearningError(
            f"recording {recording.name!r} has {_frames(len(recording.infos))}, an anchor has to be found in at least "
            f"{MIN_FRAMES}; record a drive past it"
        )


def require_enough(name: str, found: int) -> None:
    """Raise ``LearningError`` where an anchor was found in fewer than 10 frames."""
    if not found:
        raise LearningError(
            f"no {name} was found in any frame; put one beside the landmark where the camera sees it whole, or choose "
            "another kind of anchor"
        )
    if found < MIN_FRAMES:
        raise LearningError(
            f"the {name} was found in {_frames(found)} only, at least {MIN_FRAMES} are needed; drive nearer to it, "
            "more slowly, or choose another kind of anchor"
        )


def _frames(count: int) -> str:
    return f"{count} frame{'s' if count != 1 else ''}"
