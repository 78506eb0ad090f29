"""The convolutional network of PoseNet, made for panoramas: features of every direction, then one pose."""

from __future__ import annotations

import math

import torch
from torch import Tensor, nn
from torch.nn import functional

from andante.baselines.posenet.pictures import AZIMUTH_STRIDE
from andante.baselines.posenet.schedule import CHANNEL_GROUP

_STAGES = ((2, 4), (2, 2), (2, 2), (1, 1))
"""Strides along elevation and azimuth of the stem and the stages; those along azimuth make ``AZIMUTH_STRIDE``."""


class PoseNetwork(nn.Module):
    """Panoramas (n, 1, height, width) -> position (n, 2) in units of its own, and heading as a vector (n, 2).

    A small residual network (He 2016) takes the place of PoseNet's GoogLeNet, which starts from weights that were
    learnt elsewhere. Where the picture goes all around (``wrap``), so do its convolutions, and a robot that turns on
    the spot moves the columns: every column tells in which direction of the map it looks and how sure it is, and all
    of them together what the heading must be. With it the columns are laid out by the directions of the map, and the
    position is regressed from their first Fourier coefficients. Other pictures have no such order: their columns are
    averaged. ``channels`` are those of the first layer; normalising them in groups, not over a batch, a picture alone
    gives the same as among others.
    """

    def __init__(self, shape: tuple[int, int], *, wrap: bool, channels: int = 24, frequencies: int = 6) -> None:
        super().__init__()
        height, width = shape
        sizes = (channels, channels + CHANNEL_GROUP, 2 * (channels + CHANNEL_GROUP), 4 * channels)
        stem, *stages = _STAGES
        layers: list[nn.Module] = [Convolution(1, sizes[0], 5, stem, wrap=wrap), nn.ReLU()]
        for before, after, stride in zip(sizes[:-1], sizes[1:], stages, strict=True):
            layers += [Residual(before, after, stride, wrap=wrap), Residual(after, after, (1, 1), wrap=wrap)]
        self.backbone = nn.Sequential(*layers)
        for up, across in _STAGES:
            height, width = math.ceil(height / up), math.ceil(width / across)
        self.column = nn.Sequential(nn.Conv1d(sizes[-1] * height, 8 * channels, 1), nn.ReLU())
        azimuth = math.pi - 2 * math.pi * (AZIMUTH_STRIDE * torch.arange(width) + 0.5) / shape[1]
        self.register_buffer("azimuth", azimuth if wrap else torch.zeros(width), persistent=False)
        self.azimuth: Tensor
        self.frequencies = frequencies if wrap else 0
        self.direction = nn.Conv1d(8 * channels, 2, 1)
        pooled = 8 * channels * (1 + 2 * self.frequencies)
        self.position = nn.Sequential(nn.Dropout(0.2), nn.Linear(pooled, 256), nn.ReLU(), nn.Linear(256, 2))

    def forward(self, panoramas: Tensor) -> tuple[Tensor, Tensor]:
        """(n, 1, height, width) -> (n, 2) and (n, 2); the heading's vector is not of unit length."""
        columns = self.column(self.backbone(panoramas).flatten(1, 2))
        heading = self._turned(self.direction(columns)).mean(2)
        return self.position(self._pooled(columns, heading.detach())), heading

    def _turned(self, direction: Tensor) -> Tensor:
        """Where columns look (n, 2, width) -> where the robot does, for every one of them."""
        cos, sin = self.azimuth.cos(), self.azimuth.sin()
        x, y = direction.unbind(1)
        return torch.stack([x * cos + y * sin, y * cos - x * sin], 1)

    def _pooled(self, columns: Tensor, heading: Tensor) -> Tensor:
        """Columns (n, c, width) -> (n, c (1 + 2 frequencies)): mean, cosines and sines over the map's directions."""
        towards = torch.atan2(heading[:, 1], heading[:, 0])[:, None] + self.azimuth
        order = torch.arange(1, self.frequencies + 1)[:, None]
        waves = order * towards[:, None, :]
        basis = torch.cat([torch.ones_like(towards)[:, None], waves.cos(), waves.sin()], 1) / len(self.azimuth)
        return torch.bmm(columns, basis.transpose(1, 2)).flatten(1)


class Convolution(nn.Module):
    """A convolution and its normalisation; around the picture where ``wrap``, with zeros above and below."""

    def __init__(self, before: int, after: int, size: int, stride: tuple[int, int], *, wrap: bool) -> None:
        super().__init__()
        self.around = size // 2 if wrap else 0
        padding = (size // 2, 0 if wrap else size // 2)
        self.convolution = nn.Conv2d(before, after, size, stride, padding, bias=False)
        self.norm = nn.GroupNorm(after // CHANNEL_GROUP, after)

    def forward(self, maps: Tensor) -> Tensor:
        """(n, before, height, width) -> (n, after, ...)."""
        if self.around:
            maps = functional.pad(maps, (self.around, self.around, 0, 0), mode="circular")
        normalised: Tensor = self.norm(self.convolution(maps))
        return normalised


class Residual(nn.Module):
    """Two convolutions beside a shortcut."""

    def __init__(self, before: int, after: int, stride: tuple[int, int], *, wrap: bool) -> None:
        super().__init__()
        self.first = Convolution(before, after, 3, stride, wrap=wrap)
        self.second = Convolution(after, after, 3, (1, 1), wrap=wrap)
        same = before == after and stride == (1, 1)
        self.shortcut = nn.Identity() if same else Convolution(before, after, 1, stride, wrap=wrap)

    def forward(self, maps: Tensor) -> Tensor:
        """(n, before, height, width) -> (n, after, ...)."""
        return functional.relu(self.second(functional.relu(self.first(maps))) + self.shortcut(maps))
