"""How well a gaze stays on a thing while the robot drives, against the simulator, which knows where things are."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.camera.rays import project_held
from andante.data import FloatArray, IndexArray
from andante.evaluation.experiments.outcome import Cell, Table
from andante.features import PatchEncoder
from andante.mapping.gaze_lesson import GazeDrive
from andante.sequences.gaze import region_azimuths
from andante.simulator import SimulatedRecording

WAYS_M = (1.0, 3.0, 10.0)
"""Along the drive, after which it is looked whether the gaze is still on its thing."""
SWEEP, CHAIN, CONSTANT = "plane sweep", "from frame to frame", "everything 6 m away"
_STARTS = 10
_CONSTANT_M = 6.0
_ELEVATIONS = np.radians(np.linspace(3, 35, 33))
_ASIDE = np.radians([-1.0, -0.5, 0.0, 0.5, 1.0])
_SAME = 0.1
_LEAST_ROWS = 3
_SEARCH = np.radians(np.arange(-9.0, 9.1, 0.6))


@dataclass(frozen=True, eq=False)
class TrueSight:
    """What the simulator knows of a drive at ``poses`` (n, 3): how far away what is seen of it stands."""

    recording: SimulatedRecording
    poses: FloatArray

    def distances(self, frame: int, azimuth: FloatArray) -> FloatArray:
        """(m,) horizontal metres to the object that fills most of each direction (m,); NaN for the sky."""
        away, ids = self._seen(frame, azimuth[:, None] + _ASIDE)
        found = np.full(len(azimuth), np.nan)
        for row, (far, what) in enumerate(
            zip(away.reshape(len(azimuth), -1), ids.reshape(len(azimuth), -1), strict=True)
        ):
            solid = np.isfinite(far)
            if solid.sum() >= _LEAST_ROWS * len(_ASIDE):
                kinds, count = np.unique(what[solid], return_counts=True)
                found[row] = np.median(far[solid & (what == kinds[count.argmax()])])
        return found

    def visible(self, frame: int, points: FloatArray) -> NDArray[np.bool_]:
        """Whether points (m, 2) in the plane are seen from a frame, and nothing stands before them."""
        towards = points - self.poses[frame, :2]
        away, _ = self._seen(frame, np.arctan2(towards[:, 1], towards[:, 0])[:, None])
        same = np.abs(np.log(away[:, 0] / np.linalg.norm(towards, axis=1)[:, None])) < _SAME
        return np.asarray(same.sum(axis=1) >= _LEAST_ROWS, dtype=np.bool_)

    def _seen(self, frame: int, azimuth: FloatArray) -> tuple[FloatArray, IndexArray]:
        """Horizontal distances and object ids (..., rows) in directions (...) of the world."""
        range_m, ids = _rendered(self.recording, frame)
        camera = self.recording.camera
        x, y, _ = project_held(camera, azimuth[..., None] - self.poses[frame, 2], _ELEVATIONS, 1.0)
        rows, columns = np.rint(y).astype(np.intp), np.rint(x).astype(np.intp)
        return range_m[rows, columns] * np.cos(_ELEVATIONS), ids[rows, columns].astype(np.int64)


@lru_cache(maxsize=2)
def _rendered(recording: SimulatedRecording, frame: int) -> tuple[FloatArray, NDArray[np.int32]]:
    rendering = recording.rendering(frame)
    return rendering.range_m.astype(np.float64), rendering.object_id


def following_errors(
    drive: GazeDrive, encoder: PatchEncoder, sight: TrueSight
) -> Mapping[str, Mapping[float, FloatArray]]:
    """By tracker and way: errors (m,) in degrees of where regions of some frames are expected in later ones.

    Only what is still visible counts.
    """
    xy, regions = drive.poses[:, :2], drive.distance_m.shape[1]
    azimuth = region_azimuths(regions)
    towards = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
    travelled = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(xy, axis=0), axis=1))])
    last = int(np.searchsorted(travelled, travelled[-1] - max(WAYS_M)))
    found: dict[str, dict[float, list[FloatArray]]] = {
        name: {way: [] for way in WAYS_M} for name in (SWEEP, CHAIN, CONSTANT)
    }
    for start in np.linspace(0, max(0, last - 1), _STARTS).astype(int).tolist():
        ends = [int(np.searchsorted(travelled, travelled[start] + way)) for way in WAYS_M]
        ends = [min(end, len(xy) - 1) for end in ends]
        chained = followed_by_sight(drive, encoder, start, ends)
        points = xy[start] + sight.distances(start, azimuth)[:, None] * towards
        for way, end in zip(WAYS_M, ends, strict=True):
            true = _direction(points, xy[end])
            judged = np.isfinite(true)
            judged[judged] = sight.visible(end, points[judged])
            expected = {
                SWEEP: _direction(xy[start] + drive.distance_m[start][:, None] * towards, xy[end]),
                CHAIN: chained[end],
                CONSTANT: _direction(xy[start] + _CONSTANT_M * towards, xy[end]),
            }
            # Where the sweep has no idea, no gaze is followed; all are compared on what it does follow.
            judged &= np.isfinite(expected[SWEEP])
            for name, direction in expected.items():
                found[name][way].append(np.degrees(np.abs(wrapped(direction[judged] - true[judged]))))
    return {name: {way: np.concatenate(parts) for way, parts in ways.items()} for name, ways in found.items()}


def followed_by_sight(
    drive: GazeDrive, encoder: PatchEncoder, start: int, ends: Sequence[int]
) -> dict[int, FloatArray]:
    """Directions (K,) in which a tracker that goes from frame to frame believes the regions of ``start``, by frame."""
    at = region_azimuths(drive.distance_m.shape[1])
    found = {start: at}
    shown = encoder.cut(drive.fields[start : start + 1], (at - drive.poses[start, 2])[None])[0]
    for frame in range(start + 1, max(ends) + 1):
        tried = at[:, None] + _SEARCH
        patches = encoder.cut(drive.fields[frame : frame + 1], (tried.ravel() - drive.poses[frame, 2])[None])
        patches = patches.reshape(*tried.shape, -1)
        best = np.einsum("ksd,kd->ks", patches, shown).argmax(axis=1)
        at, shown = tried[np.arange(len(at)), best], patches[np.arange(len(at)), best]
        found[frame] = at
    return {end: found[end] for end in ends}


def following_table(errors: Mapping[str, Mapping[float, FloatArray]]) -> Table:
    """Medians and 90 % of the errors."""
    columns = ("tracker", *(f"{what} after {way:g} m [deg]" for way in WAYS_M for what in ("median", "90 %")), "gazes")
    rows = list[tuple[Cell, ...]]()
    for name, ways in errors.items():
        values = [_quantile(ways[way], share) for way in WAYS_M for share in (0.5, 0.9)]
        rows.append((name, *values, sum(map(len, ways.values()))))
    return Table("Where a gaze is expected, against the simulator's own distances", columns, tuple(rows))


def _direction(points: FloatArray, xy: FloatArray) -> FloatArray:
    towards = points - xy
    direction: FloatArray = np.arctan2(towards[:, 1], towards[:, 0])
    return direction


def _quantile(values: FloatArray, share: float) -> float | None:
    return float(np.quantile(values, share)) if len(values) else None
