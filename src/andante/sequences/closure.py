"""A drive along a border that comes back to where it began: its drift taken out.

After Einecke et al. (2018), who close the loop of a boundary wire by its heading first. Here the most likely path is
found (``pose_graph``) instead of spreading the error over the turns, which on simulated drives halves the error of
heading (``benchmarks/closure.py``).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from andante.angles import wrapped
from andante.data import FloatArray, IndexArray
from andante.errors import ArrayError, ConfigError, RecordingError
from andante.sequences.pose_graph import Closures, DriftNoise, Steps, fit_path

_CLOSURE_M, _CLOSURE_RAD = 0.05, 0.03
"""How exactly a robot on a wire is where it was before: half a frame along, a few centimetres across."""
_CORRELATION = 2.5
_FRAME_S = 0.2
"""Time from frame to frame where there are no time stamps: only the share of the gyro bias depends on it."""


@dataclass(frozen=True, slots=True)
class ClosedLoop:
    """A drive whose ends meet: ``poses`` (n, 3) x, y in metres and heading in radians, unwrapped.

    Beside it how far the ends were from meeting, for a person to judge: ``heading_error_rad`` is how much too far
    counter-clockwise odometry turned until the closure (the median of several), ``position_error_m`` its gap there,
    and ``remaining_error_m`` the gap after a constant gyro bias has been taken out, which is what is compared with the
    ``length_m`` driven. ``turns`` is the number of full turns between start and end, counter-clockwise positive;
    ``gyro_bias_rad_s`` the estimate of the gyro's bias.
    """

    poses: FloatArray
    heading_error_rad: float
    position_error_m: float
    remaining_error_m: float
    length_m: float
    turns: int
    gyro_bias_rad_s: float


def close_wire_loop(
    odometry: ArrayLike,
    timestamp_s: ArrayLike | None = None,
    *,
    pairs: Sequence[tuple[int, int]] | ArrayLike | None = None,
    relative: ArrayLike | None = None,
    noise: DriftNoise | None = None,
    max_gap_share: float = 0.06,
    max_heading_rad: float = 1.5,
) -> ClosedLoop:
    """Correct the drift of a drive along a border that comes back to where it began.

    ``odometry`` (n, 3) x, y, heading in a frame of its own, headings wrapped or not; ``timestamp_s`` (n,), else frames
    count as equally long apart. ``pairs`` (c, 2) are frames (earlier, later) where the drive is at the same place, by
    default its first and last one; frames before and after them are carried along. ``relative`` (3,) or (c, 3) is the
    pose of the earlier one as seen by the robot at the later one: x ahead, y left, heading. By default a given pair is
    the same pose, and the first frame is one more step, like the last one, away from the last frame: a recorded lap
    ends just before its start. The first pose stays as it is.
    Raises ``ArrayError`` for other shapes or unknown poses, ``ConfigError`` for values out of range, ``RecordingError``
    where headings differ by more than ``max_heading_rad`` from full turns, where the gap that a constant bias leaves is
    more than ``max_gap_share`` of the way between, or where a drive without ``pairs`` made no full turn.
    """
    path, times = checked_odometry(odometry, timestamp_s)
    closures = _closures(path, pairs, relative)
    heading_error, gap = _closing_errors(path, closures)
    # A first guess: all of the heading error is one bias.
    lasted = times[closures.first] - times[closures.second]
    bias = float(np.median(heading_error / lasted))
    steps = Steps.of(path, times)
    initial = steps.integrated(path[0, :2], path[:, 2] - bias * (times - times[0]))
    remaining = float(np.median(_closing_errors(initial, closures)[1]))
    travelled = np.concatenate([[0.0], np.cumsum(np.hypot(steps.ahead_m, steps.left_m))])
    length = float(np.median(travelled[closures.first] - travelled[closures.second]))
    error = float(np.median(heading_error))
    turned = path[closures.first, 2] + closures.relative[:, 2] - path[closures.second, 2] - heading_error
    turns = round(float(np.median(turned)) / (2.0 * np.pi))
    _check_closed(error, remaining, length, max_gap_share, max_heading_rad)
    if pairs is None and turns == 0:
        raise RecordingError(
            "this drive is no lap: it made no full turn from its first to its last frame; name the frames that meet "
            "as pairs"
        )
    fitted = fit_path(path, times, noise or DriftNoise(), closures=closures, initial=initial)
    return ClosedLoop(fitted.poses, error, float(np.median(gap)), remaining, length, turns, fitted.gyro_bias_rad_s)


def checked_odometry(odometry: ArrayLike, timestamp_s: ArrayLike | None) -> tuple[FloatArray, FloatArray]:
    """Odometry (n, 3) with headings unwrapped and times (n,), every one known, at least three."""
    path = np.array(odometry, dtype=np.float64)
    if path.ndim != 2 or path.shape[1] != 3 or len(path) < 3:
        raise ArrayError(f"odometry has to be x, y, heading of at least 3 frames (n, 3), got shape {path.shape}")
    if not np.isfinite(path).all():
        missing = int((~np.isfinite(path).all(axis=1)).sum())
        raise ArrayError(f"odometry is unknown in {missing} of {len(path)} frames; leave these frames out")
    path[:, 2] = np.unwrap(path[:, 2])
    times = np.array(_FRAME_S * np.arange(len(path)) if timestamp_s is None else timestamp_s, dtype=np.float64)
    if times.shape != (len(path),):
        raise ArrayError(f"timestamp_s has shape {times.shape}, but odometry has {len(path)} frames: one time each")
    if not (np.diff(times) > 0).all():
        raise ArrayError("timestamp_s has to increase from frame to frame, without NaN; sort the frames by time")
    return path, times


def _closures(
    path: FloatArray, pairs: Sequence[tuple[int, int]] | ArrayLike | None, relative: ArrayLike | None
) -> Closures:
    """The pairs, later frame first, with the pose of the earlier one as seen from there."""
    given: IndexArray = np.array([[0, len(path) - 1]] if pairs is None else pairs, dtype=np.int64)
    if given.ndim != 2 or given.shape[1] != 2 or len(given) == 0:
        raise ArrayError(f"pairs has to be (earlier, later) frames (c, 2), at least one, got shape {given.shape}")
    earlier, later = given.T
    if not ((earlier >= 0) & (earlier < later) & (later < len(path))).all():
        raise ConfigError(f"pairs has to be frames 0 <= earlier < later < {len(path)}, got one outside of that")
    if relative is None:
        relative = _next_step(path) if pairs is None else np.zeros(3)
    seen = np.asarray(relative, np.float64)
    if seen.shape not in ((3,), (len(given), 3)) or not np.isfinite(seen).all():
        raise ArrayError(
            f"relative has to be x, y, heading (3,) or one for each pair ({len(given)}, 3), got {seen.shape}"
        )
    seen = np.broadcast_to(seen, (len(given), 3)).copy()
    seen[:, 2] = wrapped(seen[:, 2])
    # Pairs that follow each other share the deviation from the line: together they know hardly more than each of them.
    correlation = min(float(np.sqrt(len(given))), _CORRELATION)
    return Closures(
        later,
        earlier,
        seen,
        _CLOSURE_M * correlation,
        _CLOSURE_RAD * correlation,
    )


def _next_step(path: FloatArray) -> FloatArray:
    """One more step like the last one, in the robot's frame (3,)."""
    return _relative(path[-2:-1], path[-1:]).reshape(3)


def _relative(first: FloatArray, second: FloatArray) -> FloatArray:
    """Poses ``second`` in the robot frames of ``first`` (c, 3)."""
    moved, cos, sin = second - first, np.cos(first[:, 2]), np.sin(first[:, 2])
    return np.column_stack([cos * moved[:, 0] + sin * moved[:, 1], cos * moved[:, 1] - sin * moved[:, 0], moved[:, 2]])


def _closing_errors(path: FloatArray, closures: Closures) -> tuple[FloatArray, FloatArray]:
    """Of each pair how much too far odometry turned (c,) between, full turns aside, and its gap in metres (c,)."""
    missed = closures.relative - _relative(path[closures.first], path[closures.second])
    return wrapped(missed[:, 2]), np.asarray(np.hypot(missed[:, 0], missed[:, 1]), np.float64)


def _check_closed(
    heading_rad: float, gap_m: float, length_m: float, max_gap_share: float, max_heading_rad: float
) -> None:
    if not (0 < max_gap_share < 1 and 0 < max_heading_rad <= np.pi):
        raise ConfigError(
            f"max_gap_share={max_gap_share}, max_heading_rad={max_heading_rad}: have to be in (0, 1) and (0, pi]"
        )
    if abs(heading_rad) > max_heading_rad:
        raise RecordingError(
            f"this drive is no closed loop: its headings at start and end differ by {abs(heading_rad):.2f} rad from "
            f"full turns, up to {max_heading_rad:g} is drift; record until the robot is back where it began"
        )
    if not gap_m <= max_gap_share * length_m:
        raise RecordingError(
            f"this drive is no closed loop: a gap of {gap_m:.2f} m is left after {length_m:.1f} m, up to "
            f"{max_gap_share:.0%} is drift; record until the robot is back where it began"
        )
