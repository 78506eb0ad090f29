"""One drive in the frame of others, from frames of the same place: first as a whole, then bent to fit.

``fit_similarity`` finds rotation, translation and scale and which correspondences contradict them; ``fit_path`` then
lets the drive give way where odometry is likely to have drifted.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from andante.data import FloatArray
from andante.errors import ArrayError, ConfigError, RecordingError

_TRIALS = 400
_REFINEMENTS = 10
_BASE_M = 2.0
"""Two correspondences closer together than this say too little about a rotation."""
_FEWEST = 10
_Transform = tuple[float, FloatArray, float]
"""Angle, shift and scale."""


@dataclass(frozen=True, slots=True)
class Registration:
    """Where a drive lies in the frame of others: ``scale`` and ``rotation_rad`` first, then ``translation_m`` (2,).

    ``kept`` (k,) says which correspondences agree; ``residual_m`` is the median distance of those that do.
    """

    rotation_rad: float
    translation_m: FloatArray
    scale: float
    kept: NDArray[np.bool_]
    residual_m: float

    @property
    def n_kept(self) -> int:
        """How many correspondences agree with the transform."""
        return int(self.kept.sum())

    @property
    def n_rejected(self) -> int:
        """How many contradict it."""
        return len(self.kept) - self.n_kept

    def apply(self, poses: ArrayLike) -> FloatArray:
        """Poses (n, 3) or points (n, 2) of the drive -> the same in the others' frame."""
        values = np.array(poses, np.float64)
        matrix = _rotation(np.array([self.rotation_rad]))[0]
        values[:, :2] = self.scale * values[:, :2] @ matrix.T + self.translation_m
        values[:, 2:] += self.rotation_rad
        return values


@dataclass(frozen=True, slots=True)
class _Ties:
    """Places ``source`` and ``target`` (k, 2) that ought to coincide, and how much each pair counts."""

    source: FloatArray
    target: FloatArray
    weight: FloatArray

    @classmethod
    def checked(cls, source_m: ArrayLike, target_m: ArrayLike, confidence: ArrayLike | None) -> _Ties:
        """What a user gave, with its shapes and values checked."""
        source, target = np.asarray(source_m, np.float64), np.asarray(target_m, np.float64)
        weight = np.asarray(np.ones(len(source)) if confidence is None else confidence, np.float64)
        if source.ndim != 2 or source.shape[1] != 2 or source.shape != target.shape or weight.shape != (len(source),):
            raise ArrayError(
                f"source_m and target_m have to be (k, 2) and confidence (k,), one of each per correspondence; got "
                f"shapes {source.shape}, {target.shape}, {weight.shape}"
            )
        if not (np.isfinite(source).all() and np.isfinite(target).all() and (weight >= 0).all() and len(source)):
            raise ArrayError("correspondences have to be at least one, finite, their confidence not below 0")
        return cls(source, target, weight)

    def of(self, chosen: NDArray[np.bool_]) -> _Ties:
        """Some of them."""
        return _Ties(self.source[chosen], self.target[chosen], self.weight[chosen])

    def distance_m(self, angle_rad: float, shift_m: FloatArray, scale: float) -> FloatArray:
        """(k,) how far apart they are after a transform of the source."""
        moved = scale * self.source @ _rotation(np.array([angle_rad]))[0].T + shift_m
        return np.asarray(np.linalg.norm(moved - self.target, axis=1), np.float64)


def fit_similarity(
    source_m: ArrayLike,
    target_m: ArrayLike,
    confidence: ArrayLike | None = None,
    *,
    inlier_m: float = 0.6,
    with_scale: bool = True,
    max_scale_error: float = 0.06,
    min_kept_share: float = 0.5,
    seed: int = 0,
) -> Registration:
    """The rotation, translation and scale that most of the correspondences agree on.

    ``source_m``, ``target_m`` (k, 2) are places that ought to coincide, ``confidence`` (k,) 0..1 weighs them.
    Many pairs of them are tried (Fischler and Bolles 1981), the best transform is refined on all that lie within
    ``inlier_m``: that much two drives may have drifted apart. Wheels differ in scale by up to ``max_scale_error``. The
    same input and ``seed`` give the same result.
    Raises ``RecordingError`` where fewer than 10 or less than ``min_kept_share`` of them agree: the places do
    not belong together; ``ArrayError`` for other shapes, ``ConfigError`` for values out of range.
    """
    ties = _Ties.checked(source_m, target_m, confidence)
    if not (0 < inlier_m < np.inf and 0 <= max_scale_error < 0.5 and 0 < min_kept_share <= 1):
        raise ConfigError(
            f"inlier_m={inlier_m}, max_scale_error={max_scale_error}, min_kept_share={min_kept_share}: have to be "
            f"above 0, in [0, 0.5) and in (0, 1]"
        )
    limit = max_scale_error if with_scale else 0.0
    fitted = _best_guess(ties, inlier_m, limit, np.random.default_rng(seed))
    kept = np.zeros(len(ties.source), np.bool_)
    for _ in range(_REFINEMENTS):
        if fitted is None:
            break
        near = ties.distance_m(*fitted) <= inlier_m
        if np.array_equal(kept, near) or ties.weight[near].sum() <= 0:
            break
        kept = near
        fitted = _least_squares(ties.of(kept), limit)
    if fitted is None or kept.sum() < _FEWEST or kept.mean() < min_kept_share:
        raise RecordingError(
            f"this drive does not fit: {kept.sum()} of {len(kept)} correspondences agree within {inlier_m:g} m, "
            f"at least {_FEWEST} and {min_kept_share:.0%} of all are needed; is it the same place?"
        )
    angle, shift, scale = fitted
    return Registration(angle, shift, scale, kept, float(np.median(ties.distance_m(*fitted)[kept])))


def _best_guess(ties: _Ties, inlier_m: float, limit: float, rng: np.random.Generator) -> _Transform | None:
    """Of many transforms through two correspondences the one with the best truncated squares, ``None`` if none fits."""
    source, target, weight = ties.source, ties.target, ties.weight
    if len(source) < 2 or weight.sum() <= 0:
        return None
    a, b = rng.choice(len(source), (2, _TRIALS), p=weight / weight.sum())
    was, now = source[b] - source[a], target[b] - target[a]
    far, long = np.hypot(*was.T), np.hypot(*now.T)
    # Two correspondences may each be wrong by a share of what is tolerated.
    usable = (far > _BASE_M) & (np.abs(long - far) < limit * far + inlier_m)
    a, was, now, far, long = a[usable], was[usable], now[usable], far[usable], long[usable]
    if len(a) == 0:
        return None
    scale = np.clip(long / far, 1.0 - limit, 1.0 + limit)
    angle = np.arctan2(now[:, 1], now[:, 0]) - np.arctan2(was[:, 1], was[:, 0])
    turn = scale[:, None, None] * _rotation(angle)
    shift = target[a] - np.einsum("tij,tj->ti", turn, source[a])
    error = np.einsum("tij,kj->tki", turn, source) + shift[:, None] - target
    gain = np.maximum(0.0, 1.0 - np.square(error).sum(axis=2) / inlier_m**2) @ weight
    best = int(gain.argmax())
    return float(angle[best]), shift[best], float(scale[best])


def _least_squares(ties: _Ties, limit: float) -> _Transform:
    """Angle, shift and scale with the smallest weighted squares (Umeyama 1991, in the plane)."""
    source, target, weight = ties.source, ties.target, ties.weight
    centre, goal = np.average(source, 0, weight), np.average(target, 0, weight)
    a, b = source - centre, target - goal
    along = float(weight @ (a * b).sum(axis=1))
    across = float(weight @ (a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]))
    angle = float(np.arctan2(across, along))
    spread = max(float(weight @ np.square(a).sum(axis=1)), 1e-12)
    scale = float(np.clip(np.hypot(along, across) / spread, 1.0 - limit, 1.0 + limit))
    return angle, goal - scale * _rotation(np.array([angle]))[0] @ centre, scale


def _rotation(angle_rad: FloatArray) -> FloatArray:
    """Matrices (k, 2, 2) for angles (k,)."""
    cos, sin = np.cos(angle_rad), np.sin(angle_rad)
    return np.stack([np.stack([cos, -sin], -1), np.stack([sin, cos], -1)], -2)
