"""An anchor followed from frame to frame where the detector missed it, and never past a lost track.

Points in the box are tracked with Lucas-Kanade flow, forward and back again; the box moves with the median of those
that return (Kalal, Mikolajczyk and Matas, "Forward-Backward Error", ICPR 2010). A gap between two detections is
followed from both of its ends: where the two agree the box is confirmed, where they do not there is none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import cv2
import numpy as np

from andante.angles import wrapped
from andante.camera import PanoramaGeometry
from andante.data import FloatArray, ImageArray
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.turning import horizon_spectrum, turn_between

MAX_GAP = 30
"""Frames between two detections beyond which what is between is not followed."""
UNCONFIRMED = 4
"""Frames that a track may lead away from a detection without another one that confirms it."""

_MARGIN_RAD = 0.6
_MOST_POINTS, _FEWEST_POINTS = 80, 8
_LEAST_RETURNING = 0.4
_RETURN_PX = 1.0
_WINDOW_PX = 15
_MOST_GROWTH = 1.5
_AGREEING_IOU = 0.4
_FADING = 0.97  # of the score, from frame to frame


class Follower:
    """Moves boxes from one panorama (H, W[, 3]) of a geometry to the next."""

    def __init__(self, geometry: PanoramaGeometry) -> None:
        self._geometry = geometry
        self._px_per_rad = geometry.width_px / (2.0 * np.pi)
        self._row_px_per_rad = geometry.height_px / np.radians(geometry.max_deg - geometry.min_deg)
        self._top_rad = float(np.radians(geometry.max_deg))

    def step(self, before: ImageArray, after: ImageArray, box: Box) -> Box | None:
        """Where the thing in ``box`` has gone; ``None`` where the track is lost."""
        turn = turn_between(horizon_spectrum(before), horizon_spectrum(after))
        reach = int(min(box.width_rad / 2.0 + _MARGIN_RAD, np.pi) * self._px_per_rad)
        middle = self._column(box.azimuth_rad)
        shift = round(turn * self._px_per_rad)
        first, second = (_window(panorama, at, reach) for panorama, at in ((before, middle), (after, middle + shift)))
        corners = self._in_window(box, middle, reach)
        moved = _flow(first, second, corners)
        if moved is None:
            return None
        start, end = moved
        offset = np.median(end - start, axis=0)
        growth = _growth(start, end)
        if not 1.0 / _MOST_GROWTH < growth < _MOST_GROWTH:
            return None
        stepped = Box(
            -wrapped((shift + offset[0]) / self._px_per_rad - box.azimuth_rad),
            box.elevation_rad - offset[1] / self._row_px_per_rad,
            min(box.width_rad * growth, 2.0 * np.pi),
            box.height_rad * growth,
        )
        return stepped if self._shows(stepped) else None

    def _column(self, azimuth_rad: float) -> int:
        return round((np.pi - azimuth_rad) * self._px_per_rad - 0.5)

    def _in_window(self, box: Box, middle: int, reach: int) -> tuple[int, int, int, int]:
        """Left, top, right, bottom of a box in a window around column ``middle``."""
        left = (np.pi - box.left_rad) * self._px_per_rad - middle + reach
        top = (self._top_rad - box.high_rad) * self._row_px_per_rad
        width, height = box.width_rad * self._px_per_rad, box.height_rad * self._row_px_per_rad
        return round(left), max(round(top), 0), round(left + width), min(round(top + height), self._geometry.height_px)

    def _shows(self, box: Box) -> bool:
        """Whether at least half of a box is in the panorama."""
        low = max(box.low_rad, float(np.radians(self._geometry.min_deg)))
        return min(box.high_rad, self._top_rad) - low > box.height_rad / 2.0


def fill_gaps(
    detections: Mapping[int, Detection],
    panorama: Callable[[int], ImageArray],
    geometry: PanoramaGeometry,
    frames: int,
    *,
    max_gap: int = MAX_GAP,
) -> dict[int, Detection]:
    """Detections of one thing by frame of ``frames``, and those followed into the frames between, in order.

    ``panorama`` gives a frame's picture and may raise ``ImageError``.
    """
    follower = Follower(geometry)
    found = dict(detections)
    known = sorted(detections)
    for before, after in zip([None, *known], [*known, None], strict=True):
        if before is not None and after is not None and after - before <= max_gap + 1:
            found |= _bridged(follower, panorama, (before, detections[before]), (after, detections[after]))
            continue
        if before is not None:
            end = min(before + UNCONFIRMED, frames - 1 if after is None else after - 1)
            found |= _led(follower, panorama, detections[before], range(before, end + 1))
        if after is not None:
            begin = max(after - UNCONFIRMED, 0 if before is None else before + 1)
            found |= {
                index: one
                for index, one in _led(follower, panorama, detections[after], range(after, begin - 1, -1)).items()
                if index not in found
            }
    return dict(sorted(found.items()))


def _led(
    follower: Follower, panorama: Callable[[int], ImageArray], start: Detection, frames: range
) -> dict[int, Detection]:
    """A detection in the first of ``frames`` followed through the others, as far as the track holds."""
    led: dict[int, Detection] = {}
    box, here = start.box, panorama(frames[0]) if len(frames) > 1 else None
    for number, index in enumerate(frames[1:], 1):
        there = panorama(index)
        moved = None if here is None else follower.step(here, there, box)
        if moved is None:
            break
        box, here = moved, there
        led[index] = replace(start, box=box, score=start.score * _FADING**number, followed=True)
    return led


def _bridged(
    follower: Follower,
    panorama: Callable[[int], ImageArray],
    begin: tuple[int, Detection],
    end: tuple[int, Detection],
) -> dict[int, Detection]:
    """What lies between two detections: the mean of both tracks where they agree, each alone only close to its own."""
    (first, before), (last, after) = begin, end
    if last - first < 2:
        return {}
    cached = {index: panorama(index) for index in range(first, last + 1)}
    forward = _led(follower, cached.__getitem__, before, range(first, last))
    backward = _led(follower, cached.__getitem__, after, range(last, first, -1))
    bridged: dict[int, Detection] = {}
    for index in range(first + 1, last):
        ahead, back = forward.get(index), backward.get(index)
        if ahead is not None and back is not None:
            if ahead.box.iou(back.box) >= _AGREEING_IOU:
                share = (index - first) / (last - first)
                bridged[index] = replace(
                    ahead, box=_between(ahead.box, back.box, share), score=max(ahead.score, back.score)
                )
        elif ahead is not None and index - first <= UNCONFIRMED:
            bridged[index] = ahead
        elif back is not None and last - index <= UNCONFIRMED:
            bridged[index] = back
    return bridged


def _between(first: Box, second: Box, share: float) -> Box:
    """The box that is ``share`` of the way from one to another."""
    turn = wrapped(second.azimuth_rad - first.azimuth_rad)
    return Box(
        -wrapped(-first.azimuth_rad - share * turn),
        first.elevation_rad + share * (second.elevation_rad - first.elevation_rad),
        first.width_rad + share * (second.width_rad - first.width_rad),
        first.height_rad + share * (second.height_rad - first.height_rad),
    )


def _window(panorama: ImageArray, middle: int, reach: int) -> ImageArray:
    """Grey columns ``middle - reach`` to ``middle + reach``, across the seam."""
    columns = np.mod(np.arange(middle - reach, middle + reach + 1), panorama.shape[1])
    part = np.take(panorama, columns, axis=1)
    return part if part.ndim == 2 else np.asarray(cv2.cvtColor(part, cv2.COLOR_BGR2GRAY), np.uint8)


def _flow(
    first: ImageArray, second: ImageArray, corners: tuple[int, int, int, int]
) -> tuple[FloatArray, FloatArray] | None:
    """Points (k, 2) in the box of the first picture and where they are in the second; ``None`` where too few return."""
    left, top, right, bottom = corners
    mask = np.zeros(first.shape, np.uint8)
    mask[top:bottom, max(left, 0) : max(right, 0)] = 255
    start = cv2.goodFeaturesToTrack(first, _MOST_POINTS, 0.01, 3, mask=mask)
    if start is None or len(start) < _FEWEST_POINTS:
        return None
    size = (_WINDOW_PX, _WINDOW_PX)
    end, there, _ = cv2.calcOpticalFlowPyrLK(first, second, start, start.copy(), winSize=size, maxLevel=3)
    again, back, _ = cv2.calcOpticalFlowPyrLK(second, first, end, end.copy(), winSize=size, maxLevel=3)
    off = np.linalg.norm((again - start).reshape(-1, 2), axis=1)
    returned = (there.reshape(-1) > 0) & (back.reshape(-1) > 0) & (off < _RETURN_PX)
    if returned.sum() < max(_FEWEST_POINTS, _LEAST_RETURNING * len(start)):
        return None
    return start.reshape(-1, 2)[returned].astype(np.float64), end.reshape(-1, 2)[returned].astype(np.float64)


def _growth(start: FloatArray, end: FloatArray) -> float:
    """By how much points (k, 2) spread: the median over all pairs that are not close to each other."""
    upper = np.triu_indices(len(start), 1)
    before = np.linalg.norm(start[upper[0]] - start[upper[1]], axis=1)
    after = np.linalg.norm(end[upper[0]] - end[upper[1]], axis=1)
    apart = before > 4.0
    return float(np.median(after[apart] / before[apart])) if apart.any() else 1.0
