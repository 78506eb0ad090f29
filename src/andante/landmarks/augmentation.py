"""The same panoramas in other light, weather and season, from a robot that is turned or tilted, with things in between.

A place is taught in one afternoon and looked at all year. What a landmark detector must not rely on is therefore made
random while it learns: heading and tilt of the robot; strength, colour and direction of the light; contrast and colours
altogether, up to none; leaves of any colour; snow on what lies low; clouds; blur and noise of the camera; and things
that stand in the way. Where they cover a landmark nearly whole, it is not there to be found. Pictures are BGR
(n, 3, height, width) float32, 0 to 1. Imported only by what learns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from andante.data import FloatArray, ImageArray
from andante.landmarks.heatmaps import Grid

_TILT_PX = 3.0
_PRESENT, _GONE = 0.6, 0.85
"""A landmark covered by less than the first share is there, by more than the second is not, and between is not told."""
_LIKELY_COVERED = 0.3
_OTHER_THINGS = 3
_CLOUDS = 5, 16


@dataclass(frozen=True, slots=True)
class Batch:
    """What one step learns from: pictures, boxes (n, k, 4) in cells, and whether each counts (n, k)."""

    pictures: Tensor
    cells: FloatArray
    counts: NDArray[np.bool_]


def augmented(
    panoramas: ImageArray, cells: FloatArray, known: NDArray[np.bool_], grid: Grid, rng: np.random.Generator
) -> Batch:
    """Panoramas (n, height, width, 3) uint8 with boxes (n, k, 4) in cells, all made another.

    All that is random comes from ``rng``.
    """
    torch_rng = torch.Generator().manual_seed(int(rng.integers(2**62)))
    pictures = as_pictures(panoramas)
    pictures, cells = _moved(pictures, cells, grid, rng)
    pictures = _relit(_recoloured(pictures, torch_rng), torch_rng)
    pictures, covered = _occluded(pictures, cells, grid, rng)
    pictures = _sensed(pictures, torch_rng, rng)
    share = _covered_share(covered, cells, grid)
    gone = share > _GONE
    cells = np.where(gone[..., None], np.nan, cells)
    return Batch(pictures, cells, known & ~((share > _PRESENT) & ~gone))


def as_pictures(panoramas: ImageArray) -> Tensor:
    """(n, height, width, 3) uint8 as (n, 3, height, width) from 0 to 1."""
    return torch.from_numpy(np.ascontiguousarray(panoramas.transpose(0, 3, 1, 2))).float() / 255.0


def _moved(pictures: Tensor, cells: FloatArray, grid: Grid, rng: np.random.Generator) -> tuple[Tensor, FloatArray]:
    """Turned by any number of columns, and tilted: the horizon becomes one period of a sine."""
    count, _, height, width = pictures.shape
    shift = rng.integers(width, size=count)
    tilt, towards = rng.uniform(0.0, _TILT_PX, count), rng.uniform(0.0, 2.0 * np.pi, count)
    columns = np.mod(np.arange(width)[None, :] - shift[:, None], width)
    turned = torch.gather(pictures, 3, torch.from_numpy(columns)[:, None, None, :].expand(pictures.shape))

    def sunk(column_px: FloatArray) -> FloatArray:
        """How far down the tilt moves what is at a column (n, m), in pixels."""
        return np.asarray(tilt[:, None] * np.cos(2.0 * np.pi * column_px / width - towards[:, None]))

    rows = np.arange(height)[None, :, None] - sunk(np.broadcast_to(np.arange(width) + 0.5, (count, width)))[:, None, :]
    at = np.stack(np.broadcast_arrays((2 * np.arange(width) + 1) / width - 1.0, (2 * rows + 1) / height - 1.0), axis=-1)
    tilted = functional.grid_sample(
        turned, torch.from_numpy(at.astype(np.float32)), padding_mode="border", align_corners=False
    )
    moved = cells.copy()
    moved[..., 0] = np.mod(cells[..., 0] + shift[:, None] / grid.stride, grid.columns)
    moved[..., 1] += sunk((moved[..., 0] + 0.5) * grid.stride) / grid.stride
    return tilted, moved


def _recoloured(pictures: Tensor, rng: torch.Generator) -> Tensor:
    """Leaves of another colour, snow on what lies low, channels mixed, colours paler or gone."""
    count, _, height, _ = pictures.shape
    blue, green, red = pictures.unbind(1)
    leafy = (green - torch.maximum(blue, red)).clamp(min=0.0)
    leafy = (8.0 * leafy / (green + 0.05)).clamp(max=1.0)[:, None]
    leaf = _uniform(rng, (count, 3, 1, 1), 0.3, 1.9) * pictures
    pictures = torch.lerp(pictures, leaf, leafy * _sometimes(rng, count, 0.5) * _uniform(rng, (count, 1, 1, 1)))

    below = torch.arange(height)[None, None, :, None] - _uniform(rng, (count, 1, 1, 1), 0.6, 1.0) * height
    snow = torch.sigmoid(below / 2.0) * _uniform(rng, (count, 1, 1, 1), 0.2, 0.9) * _sometimes(rng, count, 0.25)
    white = _uniform(rng, (count, 1, 1, 1), 0.7, 1.0) * (0.6 + 0.4 * pictures.mean(1, keepdim=True))
    pictures = torch.lerp(pictures, white, snow)

    mixing = torch.eye(3) + 0.08 * torch.randn((count, 3, 3), generator=rng)
    mixing = mixing * torch.exp(0.15 * torch.randn((count, 3, 1), generator=rng))
    pictures = torch.einsum("nij,njhw->nihw", mixing, pictures)
    pale = torch.maximum(_uniform(rng, (count, 1, 1, 1)) ** 2, _sometimes(rng, count, 0.15))
    return torch.lerp(pictures, pictures.mean(1, keepdim=True), pale).clamp(0.0, 1.0)


def _relit(pictures: Tensor, rng: torch.Generator) -> Tensor:
    """Gamma here and there, clouds, light from another side, more or less of it, more or less contrast."""
    count, _, height, width = pictures.shape
    gamma = 0.35 * torch.randn((count, 1, 1, 1), generator=rng) + 0.35 * _smooth(count, height, width, rng)
    pictures = pictures.clamp(min=1e-3) ** gamma.clamp(-1.0, 1.0).exp()
    pictures = pictures + 0.15 * _uniform(rng, (count, 1, 1, 1)) * _smooth(count, height, width, rng) * pictures
    azimuth = 2.0 * np.pi * torch.arange(width)[None, None, None, :] / width
    slope = _uniform(rng, (count, 1, 1, 1), 0.0, 0.4) * torch.cos(azimuth - _uniform(rng, (count, 1, 1, 1), 0.0, 6.3))
    gain = torch.exp(slope + 0.3 * torch.randn((count, 1, 1, 1), generator=rng))
    contrast = torch.exp(_uniform(rng, (count, 1, 1, 1), -0.6, 0.3))
    mean = pictures.mean(dim=(1, 2, 3), keepdim=True)
    return (mean + contrast * (pictures * gain - mean)).clamp(0.0, 1.0)


def _sensed(pictures: Tensor, torch_rng: torch.Generator, rng: np.random.Generator) -> Tensor:
    """Blurred now and then, and noisy; grey levels 0..255 again."""
    for row in np.flatnonzero(rng.random(len(pictures)) < 0.25):
        padded = functional.pad(pictures[row : row + 1], (1, 1, 1, 1), mode="replicate")
        pictures[row] = functional.avg_pool2d(padded, 3, 1)[0]
    noise = _uniform(torch_rng, (len(pictures), 1, 1, 1), 0.0, 0.04)
    noisy = pictures + noise * torch.randn(pictures.shape, generator=torch_rng)
    return 255.0 * noisy.clamp(0.0, 1.0)


def _occluded(
    pictures: Tensor, cells: FloatArray, grid: Grid, rng: np.random.Generator
) -> tuple[Tensor, NDArray[np.bool_]]:
    """Things in front of landmarks and anywhere; and which pixels (n, height, width) they cover."""
    count, _, height, width = pictures.shape
    covered = np.zeros((count, height, width), np.bool_)
    pictures = pictures.clone()
    pixels = (cells + np.array([0.5, 0.5, 0.0, 0.0])) * grid.stride
    for row in range(count):
        covers = [_any_place(height, width, rng) for _ in range(int(rng.integers(_OTHER_THINGS + 1)))]
        for box in pixels[row]:
            if np.isfinite(box[0]) and rng.random() < _LIKELY_COVERED:
                covers.append(_before(box, rng))
        for x, y, w, h in covers:
            rows = slice(max(int(y), 0), max(int(y + h), 0))
            columns = np.arange(int(x), int(x + max(w, 1.0))) % width
            if not (np.arange(height)[rows].size and columns.size):
                continue
            other = pictures[int(rng.integers(count)), :, rows, :]
            start = int(rng.integers(width))
            # A piece of another picture, upside down: the right way up it could be the landmark itself.
            cover = other[:, :, (start + np.arange(len(columns))) % width].flip(1)
            if rng.random() < 0.6:  # nearly of one colour
                cover = 0.15 * cover + 0.85 * torch.from_numpy(rng.random((3, 1, 1)).astype(np.float32))
            pictures[row, :, rows, columns] = cover
            covered[row, rows, columns] = True
    return pictures, covered


def _any_place(height: int, width: int, rng: np.random.Generator) -> tuple[float, float, float, float]:
    """Left, top, width and height of something that stands low, as things do."""
    w, h = width * rng.uniform(0.01, 0.12), height * rng.uniform(0.1, 0.7)
    return rng.uniform(0, width), height * rng.uniform(0.5, 1.1) - h, w, h


def _before(box: FloatArray, rng: np.random.Generator) -> tuple[float, float, float, float]:
    """Left, top, width and height of something in front of a box: from below, from a side, or all of it."""
    x, y, w, h = box[0] - box[2] / 2.0, box[1] - box[3] / 2.0, box[2], box[3]
    share, side = rng.uniform(0.2, 1.3), rng.integers(3)
    if side == 0:
        return x - 2.0, y + (1.0 - min(share, 1.1)) * h, w + 4.0, h * min(share, 1.1) + 4.0
    across = w * min(share, 1.1)
    return (x - 2.0 if side == 1 else x + w - across), y - 2.0, across + 2.0, h + 6.0


def _covered_share(covered: NDArray[np.bool_], cells: FloatArray, grid: Grid) -> FloatArray:
    """(n, k) which share of each box is covered, 0 where there is none."""
    height, width = covered.shape[1:]
    share = np.zeros(cells.shape[:2])
    pixels = (cells + np.array([0.5, 0.5, 0.0, 0.0])) * grid.stride
    for row, landmark in zip(*np.nonzero(np.isfinite(cells[..., 0])), strict=True):
        x, y, w, h = pixels[row, landmark]
        rows = np.arange(max(int(y - h / 2.0), 0), min(int(y + h / 2.0) + 1, height))
        columns = np.arange(int(x - w / 2.0), int(x + w / 2.0) + 1) % width
        if len(rows):
            share[row, landmark] = covered[row][np.ix_(rows, columns)].mean()
    return share


def _smooth(count: int, height: int, width: int, rng: torch.Generator) -> Tensor:
    """Random fields (n, 1, height, width) without a seam, of deviation about 1/2."""
    coarse = torch.randn((count, 1, *_CLOUDS), generator=rng)
    coarse = torch.cat([coarse, coarse[..., :1]], dim=3)
    return functional.interpolate(coarse, (height, width + width // _CLOUDS[1]), mode="bilinear")[..., :width]


def _uniform(rng: torch.Generator, shape: tuple[int, ...], low: float = 0.0, high: float = 1.0) -> Tensor:
    return low + (high - low) * torch.rand(shape, generator=rng)


def _sometimes(rng: torch.Generator, count: int, probability: float) -> Tensor:
    """(n, 1, 1, 1) of ones and zeros."""
    return (torch.rand((count, 1, 1, 1), generator=rng) < probability).float()
