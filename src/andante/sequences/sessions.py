"""Several drives along one border, each with odometry of its own, in the frame of the first one.

Sequential and causal: a drive is registered with those before it and never changes them, so a map that learns a new
drive is the map that would have been built from all at once.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from andante.data import FloatArray, IndexArray
from andante.errors import ArrayError, ConfigError, RecordingError
from andante.sequences.alignment import Correspondences, align_sequences
from andante.sequences.closure import ClosedLoop, checked_odometry, close_wire_loop
from andante.sequences.likeness import FeatureArray, checked_features
from andante.sequences.pose_graph import Anchors, DriftNoise, fit_path
from andante.sequences.registration import Registration, fit_similarity
from andante.sequences.revisits import find_loop_closures

_FEW, _OVERLAP = 3, 8
"""Pairs of revisiting frames with which a drive may be, and is taken to be, longer than one lap."""
_MIN_EVIDENCE = 0.15
"""Mean confidence of a drive's frames, those that do not fit counted as 0. Drives of other gardens reach 0.13, with
less than a third of their frames; drives of the same garden 1.0, and 0.3 with as much noise as features."""
_NEXT = 3.0
"""The first frame follows the last one if it is at most so many steps away."""
_LEAST = 0.05
"""No correspondence counts less than one of this confidence."""
_BENDS = 3
"""How often correspondences are chosen anew by the path that they led to."""


@dataclass(frozen=True, slots=True)
class SessionReport:
    """How a drive came into the common frame.

    ``closing`` is the drive closed on itself, ``None`` where it does not close; ``registration`` where it lies as a
    whole, ``None`` for the first one and for one that does not fit; ``references`` the earlier drives it was registered
    with; ``kept`` and ``rejected`` how many correspondences with all of them agree with the final path, ``residual_m``
    their median distance from it; ``reverse`` whether it was driven in the direction opposite to the first one.
    ``misfit`` says why it was left out, empty where it was not.
    """

    closing: ClosedLoop | None
    registration: Registration | None = None
    references: tuple[int, ...] = ()
    kept: int = 0
    rejected: int = 0
    residual_m: float = 0.0
    reverse: bool = False
    misfit: str = ""


@dataclass(frozen=True, slots=True)
class RegisteredSession:
    """One drive: features (n, d), ``poses`` (n, 3) x, y, heading in the common frame, NaN where it does not fit."""

    features: FeatureArray
    poses: FloatArray
    report: SessionReport

    @property
    def xy_m(self) -> FloatArray:
        """(n, 2) positions."""
        return self.poses[:, :2]

    @property
    def heading_rad(self) -> FloatArray:
        """(n,) headings, unwrapped."""
        return self.poses[:, 2]

    @property
    def is_lap(self) -> bool:
        """Whether the first frame follows the last one, as where a lap was driven once."""
        step = np.hypot(*np.diff(self.xy_m, axis=0).T)
        return float(np.hypot(*(self.xy_m[0] - self.xy_m[-1]))) <= _NEXT * float(np.median(step))


@dataclass(frozen=True, slots=True)
class _Match:
    """What one earlier drive says of the places of a new one's frames, and whether that one went the other way."""

    number: int
    aligned: Correspondences
    target_m: FloatArray
    reverse: bool


@dataclass(frozen=True, slots=True)
class _Evidence:
    """What all earlier drives say together: ``frame`` (k,) was at ``target_m`` (k, 2), each with a ``confidence``."""

    frame: IndexArray
    target_m: FloatArray
    confidence: FloatArray

    @classmethod
    def of(cls, matches: Sequence[_Match]) -> _Evidence:
        return cls(
            np.concatenate([match.aligned.first for match in matches]),
            np.concatenate([match.target_m for match in matches]),
            np.concatenate([match.aligned.confidence for match in matches]),
        )

    def distance_m(self, poses: FloatArray) -> FloatArray:
        """(k,) between where a frame is by ``poses`` (n, 3) and where it ought to be."""
        return np.asarray(np.linalg.norm(poses[self.frame, :2] - self.target_m, axis=1), np.float64)

    def anchors(self, poses: FloatArray, anchor_m: float, inlier_m: float) -> Anchors:
        """What lies near the path, as anchors of it."""
        # Drives that agree about a frame share the frame's own error: more of them make it hardly more certain.
        deviation = anchor_m * np.sqrt(np.bincount(self.frame)[self.frame] / np.maximum(self.confidence, _LEAST))
        near = self.distance_m(poses) <= inlier_m
        return Anchors(self.frame[near], self.target_m[near], deviation[near])


def register_sessions(
    features: Sequence[ArrayLike],
    odometry: Sequence[ArrayLike],
    timestamp_s: Sequence[ArrayLike] | None = None,
    *,
    misfits: Literal["refuse", "leave_out"] = "refuse",
    noise: DriftNoise | None = None,
    anchor_m: float = 0.15,
    inlier_m: float = 0.6,
    seed: int = 0,
) -> list[RegisteredSession]:
    """The drives of one border, in the frame of the first one's odometry, one after the other.

    For each drive ``features`` (n_i, d) of one heading-invariant encoder, ``odometry`` (n_i, 3) x, y, heading in a
    frame of its own, and ``timestamp_s`` (n_i,). The first drive has to be a lap or more; later ones may be parts.
    ``misfits``: whether a drive that belongs somewhere else raises, or comes back with NaN poses and a report that
    says why. All else is as in ``register_session``.
    Raises ``RecordingError`` naming the drive, ``ArrayError`` for other shapes.
    """
    times = [None] * len(features) if timestamp_s is None else list(timestamp_s)
    if not len(features) == len(odometry) == len(times) or len(times) == 0:
        raise ArrayError(
            f"features, odometry and timestamp_s need one entry per drive, at least one; got {len(features)}, "
            f"{len(odometry)} and {len(times)}"
        )
    if misfits not in ("refuse", "leave_out"):
        raise ConfigError(f"misfits={misfits!r}: has to be 'refuse' or 'leave_out'")
    sessions: list[RegisteredSession] = []
    for number, (seen, driven, when) in enumerate(zip(features, odometry, times, strict=True)):
        try:
            sessions.append(
                register_session(
                    seen, driven, when, earlier=sessions, noise=noise, anchor_m=anchor_m, inlier_m=inlier_m, seed=seed
                )
            )
        except RecordingError as error:
            # Without the first drive there is no frame.
            if number == 0 or misfits == "refuse":
                raise RecordingError(f"drive {number}: {error}") from None
            values = checked_features(seen, "features")
            nowhere = np.full((len(values), 3), np.nan)
            sessions.append(RegisteredSession(values, nowhere, SessionReport(None, misfit=str(error))))
    return sessions


def register_session(
    features: ArrayLike,
    odometry: ArrayLike,
    timestamp_s: ArrayLike | None = None,
    *,
    earlier: Sequence[RegisteredSession],
    noise: DriftNoise | None = None,
    anchor_m: float = 0.15,
    inlier_m: float = 0.6,
    seed: int = 0,
) -> RegisteredSession:
    """One more drive in the frame of ``earlier`` ones, which stay as they are; the first drive makes the frame.

    The drive is closed on itself where it is a lap or more, aligned with every earlier drive by features, placed as a
    whole by the correspondences on which most agree, and bent to fit them as far as ``noise`` of its odometry allows.
    ``anchor_m`` is the standard deviation of one frame's correspondence, neighbouring frames err alike; those further
    off than ``inlier_m`` are rejected. Raises ``RecordingError`` where the drive does not fit, or where the first one
    does not close; ``ArrayError`` for other shapes.
    """
    values = checked_features(features, "features")
    path, times = checked_odometry(odometry, timestamp_s)
    if len(path) != len(values):
        raise ArrayError(f"features has {len(values)} frames, odometry {len(path)}: one of each per frame")
    if not (0 < anchor_m < np.inf and 0 < inlier_m < np.inf):
        raise ConfigError(f"anchor_m={anchor_m}, inlier_m={inlier_m}: both have to be distances above 0 m")
    noise = noise or DriftNoise()
    known = [number for number, one in enumerate(earlier) if not one.report.misfit]
    closing = _closed(values, path, times, noise, required=not known)
    if closing is not None and not known:
        return RegisteredSession(values, closing.poses, SessionReport(closing))
    start = path if closing is None else closing.poses
    matches, refusal = _matches(values, start, [(number, earlier[number]) for number in known], inlier_m, seed)
    if not matches:
        raise RecordingError(refusal)
    seen = _Evidence.of(matches)
    whole = fit_similarity(start[seen.frame, :2], seen.target_m, seen.confidence, inlier_m=inlier_m, seed=seed)
    poses = placed = whole.apply(start)
    for _ in range(_BENDS):
        anchors = seen.anchors(poses, anchor_m, inlier_m)
        poses = fit_path(placed, times, noise, anchors=anchors, initial=poses).poses
    distance = seen.distance_m(poses)
    kept = distance <= inlier_m
    residual = float(np.median(distance[kept]))
    report = SessionReport(
        closing,
        whole,
        tuple(match.number for match in matches),
        int(kept.sum()),
        int((~kept).sum()),
        residual,
        matches[0].reverse,
    )
    return RegisteredSession(values, poses, report)


def _closed(
    features: FeatureArray, path: FloatArray, times: FloatArray, noise: DriftNoise, *, required: bool
) -> ClosedLoop | None:
    """The drive closed where it revisits itself in its own direction, or as a single lap; ``None`` if it is neither."""
    revisits = find_loop_closures(features, path)
    turned = path[revisits.later, 2] - path[revisits.earlier, 2]
    pairs = revisits.pairs[np.cos(turned) > 0]
    # A lap ends one step before its start; where it goes on there are pairs to say where it closed.
    ways: list[IndexArray | None] = [None] if len(pairs) < _FEW else [None, pairs]
    if len(pairs) >= _OVERLAP:
        ways = [pairs]
    for number, way in enumerate(ways, 1):
        try:
            return close_wire_loop(path, times, pairs=way, noise=noise)
        except RecordingError:
            if required and number == len(ways):
                raise
    return None


def _matches(
    features: FeatureArray,
    poses: FloatArray,
    known: Sequence[tuple[int, RegisteredSession]],
    inlier_m: float,
    seed: int,
) -> tuple[list[_Match], str]:
    """The earlier drives that a new one fits, and why the last one of the others does not."""
    matches, refusal = [], ""
    for number, reference in known:
        aligned = align_sequences(features, reference.features, reference_xy_m=reference.xy_m, cyclic=reference.is_lap)
        target = _places(reference, aligned)
        try:
            fitted = fit_similarity(poses[:, :2], target, aligned.confidence, inlier_m=inlier_m, seed=seed)
        except RecordingError as error:
            refusal = str(error)
            continue
        evidence = float((aligned.confidence * fitted.kept).mean())
        if evidence < _MIN_EVIDENCE:
            refusal = (
                f"this drive does not fit: too few of its frames are recognised (confidence {evidence:.2f}, at least "
                f"{_MIN_EVIDENCE} is needed); is it the same place?"
            )
            continue
        matches.append(_Match(number, aligned, target, aligned.reverse != reference.report.reverse))
    return matches, refusal


def _places(reference: RegisteredSession, aligned: Correspondences) -> FloatArray:
    """(k, 2) where the reference was, between its frames, when it saw what the others see."""
    at = reference.xy_m[aligned.second]
    beside = (aligned.second + np.sign(aligned.offset).astype(np.int64)) % len(reference.xy_m)
    return np.asarray(at + np.abs(aligned.offset)[:, None] * (reference.xy_m[beside] - at), np.float64)
