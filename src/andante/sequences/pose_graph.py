"""The most likely path of a robot: odometry with its kinds of drift, and what is known of places on the way.

A pose graph in the plane. Unknown are all poses, the gyro bias and the wheels' error of scale; odometry ties each pose
to the next, ``Closures`` tie poses to each other, ``Anchors`` tie poses to known places. Drift goes where it is likely:
a bias grows with time, noise of turning with the turns, slip with the way, so no share between them has to be chosen
(Einecke et al. 2018 distribute the closing error over the turns alone). Gauss-Newton on a sparse system: linear in the
number of frames.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy import sparse
from scipy.sparse.linalg import spsolve

from andante.angles import wrapped
from andante.data import FloatArray, IndexArray
from andante.errors import ConfigError

_ITERATIONS = 30
_CONVERGED = 1e-7
_TRUSTED = 3.0
"""Beyond so many deviations a tie pulls less and less (Cauchy's weights), so that wrong ones do not bend the path."""
_FLOOR_M, _FLOOR_RAD = 1e-3, 1e-3
"""Standard deviation of one step of a robot that stands still."""


@dataclass(frozen=True, slots=True)
class DriftNoise:
    """Standard deviations of odometry's errors: what a cheap robot's wheels and gyro are worth.

    ``gyro_rad_s`` is a bias and ``scale`` an error of the wheels' size, constant in a drive; ``turn_rad`` grows with
    the square root of the turn (per square root of a radian), ``wheel_m`` with that of the way (per square root of a
    metre).
    """

    gyro_rad_s: float = 0.003
    scale: float = 0.01
    turn_rad: float = 0.01
    wheel_m: float = 0.01

    def __post_init__(self) -> None:
        for name in ("gyro_rad_s", "scale", "turn_rad", "wheel_m"):
            if not 0 < getattr(self, name) < 1:
                raise ConfigError(f"{name}={getattr(self, name)}: a standard deviation of odometry is above 0, below 1")


@dataclass(frozen=True, slots=True)
class Closures:
    """Poses seen again: ``relative`` (c, 3) x, y, heading of frame ``second`` in the robot frame of ``first`` (c,)."""

    first: IndexArray
    second: IndexArray
    relative: FloatArray
    deviation_m: float = 0.05
    deviation_rad: float = 0.03


@dataclass(frozen=True, slots=True)
class Anchors:
    """Frames (a,) whose places (a, 2) are known from elsewhere, each up to ``deviation_m`` (a,)."""

    frame: IndexArray
    xy_m: FloatArray
    deviation_m: FloatArray


@dataclass(frozen=True, slots=True)
class FittedPath:
    """Poses (n, 3) x, y, heading unwrapped, and what odometry turned out to be wrong by, as a whole."""

    poses: FloatArray
    gyro_bias_rad_s: float
    scale: float


@dataclass(slots=True)
class _System:
    """Whitened residuals and their derivatives, one block of equations after the other."""

    size: int
    count: int = 0
    rows: list[IndexArray] = field(default_factory=list)
    columns: list[IndexArray] = field(default_factory=list)
    values: list[FloatArray] = field(default_factory=list)
    residuals: list[FloatArray] = field(default_factory=list)

    def add(self, residual: FloatArray, weight: FloatArray, terms: list[tuple[IndexArray, FloatArray]]) -> None:
        """Equations with residuals (k,), weights (k,), and of each unknown the columns (k,) and derivatives (k,)."""
        rows = self.count + np.arange(len(residual))
        for columns, values in terms:
            self.rows.append(rows)
            self.columns.append(columns)
            self.values.append(weight * values)
        self.residuals.append(weight * residual)
        self.count += len(residual)

    def solution(self) -> FloatArray:
        """The step (size,) that makes the squared sum of residuals smallest."""
        entries = np.concatenate(self.values), (np.concatenate(self.rows), np.concatenate(self.columns))
        jacobian = sparse.csr_array(entries, shape=(self.count, self.size))
        normal = sparse.csc_array(jacobian.T @ jacobian)
        return np.asarray(spsolve(normal, -(jacobian.T @ np.concatenate(self.residuals))), np.float64)


@dataclass(frozen=True, slots=True)
class Steps:
    """Odometry's steps (n - 1,): ahead and to the left as seen half-way through the turn, turn, and duration."""

    ahead_m: FloatArray
    left_m: FloatArray
    turn_rad: FloatArray
    duration_s: FloatArray

    @classmethod
    def of(cls, poses: FloatArray, timestamp_s: FloatArray) -> Steps:
        """The steps between poses (n, 3), headings unwrapped."""
        moved, middle = np.diff(poses[:, :2], axis=0), (poses[:-1, 2] + poses[1:, 2]) / 2.0
        ahead, left = _turned(moved[:, 0], moved[:, 1], -middle)
        return cls(ahead, left, np.diff(poses[:, 2]), np.diff(timestamp_s))

    def integrated(self, start_xy_m: FloatArray, heading_rad: FloatArray) -> FloatArray:
        """Poses (n, 3) of the same steps with other headings (n,)."""
        middle = (heading_rad[:-1] + heading_rad[1:]) / 2.0
        moved = np.stack(_turned(self.ahead_m, self.left_m, middle), axis=1)
        xy = np.concatenate([start_xy_m[None], start_xy_m + np.cumsum(moved, axis=0)])
        return np.column_stack([xy, heading_rad])


def fit_path(
    odometry: FloatArray,
    timestamp_s: FloatArray,
    noise: DriftNoise,
    *,
    closures: Closures | None = None,
    anchors: Anchors | None = None,
    initial: FloatArray | None = None,
) -> FittedPath:
    """The most likely poses for odometry (n, 3), headings unwrapped, at ``timestamp_s`` (n,).

    Without anchors the first pose stays where it is. ``initial`` (n, 3) is where the search begins, default odometry.
    """
    n = len(odometry)
    steps = Steps.of(odometry, timestamp_s)
    poses = np.array(odometry if initial is None else initial, np.float64)
    errors = np.zeros(2)  # gyro bias and scale
    for _ in range(_ITERATIONS):
        system = _System(3 * n + 2)
        _tie_steps(system, poses, steps, noise, errors)
        _tie_errors(system, noise, errors)
        # The first pose is held, by a thread only where anchors say where it is.
        _tie_start(system, 1e6 if anchors is None else 1e-6)
        if closures is not None:
            _tie_closures(system, poses, closures)
        if anchors is not None:
            _tie_anchors(system, poses, anchors)
        change = system.solution()
        poses = poses + change[:-2].reshape(n, 3)
        errors = errors + change[-2:]
        if np.abs(change).max() < _CONVERGED:
            break
    return FittedPath(poses, float(errors[0]), float(errors[1]))


def _tie_steps(system: _System, poses: FloatArray, steps: Steps, noise: DriftNoise, errors: FloatArray) -> None:
    """Each pose and the next: (1 + scale) times the measured way, the measured turn less the bias."""
    bias, scale = errors
    now = Steps.of(poses, np.zeros(len(poses)))
    way = np.hypot(steps.ahead_m, steps.left_m)
    cos, sin = _directions(poses)
    here = 3 * np.arange(len(way))
    column = {"x": here, "y": here + 1, "heading": here + 2, "x'": here + 3, "y'": here + 4, "heading'": here + 5}
    of_bias, of_scale = np.full(len(way), system.size - 2), np.full(len(way), system.size - 1)
    weight = 1.0 / np.hypot(noise.wheel_m * np.sqrt(way), _FLOOR_M)
    for measured, found, (dx, dy), turned in (
        (steps.ahead_m, now.ahead_m, (cos, sin), now.left_m / 2.0),
        (steps.left_m, now.left_m, (-sin, cos), -now.ahead_m / 2.0),
    ):
        terms = [(column["x'"], dx), (column["y'"], dy), (column["x"], -dx), (column["y"], -dy)]
        terms += [(column["heading"], turned), (column["heading'"], turned), (of_scale, -measured)]
        system.add(found - (1.0 + scale) * measured, weight, terms)
    one = np.ones(len(way))
    weight = 1.0 / np.hypot(noise.turn_rad * np.sqrt(np.abs(steps.turn_rad)), _FLOOR_RAD)
    terms = [(column["heading'"], one), (column["heading"], -one), (of_bias, steps.duration_s)]
    system.add(now.turn_rad - steps.turn_rad + bias * steps.duration_s, weight, terms)


def _tie_errors(system: _System, noise: DriftNoise, errors: FloatArray) -> None:
    """The drive's bias and scale are small."""
    columns = np.array([system.size - 2, system.size - 1])
    weight = 1.0 / np.array([noise.gyro_rad_s, noise.scale])
    system.add(errors, weight, [(columns, np.ones(2))])


def _tie_start(system: _System, weight: float) -> None:
    """The first pose does not move."""
    system.add(np.zeros(3), np.full(3, weight), [(np.arange(3), np.ones(3))])


def _tie_closures(system: _System, poses: FloatArray, closures: Closures) -> None:
    """Pose ``second`` in the robot frame of pose ``first`` is as told."""
    first, second = poses[closures.first], poses[closures.second]
    cos, sin = np.cos(first[:, 2]), np.sin(first[:, 2])
    dx, dy = (second - first)[:, :2].T
    ahead, left = cos * dx + sin * dy, cos * dy - sin * dx
    error = np.column_stack([ahead, left, second[:, 2] - first[:, 2]]) - closures.relative
    error[:, 2] = wrapped(error[:, 2])
    force = _trust(np.hypot(error[:, 0], error[:, 1]) / closures.deviation_m) / closures.deviation_m
    a, b = 3 * closures.first, 3 * closures.second
    system.add(error[:, 0], force, [(b, cos), (b + 1, sin), (a, -cos), (a + 1, -sin), (a + 2, left)])
    system.add(error[:, 1], force, [(b, -sin), (b + 1, cos), (a, sin), (a + 1, -cos), (a + 2, -ahead)])
    one = np.ones(len(a))
    force = _trust(error[:, 2] / closures.deviation_rad) / closures.deviation_rad
    system.add(error[:, 2], force, [(b + 2, one), (a + 2, -one)])


def _tie_anchors(system: _System, poses: FloatArray, anchors: Anchors) -> None:
    """Some poses lie where they are known to lie."""
    error = poses[anchors.frame, :2] - anchors.xy_m
    force = _trust(np.hypot(error[:, 0], error[:, 1]) / anchors.deviation_m) / anchors.deviation_m
    for axis in (0, 1):
        system.add(error[:, axis], force, [(3 * anchors.frame + axis, np.ones(len(force)))])


def _trust(deviations: FloatArray) -> FloatArray:
    """Square root of Cauchy's weights for residuals in units of their deviation; what stands alone is believed."""
    if len(deviations) == 1:
        return np.ones(1)
    return 1.0 / np.sqrt(1.0 + np.square(deviations / _TRUSTED))


def _directions(poses: FloatArray) -> tuple[FloatArray, FloatArray]:
    middle = (poses[:-1, 2] + poses[1:, 2]) / 2.0
    return np.cos(middle), np.sin(middle)


def _turned(x: FloatArray, y: FloatArray, angle_rad: FloatArray) -> tuple[FloatArray, FloatArray]:
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return cos * x - sin * y, sin * x + cos * y
