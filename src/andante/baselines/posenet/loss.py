"""The loss of PoseNet 2017: how much position and heading matter is learnt with the weights of the network."""

from __future__ import annotations

import torch
from torch import Tensor, nn
from torch.nn import functional


class GeometricLoss(nn.Module):
    """L = Lx exp(-sx) + sx + Lq exp(-sq) + sq, with learnt sx and sq (Kendall & Cipolla 2017, eq. 3).

    Lx is the mean distance of positions and Lq that of headings as unit vectors, over the pictures whose heading is
    known; without any, the terms of the heading are left out. Distances are Euclidean: in the L1 norm of the paper,
    half a turn off along an axis is a local minimum. sx starts at 0 and sq at -3, as there.
    """

    def __init__(self, s_position: float = 0.0, s_heading: float = -3.0) -> None:
        super().__init__()
        self.s_position = nn.Parameter(torch.tensor(s_position))
        self.s_heading = nn.Parameter(torch.tensor(s_heading))

    def forward(self, position: Tensor, heading: Tensor, true_position: Tensor, true_heading: Tensor) -> Tensor:
        """Positions (n, 2), heading vectors (n, 2) of any length, true headings (n,) in radians, NaN where unknown."""
        loss: Tensor = _mean_length(position - true_position) * torch.exp(-self.s_position) + self.s_position
        known = torch.isfinite(true_heading)
        if not known.any():
            return loss
        truth = torch.stack([true_heading[known].cos(), true_heading[known].sin()], 1)
        turn = _mean_length(functional.normalize(heading[known], dim=1) - truth)
        return loss + turn * torch.exp(-self.s_heading) + self.s_heading


def _mean_length(vectors: Tensor) -> Tensor:
    mean: Tensor = torch.linalg.vector_norm(vectors, dim=1).mean()
    return mean
