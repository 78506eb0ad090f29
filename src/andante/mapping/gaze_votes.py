"""Several patches of one image vote for a place and a heading (thesis 7.6.2).

Every patch is compared with all regions of all mapped frames. A region that looks like it says where the robot is, and,
as the direction of the patch in the image is known, which way it looks. Patches of one image are of one place and one
heading, so votes of true matches meet and those of wrong ones scatter; what is hidden looks like nothing that was
mapped, and says little.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.data import FloatArray, Hypothesis
from andante.errors import ArrayError
from andante.features.phase import summit
from andante.sequences.gaze import region_azimuths

_TAU = 2 * np.pi
_TINY = 1e-9
_RIVALS = 3
_INDEPENDENT = 0.6
"""Of what patches say of neighbouring frames: what moves one match astray moves others with it."""
_LEAST_M = 0.02
"""No position is told more finely along an axis."""


@dataclass(frozen=True, slots=True)
class Rules:
    """How patches vote.

    A region loses ``sharpness`` for each time that its squared distance exceeds that of the best one; what a single
    patch can say against a place is bounded by ``outlier_share``, the chance that its match is wrong whatever it looks
    like. Frames within ``consensus_m`` of the winner are averaged, all beyond it are rivals. Patches of ``width_deg``
    that overlap see the same things twice and count for less.
    """

    sharpness: float = 5.0
    outlier_share: float = 0.01
    consensus_m: float = 0.8
    width_deg: float = 48.0


@dataclass(frozen=True, slots=True, eq=False)
class Verdict:
    """What the patches of one image agree on.

    ``xy`` (2,) metres with ``covariance`` (2, 2), uncalibrated; ``heading_rad`` of the robot. ``margin`` is how much
    more speaks for this place and heading than for any place beyond the consensus, in natural logarithms. ``support``
    (m,) says for each patch from 0 to 1 how well its own best match agrees, ``clarity`` (m,) how much it has to say.
    ``hypotheses`` are this place and the next best ones.
    """

    xy: FloatArray
    covariance: FloatArray
    heading_rad: float
    margin: float
    support: FloatArray
    clarity: FloatArray
    hypotheses: tuple[Hypothesis, ...]


@dataclass(frozen=True, eq=False)
class Gallery:
    """What patches are compared with: slow features ``slow`` (F, K, k) float32 of K regions of F frames.

    Frames were taken at ``xy`` (F, 2); region k looks where ``region_azimuths`` says, at ``points_m`` (F, K, 2), NaN
    where these are not known.
    """

    slow: NDArray[np.float32]
    xy: FloatArray
    points_m: FloatArray

    def __post_init__(self) -> None:
        shape = self.slow.shape
        if len(shape) != 3 or not shape[0] or self.xy.shape != (shape[0], 2) or self.points_m.shape != (*shape[:2], 2):
            raise ArrayError(
                "a gallery needs slow features (frames, regions, k), a position for each frame and a point for each "
                f"region, got shapes {shape}, {self.xy.shape} and {self.points_m.shape}"
            )

    @property
    def regions(self) -> int:
        """Number K of regions all around."""
        return int(self.slow.shape[1])

    def squared_distances(self, slow: NDArray[np.float32]) -> NDArray[np.float32]:
        """Of patches (m, k) from all regions: (m, F, K)."""
        flat = self.slow.reshape(-1, self.slow.shape[2])
        squared = self._norms - 2 * (slow @ flat.T) + (slow**2).sum(axis=1)[:, None]
        return np.asarray(np.maximum(squared, _TINY), dtype=np.float32).reshape(len(slow), *self.slow.shape[:2])

    @cached_property
    def _norms(self) -> NDArray[np.float32]:
        return np.asarray((self.slow**2).sum(axis=2).ravel(), dtype=np.float32)


def verdict(
    gallery: Gallery, slow: NDArray[np.float32], azimuth_rad: Sequence[float] | FloatArray, rules: Rules
) -> Verdict:
    """Where patches with slow features (m, k), at azimuths (m,) in the robot's frame, say that their image was taken.

    Raises ``ArrayError`` for no patches, or where their numbers differ.
    """
    azimuth = np.asarray(azimuth_rad, dtype=np.float64)
    if not len(slow) or azimuth.shape != (len(slow),):
        raise ArrayError(f"each of at least one patch needs an azimuth, got {len(slow)} patches and {azimuth.shape}")
    votes, clarity = _votes(gallery.squared_distances(slow), rules)
    heard = np.stack([_by_heading(vote, angle) for vote, angle in zip(votes, azimuth, strict=True)])
    overlap = min(1.0, 360.0 / rules.width_deg / len(slow))
    score = overlap * np.tensordot(clarity, heard, axes=1)
    frame, turn = divmod(int(score.argmax()), gallery.regions)
    weight = _around(gallery.xy, score, frame, turn, rules.consensus_m)
    xy, heading = weight @ gallery.xy, _heading(score[frame], turn)
    offset = gallery.xy - xy
    rivals = _rivals(gallery.xy, score, frame, rules.consensus_m)
    share = np.exp([0.0, *(-behind for behind, _, _ in rivals)])
    spots = [xy.tolist(), *(gallery.xy[rival].tolist() for _, rival, _ in rivals)]
    headings = [heading, *region_azimuths(gallery.regions)[[turn for *_, turn in rivals]].tolist()]
    return Verdict(
        xy=xy,
        covariance=(weight[:, None] * offset).T @ offset + np.eye(2) * _LEAST_M**2,
        heading_rad=heading,
        # Where all that was mapped is one place, there is nothing to mistake it for.
        margin=rivals[0][0] if rivals else np.inf,
        support=_support(heard[:, frame, turn], rules),
        clarity=clarity,
        hypotheses=tuple(
            Hypothesis(x, y, float(part), angle)
            for (x, y), part, angle in zip(spots, share / share.sum(), headings, strict=True)
        ),
    )


def _votes(squared: NDArray[np.float32], rules: Rules) -> tuple[NDArray[np.float32], FloatArray]:
    """What speaks for every region (m, F, K), from log(outlier share) to 0, and how clearly (m,), from 0 to 1."""
    best = squared.min(axis=(1, 2))
    usual = np.median(squared[:, :: max(1, squared.shape[1] // 64)], axis=(1, 2))
    lost = np.exp(-rules.sharpness * (squared / best[:, None, None] - 1))
    votes = np.log(rules.outlier_share + (1 - rules.outlier_share) * lost)
    # Another light takes a patch away from all references alike; what was never mapped is far from all.
    return votes, np.clip(1 - best / usual, 0, 1).astype(np.float64)


def _by_heading(vote: NDArray[np.float32], azimuth: float) -> NDArray[np.float32]:
    """Votes by the region that a patch may show (F, K) -> by the heading that the robot then has (F, K).

    Headings are those of ``region_azimuths``: a patch straight ahead shows the region that the robot is headed for.
    """
    shift = azimuth * vote.shape[1] / _TAU
    whole = int(np.floor(shift))
    share = np.float32(shift - whole)
    return np.roll(vote, whole, axis=1) * (1 - share) + np.roll(vote, whole + 1, axis=1) * share


def _around(xy: FloatArray, score: FloatArray, frame: int, turn: int, consensus_m: float) -> FloatArray:
    """Weights (F,) of the frames that agree with the winner: near it and under about its heading."""
    about = np.take(score, [turn - 1, turn, turn + 1], axis=1, mode="wrap").max(axis=1)
    near = np.linalg.norm(xy - xy[frame], axis=1) <= consensus_m
    weight = np.where(near, np.exp(_INDEPENDENT * (about - about[frame])), 0.0)
    total: FloatArray = weight / weight.sum()
    return total


def _heading(curve: FloatArray, turn: int) -> float:
    """Between the headings tried, by a parabola."""
    regions = len(curve)
    low, top, high = (float(curve[(turn + step) % regions]) for step in (-1, 0, 1))
    aside = float(np.clip(summit(low, top, high), -0.5, 0.5))
    return wrapped(float(np.pi - _TAU * (turn + aside + 0.5) / regions))


def _rivals(xy: FloatArray, score: FloatArray, frame: int, consensus_m: float) -> list[tuple[float, int, int]]:
    """The best places beyond the winner's consensus, and each other's: (by how much it is worse, frame, heading)."""
    best, turn = score.max(axis=1), score.argmax(axis=1)
    left = np.linalg.norm(xy - xy[frame], axis=1) > consensus_m
    found = list[tuple[float, int, int]]()
    while left.any() and len(found) < _RIVALS:
        rival = int(np.where(left, best, -np.inf).argmax())
        found.append((float(best[frame] - best[rival]), rival, int(turn[rival])))
        left &= np.linalg.norm(xy - xy[rival], axis=1) > consensus_m
    return found


def _support(heard: NDArray[np.float32], rules: Rules) -> FloatArray:
    """How far (m,) each patch's own vote for the winner is above what an outlier says, from 0 to 1."""
    share = (np.exp(heard.astype(np.float64)) - rules.outlier_share) / (1 - rules.outlier_share)
    return np.clip(share, 0.0, 1.0)
