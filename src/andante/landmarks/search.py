"""One anchor through all frames of a recording: detected, outliers removed, followed where it was missed."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from andante.data import FloatArray, ImageArray, Trajectory
from andante.errors import ConfigError, ImageError, LearningError
from andante.landmarks.anchors import PictureDetector, find_anchors, near_and_far
from andante.landmarks.boxes import Detection
from andante.landmarks.coco_names import COCO_NAMES
from andante.landmarks.following import MAX_GAP, fill_gaps
from andante.landmarks.surroundings import Surroundings
from andante.landmarks.tracks import Chosen, one_anchor
from andante.landmarks.turning import Spectrum, horizon_spectrum, turn_between
from andante.protocols import Recording
from andante.recordings import ordered_map

MIN_FRAMES = 10
"""An anchor seen in fewer frames teaches nothing."""

Progress = Callable[[int, int], None]
"""Called with frames searched and frames in all."""


class AnchorSearch:
    """Finds the anchor of one class in recordings, with an ``AnchorDetector``.

    ``every`` n-th frame is looked at by the detector, the others are followed. ``min_score`` is the least score of a
    detection. ``workers`` threads share the work.
    """

    def __init__(
        self, detector: PictureDetector, *, every: int = 1, min_score: float = 0.3, workers: int | None = None
    ) -> None:
        if not 1 <= every <= MAX_GAP:
            raise ConfigError(f"every = {every} is not allowed; look at every frame (1) up to every {MAX_GAP}th")
        self._detector, self._every, self._min_score, self._workers = detector, every, min_score, workers

    @property
    def names(self) -> Sequence[str]:
        """The kinds of anchor that it knows."""
        return COCO_NAMES

    def find(
        self, recording: Recording, name: str, progress: Progress | None = None, *, chosen: Chosen | None = None
    ) -> dict[int, Detection]:
        """The one anchor called ``name`` by frame index, ascending, ``followed`` where the detector did not see it.

        ``chosen`` tells it from another one of its kind. Raises ``ConfigError`` for a name that no detector knows,
        ``LearningError`` where it is in fewer than 10 frames, ``InputError`` where there are two.
        """
        if name not in COCO_NAMES:
            raise ConfigError(f"an anchor {name!r} is not known; known are {', '.join(COCO_NAMES)}")
        surroundings = Surroundings(recording)
        cuts = near_and_far(surroundings.geometry)

        def look(index: int) -> tuple[Spectrum, list[Detection]] | None:
            try:
                panorama = surroundings(index)
            except ImageError:
                return None  # a picture that cannot be read shows no anchor
            if index % self._every:
                return horizon_spectrum(panorama), []
            found = find_anchors(self._detector, cuts, panorama, name, min_score=self._min_score)
            return horizon_spectrum(panorama), found

        frames = len(recording.infos)
        detections: dict[int, list[Detection]] = {}
        turn_rad = np.zeros(frames)
        last: Spectrum | None = None
        for index, seen in enumerate(ordered_map(look, range(frames), self._workers)):
            turn_rad[index] = turn_rad[max(index - 1, 0)]
            if seen is not None:
                spectrum, detections[index] = seen
                turn_rad[index] += 0.0 if last is None else turn_between(last, spectrum)
                last = spectrum
            if progress is not None:
                progress(index + 1, frames)
        track = one_anchor(detections, turn_rad, chosen, _poses(recording))
        require_enough(name, len(track))
        return fill_gaps(track, _readable(surroundings), surroundings.geometry, frames)


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
