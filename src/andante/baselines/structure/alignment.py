"""A reconstruction, which has no scale and no north, is laid over known positions."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.errors import LearningError

FEWEST = 3
_TRIALS = 500


@dataclass(frozen=True, slots=True)
class Similarity:
    """x -> ``scale`` ``rotation`` x + ``translation`` in three dimensions; ``inliers`` of the given pairs agree."""

    scale: float
    rotation: FloatArray
    translation: FloatArray
    inliers: int

    @classmethod
    def identity(cls) -> Self:
        """Of what lies where it should already."""
        return cls(1.0, np.eye(3), np.zeros(3), 0)

    def points(self, xyz: FloatArray) -> FloatArray:
        """(n, 3) -> (n, 3)."""
        moved: FloatArray = self.scale * xyz @ self.rotation.T + self.translation
        return moved


def aligned(
    centres: FloatArray, upward: FloatArray, xy_m: FloatArray, *, tolerance_m: float, rng: np.random.Generator
) -> Similarity:
    """Camera centres (n, 3) and directions ``upward`` (n, 3) of a reconstruction over positions (n, 2) on the ground.

    The mean upward direction is made the vertical, which positions along a straight line would not tell, then a
    similarity of the plane is found by RANSAC from pairs of positions and fitted to all that agree within
    ``tolerance_m`` (Umeyama 1991). The ground is where the cameras are: their mean height is zero. Raises
    ``LearningError`` where fewer than three positions agree.
    """
    level = _level(upward.mean(axis=0))
    levelled = centres @ level.T
    source, target = levelled[:, 0] + 1j * levelled[:, 1], xy_m[:, 0] + 1j * xy_m[:, 1]
    agree = _consensus(source, target, tolerance_m, rng)
    if agree.sum() < FEWEST:
        raise LearningError(
            f"the reconstruction does not fit the positions: {agree.sum()} of {len(xy_m)} agree within "
            f"{tolerance_m:g} m, at least {FEWEST} are needed; check the positions or use poses='given'"
        )
    turn, shift = _fitted(source[agree], target[agree])
    scale, angle = abs(turn), np.angle(turn)
    cos, sin = np.cos(angle), np.sin(angle)
    about_vertical = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    height = -scale * float(levelled[agree, 2].mean())
    translation = np.array([shift.real, shift.imag, height])
    return Similarity(scale, about_vertical @ level, translation, int(agree.sum()))


def _level(up: FloatArray) -> FloatArray:
    """A rotation (3, 3) that takes the direction ``up`` to the third axis."""
    third = up / np.linalg.norm(up)
    other = np.eye(3)[np.argmin(np.abs(third))]
    first = np.cross(other, third)
    first /= np.linalg.norm(first)
    return np.stack([first, np.cross(third, first), third])


def _consensus(
    source: NDArray[np.complex128], target: NDArray[np.complex128], tolerance_m: float, rng: np.random.Generator
) -> NDArray[np.bool_]:
    """(n,) true where the best similarity from two positions agrees."""
    best = np.zeros(len(source), np.bool_)
    for _ in range(_TRIALS if len(source) >= FEWEST else 0):
        first, second = rng.choice(len(source), 2, replace=False)
        if source[first] == source[second]:
            continue
        turn = (target[second] - target[first]) / (source[second] - source[first])
        agree = np.abs(turn * (source - source[first]) + target[first] - target) <= tolerance_m
        if agree.sum() > best.sum():
            best = agree
    return best


def _fitted(source: NDArray[np.complex128], target: NDArray[np.complex128]) -> tuple[complex, complex]:
    """Least squares of target = turn * source + shift over complex numbers."""
    centred, mean = source - source.mean(), target.mean()
    turn = np.vdot(centred, target - mean) / np.vdot(centred, centred)
    return complex(turn), complex(mean - turn * source.mean())
