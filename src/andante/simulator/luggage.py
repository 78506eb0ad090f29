"""A suitcase with all that makes people, and what has learnt from their pictures, say that it is one."""

from __future__ import annotations

import numpy as np

from andante.simulator.mesh import Layer, Matter, Mesh, Paint
from andante.simulator.shapes import box, boxes, chain, ellipsoid, prism, rods

_BLACK = Paint(0.02, 0.02, 0.022, Layer.SMOOTH, Matter.INDOOR)
_STEEL = Paint(0.50, 0.51, 0.53, Layer.SMOOTH, Matter.INDOOR)
_SHELLS = ((0.50, 0.03, 0.04), (0.04, 0.13, 0.42), (0.02, 0.02, 0.025), (0.30, 0.05, 0.30))
_WIDE_M, _DEEP_M, _LOW_M, _HIGH_M = 0.48, 0.28, 0.07, 0.76


def trolley(rng: np.random.Generator) -> Mesh:
    """A large suitcase on four castors, its handle pulled out; its broad side looks along y."""
    shell = Paint(*_SHELLS[rng.integers(len(_SHELLS))], Layer.SMOOTH, Matter.INDOOR)
    half = _DEEP_M / 2.0
    body = prism(_rounded(_WIDE_M, 0.07), -half, half, shell)
    seam = prism(_rounded(_WIDE_M + 0.012, 0.07), -0.012, 0.012, _BLACK)
    ribs = [
        prism(_rounded(0.03, 0.012, x, 0.09), -half - 0.01, half + 0.01, shell).tinted(0.7)
        for x in (-0.14, -0.05, 0.05, 0.14)
    ]
    rails = rods(
        [(x, half - 0.04, _HIGH_M - 0.02) for x in (-0.11, 0.11)],
        [(x, half - 0.04, 1.06) for x in (-0.11, 0.11)],
        0.011,
        0.011,
        _STEEL,
    )
    grip = box((-0.135, half - 0.065, 1.05), (0.135, half - 0.015, 1.09), _BLACK)
    strap = chain([(-0.09, 0, _HIGH_M), (-0.07, 0, 0.795), (0.07, 0, 0.795), (0.09, 0, _HIGH_M)], 0.013, _BLACK)
    feet = [(x, y, 0.035) for x in (-0.18, 0.18) for y in (-0.1, 0.1)]
    castors = [ellipsoid(foot, (0.035, 0.018, 0.035), _BLACK, 8) for foot in feet]
    forks = boxes([(x, y, 0.04) for x, y, _ in feet], (0.05, 0.05, 0.04), _BLACK)
    return Mesh.joined([body, seam, *ribs, rails, grip, strap, forks, *castors])


def _rounded(wide_m: float, radius_m: float, middle_m: float = 0.0, inset_m: float = 0.0) -> np.ndarray:
    """Outline (28, 2) of the shell seen from the broad side, counter-clockwise, its corners rounded."""
    turn = np.linspace(0.0, np.pi / 2.0, 7)
    low, high = _LOW_M + inset_m, _HIGH_M - inset_m
    half = wide_m / 2.0
    corners = []
    for quarter, (x, z) in enumerate(
        (
            (half - radius_m, high - radius_m),
            (radius_m - half, high - radius_m),
            (radius_m - half, low + radius_m),
            (half - radius_m, low + radius_m),
        )
    ):
        angle = turn + quarter * np.pi / 2.0
        corners.append(np.stack([middle_m + x + radius_m * np.cos(angle), z + radius_m * np.sin(angle)], axis=1))
    return np.concatenate(corners)
