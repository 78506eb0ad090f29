"""What else the robot might have seen where it was: turned, in another light, behind somebody passing by."""

from __future__ import annotations

import math
from dataclasses import dataclass

import torch
from torch import Tensor
from torch.nn import functional

_CLOUDS = ((8, 16), (4, 8))
"""Rows and columns of a panorama to a grain of noise, coarse and fine."""


@dataclass(frozen=True, slots=True)
class Augmentation:
    """Random changes to panoramas whose grey levels are normalised to a deviation of about a half.

    ``turn`` is for cameras that look all around: columns are rolled by any number. Contrast is multiplied by up to
    ``1 + contrast`` or its inverse, brightness moves by up to ``brightness``, noise has a deviation of up to ``noise``,
    and a window of up to ``hidden`` of the width is blanked. Clouds, with a deviation of up to ``clouds``, belong to
    their day: without them a network that sees a single drive finds its way by its sky.
    """

    turn: bool
    contrast: float = 0.4
    brightness: float = 0.1
    noise: float = 0.12
    hidden: float = 0.2
    clouds: float = 0.3

    def __call__(self, panoramas: Tensor, heading: Tensor, generator: torch.Generator) -> tuple[Tensor, Tensor]:
        """Panoramas (n, 1, height, width) and headings (n,) -> the same, changed; nothing is changed in place."""
        n, _, _, width = panoramas.shape
        if self.turn:
            columns = torch.randint(width, (n,), generator=generator)
            panoramas, heading = turned(panoramas, heading, columns)

        def uniform(low: float, high: float) -> Tensor:
            return low + (high - low) * torch.rand((n, 1, 1, 1), generator=generator)

        gain = uniform(-math.log1p(self.contrast), math.log1p(self.contrast)).exp()
        noise = torch.randn(panoramas.shape, generator=generator) * uniform(0, self.noise)
        lit = panoramas * gain + uniform(-self.brightness, self.brightness) + noise
        lit = lit + sky(panoramas.shape, generator) * uniform(0, self.clouds)
        behind = torch.remainder(torch.arange(width) - uniform(0, width), width)
        return lit.masked_fill(behind < uniform(0, self.hidden) * width, 0.0), heading


def turned(panoramas: Tensor, heading: Tensor, columns: Tensor) -> tuple[Tensor, Tensor]:
    """What the robot sees, and its heading (n,), after it turned counter-clockwise by ``columns`` (n,) on the spot.

    What was ahead is then to the right: the columns of a panorama (n, 1, height, width) move towards higher numbers.
    """
    n, width = len(panoramas), panoramas.shape[-1]
    source = torch.remainder(torch.arange(width) - columns[:, None], width)
    rolled = panoramas.gather(3, source[:, None, None, :].expand(n, 1, panoramas.shape[2], width))
    return rolled, heading + 2 * math.pi * columns / width


def sky(shape: torch.Size, generator: torch.Generator) -> Tensor:
    """Random clouds (n, 1, height, width) with a deviation of about one: coarse noise and finer noise, smoothed."""
    n, _, height, width = shape
    clouds = torch.zeros(shape)
    for up, across in _CLOUDS:
        size = (n, 1, max(2, height // up), max(2, width // across))
        grain = torch.randn(size, generator=generator)
        clouds += functional.interpolate(grain, (height, width), mode="bilinear")
    return clouds
