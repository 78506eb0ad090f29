"""A picture of a landmark in many frames, for a person to approve."""

from __future__ import annotations

import math

import cv2
import numpy as np

from andante.data import ImageArray
from andante.landmarks.boxes import Box
from andante.landmarks.surroundings import Surroundings
from andante.landmarks.teaching import Lesson, spread
from andante.landmarks.windows import elevations_rad, window
from andante.protocols import Recording

WINDOW_RAD = math.radians(110.0)
"""How much of the horizon a tile shows."""
_TILE_PX = 320
_CAPTION_PX = 22
_COLUMNS = 4
_GAP_PX = 8
_INK, _PAPER, _MARK = (40, 36, 32), (255, 255, 255), (182, 89, 0)  # BGR


def contact_sheet(recording: Recording, surroundings: Surroundings, lesson: Lesson, count: int = 24) -> ImageArray:
    """BGR picture of at most ``count`` tiles, one a frame, each with the landmark's box in its middle."""
    tiles = [
        _tile(recording, surroundings, index, lesson.boxes[index]) for index in spread(sorted(lesson.boxes), count)
    ]
    height, width = tiles[0].shape[0] + _GAP_PX, tiles[0].shape[1] + _GAP_PX
    rows = math.ceil(len(tiles) / _COLUMNS)
    sheet = np.full((rows * height + _GAP_PX, min(_COLUMNS, len(tiles)) * width + _GAP_PX, 3), _PAPER, np.uint8)
    for number, tile in enumerate(tiles):
        top, left = _GAP_PX + number // _COLUMNS * height, _GAP_PX + number % _COLUMNS * width
        sheet[top : top + tile.shape[0], left : left + tile.shape[1]] = tile
    return sheet


def _tile(recording: Recording, surroundings: Surroundings, index: int, box: Box) -> ImageArray:
    lowest, highest = elevations_rad(surroundings.geometry)
    part = window(surroundings(index), box.azimuth_rad, WINDOW_RAD)
    height = round(_TILE_PX * (highest - lowest) / WINDOW_RAD)
    picture = cv2.resize(part, (_TILE_PX, height), interpolation=cv2.INTER_AREA)
    scale = _TILE_PX / WINDOW_RAD
    across, down = box.width_rad / 2 * scale, box.height_rad / 2 * scale
    x, y = _TILE_PX / 2, (highest - box.elevation_rad) * scale
    corners = (round(x - across), round(y - down)), (round(x + across), round(y + down))
    for colour, thickness in ((_PAPER, 4), (_MARK, 2)):
        cv2.rectangle(picture, *corners, colour, thickness, cv2.LINE_AA)
    caption = np.full((_CAPTION_PX, _TILE_PX, 3), _PAPER, np.uint8)
    text = f"frame {index}   {recording.infos[index].timestamp_s - recording.infos[0].timestamp_s:.1f} s"
    cv2.putText(caption, text, (2, 16), cv2.FONT_HERSHEY_SIMPLEX, 0.45, _INK, 1, cv2.LINE_AA)
    return np.concatenate([np.asarray(picture, np.uint8), caption])
