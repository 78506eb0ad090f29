"""Bounding boxes of what is seen, also across the seam of a panorama, and their table."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import find_objects

_SURROUNDINGS = ("ground", "hills", "path")
COLUMNS = ("frame", "object", "x_min", "y_min", "x_max", "y_max", "pixels", "seam")


@dataclass(frozen=True, slots=True)
class ObjectBox:
    """An object's extent in a picture, whole pixels, both ends included; ``pixels`` of it are visible.

    Where an object crosses the seam of a panorama there is one box for each side of the picture, both with ``seam``.
    """

    name: str
    x_min: int
    y_min: int
    x_max: int
    y_max: int
    pixels: int
    seam: bool = False


def object_boxes(
    object_id: NDArray[np.int32], names: Sequence[str], *, wraps: bool, min_pixels: int = 8
) -> list[ObjectBox]:
    """Boxes of all objects in an id picture (height, width) of which at least ``min_pixels`` are seen.

    ``wraps`` says that the right edge of the picture continues at the left one. Ground, hills and path have none.
    """
    found: list[ObjectBox] = []
    for number, window in enumerate(find_objects(object_id + 1)):
        if window is None or names[number].rstrip("0123456789") in _SURROUNDINGS:
            continue
        mask = object_id[window] == number
        if int(mask.sum()) < min_pixels:
            continue
        left, top = window[1].start, window[0].start
        for low, high, seam in _spans(mask.any(axis=0), wraps and left == 0 and window[1].stop == object_id.shape[1]):
            part = mask[:, low:high]
            rows = np.flatnonzero(part.any(axis=1))
            extent = left + low, top + int(rows[0]), left + high - 1, top + int(rows[-1])
            found.append(ObjectBox(names[number], *extent, int(part.sum()), seam))
    return found


def _spans(columns: NDArray[np.bool_], at_both_edges: bool) -> list[tuple[int, int, bool]]:
    """Ranges of columns [low, high) that an object fills: two where it crosses the seam."""
    empty = np.flatnonzero(~columns)
    if not at_both_edges or not len(empty):
        return [(0, len(columns), False)]
    runs = np.split(empty, np.flatnonzero(np.diff(empty) > 1) + 1)
    widest = max(runs, key=len)
    return [(0, int(widest[0]), True), (int(widest[-1]) + 1, len(columns), True)]


def boxes_csv(boxes: Iterable[tuple[int, ObjectBox]]) -> str:
    """The text of a table with the boxes of many frames."""
    text = io.StringIO()
    rows = csv.writer(text, lineterminator="\n")
    rows.writerow(COLUMNS)
    for frame, box in boxes:
        rows.writerow((frame, box.name, box.x_min, box.y_min, box.x_max, box.y_max, box.pixels, int(box.seam)))
    return text.getvalue()
