"""What a landmark detector learns from: panoramas, where the landmarks are in them, and what is kept to judge it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.camera import with_found_circle
from andante.data import FloatArray, Frame, ImageArray, IndexArray
from andante.errors import InputError
from andante.landmarks.heatmaps import Grid
from andante.landmarks.labels import Labels, names_of, require_usable
from andante.landmarks.panoramas import PanoramaMaker
from andante.protocols import Recording
from andante.recordings import map_frames

Progress = Callable[[str, int, int], None]
"""Called with what is done, how much of it is done, and of how much."""

Taught = Sequence[tuple[Recording, Sequence[Labels]]]
"""Recordings, each with the labels of its landmarks."""


@dataclass(frozen=True, slots=True)
class Examples:
    """n panoramas and what is known of k landmarks in them.

    ``panoramas`` (n, height, width, 3) uint8 BGR, ``cells`` (n, k, 4) boxes in cells of the heat map or NaN where the
    landmark is not, ``known`` (n, k) whether that is known at all, ``source`` (n,) the recording, by number, and
    ``anchors`` (n, k, 4) the boxes in cells of what each landmark was taught with, NaN where that is not in view.
    """

    panoramas: ImageArray
    cells: FloatArray
    known: NDArray[np.bool_]
    source: IndexArray
    anchors: FloatArray

    def __len__(self) -> int:
        return len(self.panoramas)

    def chosen(self, rows: NDArray[np.bool_] | IndexArray) -> Examples:
        """Some of the rows."""
        return Examples(self.panoramas[rows], self.cells[rows], self.known[rows], self.source[rows], self.anchors[rows])

    @property
    def present(self) -> NDArray[np.bool_]:
        """(n, k) where a landmark has a box."""
        return np.asarray(np.isfinite(self.cells[..., 0]), np.bool_)


_BLOCKS = 5


def gathered(
    taught: Taught,
    elsewhere: Sequence[Recording],
    grid: Grid,
    *,
    most: int = 500,
    least: int = 20,
    progress: Progress | None = None,
) -> tuple[list[str], Examples]:
    """The names of the landmarks and all examples of them.

    At most ``most`` labels of a landmark in a recording are used, evenly over the drive, and at least ``least`` are
    asked for. Recordings ``elsewhere`` show none of the landmarks; up to a quarter of ``most`` frames of each are used.
    Raises ``InputError`` for labels that do not fit, ``RecordingError`` for pictures that cannot be read.
    """
    names = names_of(one for _, labels in taught for one in labels)
    if not names:
        raise InputError("there are no labels to learn from; teach a landmark first")
    asked = [
        (recording, _by_frame(recording, labels, names, grid, most=most, least=least)) for recording, labels in taught
    ]
    absent = _Known(np.full((len(names), 4), np.nan), np.ones(len(names), np.bool_), np.full((len(names), 4), np.nan))
    for recording in elsewhere:
        frames = _evenly(range(len(recording.infos)), most // 4)
        asked.append((recording, dict.fromkeys(frames, absent)))
    total = sum(len(found) for _, found in asked)
    panoramas, known, source = [], [], []
    for number, (recording, found) in enumerate(asked):
        for frame, panorama in _panoramas(recording, sorted(found), grid):
            panoramas.append(panorama)
            known.append(found[frame])
            source.append(number)
            if progress is not None:
                progress("read", len(panoramas), total)
    return names, Examples(
        np.array(panoramas),
        np.array([one.cells for one in known]),
        np.array([one.known for one in known]),
        np.array(source, np.int64),
        np.array([one.anchors for one in known]),
    )


def divided(examples: Examples, share: float) -> tuple[Examples, Examples]:
    """Examples to learn from, and those that are held out: blocks of every drive, and nothing that borders on them.

    Frames that follow each other look alike, so that random ones would judge a detector by what it has learnt. For
    every landmark and recording a ``share`` of its frames is held out, in five blocks: of a thing that is passed once,
    one block would be all that was ever seen of a side. A twentieth as many frames around each are left to nobody.
    """
    held, near = np.zeros(len(examples), np.bool_), np.zeros(len(examples), np.bool_)
    for source in np.unique(examples.source):
        mine = examples.source == source
        for landmark in range(examples.known.shape[1]):
            rows = np.flatnonzero(mine & examples.present[:, landmark])
            if not len(rows):  # a recording from elsewhere, or of another landmark
                rows = np.flatnonzero(mine & examples.known[:, landmark])
            count = round(share * len(rows))
            blocks = min(_BLOCKS, count)
            gap = count // 20
            for part, block in zip(np.array_split(rows, max(blocks, 1)), range(blocks), strict=False):
                size = count // blocks + (block < count % blocks)
                start = (len(part) - size) // 2
                held[part[start : start + size]] = True
                near[part[max(start - gap, 0) : start + size + gap]] = True
    return examples.chosen(~(held | near)), examples.chosen(held)


@dataclass(frozen=True, slots=True)
class _Known:
    """What is known of one frame: a row of ``Examples``."""

    cells: FloatArray
    known: NDArray[np.bool_]
    anchors: FloatArray


def _by_frame(
    recording: Recording, labels: Sequence[Labels], names: Sequence[str], grid: Grid, *, most: int, least: int
) -> dict[int, _Known]:
    """What is known of all landmarks, by frame."""
    geometry, count = grid.geometry, len(names)
    found: dict[int, _Known] = {}
    for one in labels:
        require_usable(one, recording, geometry.min_deg, geometry.max_deg, least=least)
        for frame in (*_evenly(sorted(one.boxes), most), *_evenly(sorted(one.absent), most // 2)):
            nothing = _Known(np.full((count, 4), np.nan), np.zeros(count, np.bool_), np.full((count, 4), np.nan))
            row, landmark = found.setdefault(frame, nothing), names.index(one.name)
            row.cells[landmark], row.anchors[landmark] = grid.cells_of([one.boxes.get(frame), one.anchors.get(frame)])
            row.known[landmark] = True
    return found


def _panoramas(recording: Recording, frames: Sequence[int], grid: Grid) -> list[tuple[int, ImageArray]]:
    if not frames:
        return []
    first = recording.load(recording.infos[frames[0]], colour=True)
    make = PanoramaMaker(with_found_circle(recording.camera, first), first.shape, grid.geometry)

    def work(frame: Frame) -> ImageArray:
        return make(frame.image)

    return [(info.index, panorama) for info, panorama in map_frames(recording, work, frames, colour=True)]


def _evenly(frames: Sequence[int], most: int) -> list[int]:
    """At most so many of them, evenly spread."""
    if len(frames) <= most:
        return list(frames)
    return [frames[round(position)] for position in np.linspace(0, len(frames) - 1, most)]
