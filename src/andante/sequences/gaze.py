"""Edges along which the point that is looked at changes slowly and the place of the robot fast (thesis 7.6.1).

A panorama is cut into regions all around. While the robot drives on, its gaze stays on one thing: the region that shows
the thing now belongs together with the one that shows it a little later, or on another day from the same place. Then
the gaze steps to the neighbouring region, until the whole horizon is covered. The thesis follows one region with a
tracker, which drifts; here it is known, at least roughly, where the thing stands that a region shows (a plane sweep
tells), and with it the direction in which any other frame sees it. No chain is followed, so nothing adds up.

Samples are regions of frames: region k of frame f of K regions is number f K + k. Directions are those of panoramas at
heading zero: region k looks at azimuth pi - 2 pi (k + 0.5) / K, counter-clockwise from x.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.spatial import KDTree

from andante.data import Edges, FloatArray, IndexArray
from andante.errors import ArrayError, ConfigError


def region_azimuths(regions: int) -> FloatArray:
    """(regions,) where the middles of regions look, counter-clockwise from x, falling from left to right."""
    azimuths: FloatArray = np.pi - 2 * np.pi * (np.arange(regions) + 0.5) / regions
    return azimuths


def region_towards(xy_m: FloatArray, point_m: FloatArray, regions: int) -> IndexArray:
    """Which region looks from positions (..., 2) at points (..., 2); both have to be known."""
    towards = np.asarray(point_m) - xy_m
    azimuth = np.arctan2(towards[..., 1], towards[..., 0])
    return np.rint((np.pi - azimuth) * (regions / (2 * np.pi)) - 0.5).astype(np.int64) % regions


def gaze_edges(
    xy_m: ArrayLike,
    gaze_m: ArrayLike,
    session: ArrayLike,
    *,
    strides: Sequence[int] = (1,),
    radius_m: float = 0.0,
    step_weight: float = 0.3,
) -> Edges:
    """Edges over the regions of frames: gazes that stay while the robot moves, and those that step to the neighbour.

    ``xy_m`` (n, 2) are positions in one common frame, ``gaze_m`` (n, K, 2) the points that regions look at, NaN where
    unknown: from such a region no gaze is followed. ``session`` (n,) numbers the recordings, whose frames follow each
    other. A gaze is followed over each number of frames in ``strides``: the longer these are, the faster the position
    changes against the gaze. It is followed as well to the nearest frame of every other session that is at most
    ``radius_m`` away; all such edges weigh 1. Every region is joined with its neighbour to the right in the same frame
    by an edge of ``step_weight``; 0 leaves these out. Raises ``ArrayError`` for other shapes, ``ConfigError`` for a
    stride, radius or weight out of range.
    """
    xy, gaze, numbers = (np.asarray(xy_m, np.float64), np.asarray(gaze_m, np.float64), np.asarray(session))
    _check(xy, gaze, numbers)
    if any(stride < 1 for stride in strides):
        raise ConfigError(f"strides={tuple(strides)}: a gaze is followed over 1 frame or more")
    if not 0 <= radius_m < np.inf:
        raise ConfigError(f"radius_m={radius_m}: has to be a finite distance >= 0 m; 0 joins no sessions")
    if not 0 <= step_weight < np.inf:
        raise ConfigError(f"step_weight={step_weight}: has to be a finite number >= 0")
    pairs = [*_along(numbers, strides), *(_across(xy, numbers, radius_m) if radius_m else ())]
    followed = [_followed(xy, gaze, first, second) for first, second in pairs]
    return Edges.joined([*followed, _steps(gaze.shape[0], gaze.shape[1], step_weight)])


def _check(xy: FloatArray, gaze: FloatArray, session: NDArray[np.generic]) -> None:
    n = len(xy)
    if xy.ndim != 2 or xy.shape[1] != 2 or not np.isfinite(xy).all():
        raise ArrayError(f"xy_m has to hold one known position per frame (n, 2), got shape {xy.shape}")
    if gaze.ndim != 3 or gaze.shape[0] != n or gaze.shape[1] < 2 or gaze.shape[2] != 2:
        raise ArrayError(
            f"gaze_m has to hold a point for each of two or more regions of every frame ({n}, K, 2), "
            f"got shape {gaze.shape}"
        )
    if session.shape != (n,):
        raise ArrayError(f"session has shape {session.shape}, but there are {n} frames: one number per frame")


def _along(session: NDArray[np.generic], strides: Sequence[int]) -> Iterator[tuple[IndexArray, IndexArray]]:
    """Frames and those that come so many later in the same drive."""
    for stride in strides:
        first = np.arange(max(0, len(session) - stride))
        first = first[session[first] == session[first + stride]]
        yield first, first + stride


def _across(xy: FloatArray, session: NDArray[np.generic], radius_m: float) -> Iterator[tuple[IndexArray, IndexArray]]:
    """Frames and the nearest ones of every other drive."""
    drives = [np.flatnonzero(session == one) for one in np.unique(session)]
    for number, others in enumerate(drives):
        frames = np.concatenate([np.empty(0, np.int64), *drives[:number], *drives[number + 1 :]])
        if len(frames):
            distance, found = KDTree(xy[others]).query(xy[frames])
            near = np.asarray(distance) <= radius_m
            yield frames[near], others[np.asarray(found)[near]]


def _followed(xy: FloatArray, gaze: FloatArray, first: IndexArray, second: IndexArray) -> Edges:
    """From every region of the ``first`` frames to the one of the ``second`` that looks at the same point."""
    regions = gaze.shape[1]
    frame, region = np.nonzero(np.isfinite(gaze[first]).all(axis=2))
    seen = region_towards(xy[second[frame]], gaze[first[frame], region], regions)
    return Edges.between(first[frame] * regions + region, second[frame] * regions + seen)


def _steps(frames: int, regions: int, weight: float) -> Edges:
    number = np.arange(frames * regions).reshape(frames, regions)
    if not weight:
        number = number[:0]
    return Edges.between(number.ravel(), np.roll(number, -1, axis=1).ravel(), weight)
