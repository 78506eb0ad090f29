"""The same panoramas in other light, weather and season, from a robot that is turned or tilted, with things in between.

A place is taught in one afternoon and looked at all year. What a landmark detector must not rely on is therefore made
random while it learns: heading and tilt of the robot; strength, colour and direction of the light; contrast and colours
altogether; leaves of any colour; snow on what lies low; clouds; blur and noise of the camera; and things that stand in
the way. Where they cover a landmark nearly whole, it is not there to be found. The anchor that it was taught with is
covered in half of the pictures and copied to another place in half, so that it says nothing. Half of the pictures have
no colour, since maps look at grey ones. Pictures are BGR (n, 3, height, width) float32, 0 to 1. Imported only by what
learns.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor
from torch.nn import functional

from andante.data import FloatArray
from andante.landmarks.examples import Examples
from andante.landmarks.heatmaps import Grid

_TILT_PX = 3.0
_Extent = tuple[float, float, float, float]
_PRESENT, _GONE = 0.6, 0.85
"""A landmark covered by less than the first share is there, by more than the second is not, and between is not told."""
_LIKELY_COVERED = 0.3
_OTHER_THINGS = 3
_CLOUDS = 5, 16
_LOCAL_GAMMA = 1.2
_GREY = 0.5
_BGR_TO_GREY = 0.114, 0.587, 0.299
_ALIKE = 0.12
"""Colours this far apart count as alike."""


@dataclass(frozen=True, slots=True)
class Batch:
    """What one step learns from: pictures, boxes (n, k, 4) in cells, and whether each counts (n, k)."""

    pictures: Tensor
    cells: FloatArray
    counts: NDArray[np.bool_]


def augmented(examples: Examples, grid: Grid, rng: np.random.Generator) -> Batch:
    """Examples, all made another; all that is random comes from ``rng``."""
    landmarks = examples.known.shape[1]
    torch_rng = torch.Generator().manual_seed(int(rng.integers(2**62)))
    pictures = torch.from_numpy(np.ascontiguousarray(examples.panoramas.transpose(0, 3, 1, 2))).float() / 255.0
    pictures, boxes = _moved(pictures, np.concatenate([examples.cells, examples.anchors], axis=1), grid, rng)
    cells, anchors = boxes[:, :landmarks], boxes[:, landmarks:]
    # From hardly another day to quite another one.
    changed = _relit(_recoloured(pictures, torch_rng), torch_rng)
    pictures = torch.lerp(pictures, changed, _uniform(torch_rng, (len(pictures), 1, 1, 1), 0.2, 1.0))
    pictures, covered = _occluded(pictures, cells, anchors, grid, rng)
    pictures = _greyed(pictures, torch_rng)
    pictures = _sensed(pictures, torch_rng, rng)
    share = _covered_share(covered, cells, grid)
    gone = share > _GONE
    cells = np.where(gone[..., None], np.nan, cells)
    return Batch(pictures, cells, examples.known & ~((share > _PRESENT) & ~gone))


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
    """Things of one colour in another, leaves above all; snow on what lies low; channels mixed, paler or gone."""
    count, _, height, width = pictures.shape
    place = torch.randint(height * width, (count, 1, 1), generator=rng).expand(count, 3, 1)
    colour = pictures.flatten(2).gather(2, place)[..., None]
    alike = torch.exp(-(pictures - colour).square().sum(1, keepdim=True) / (2.0 * _ALIKE**2))
    another = _uniform(rng, (count, 3, 1, 1)) * (0.5 + pictures.mean(1, keepdim=True))
    pictures = torch.lerp(pictures, another, alike * _uniform(rng, (count, 1, 1, 1)) * _sometimes(rng, count, 0.5))

    blue, green, red = pictures.unbind(1)
    leafy = (green - torch.maximum(blue, red)).clamp(min=0.0)
    leafy = (8.0 * leafy / (green + 0.05)).clamp(max=1.0)[:, None]
    leaf = _uniform(rng, (count, 3, 1, 1), 0.3, 1.9) * pictures
    pictures = torch.lerp(pictures, leaf, leafy * _sometimes(rng, count, 0.5) * _uniform(rng, (count, 1, 1, 1)))

    below = torch.arange(height)[None, None, :, None] - _uniform(rng, (count, 1, 1, 1), 0.6, 1.0) * height
    lying = _uniform(rng, (count, 1, 1, 1), 0.2, 0.9) + 0.5 * torch.randn((count, 1, height, width), generator=rng)
    snow = torch.sigmoid(below / 2.0) * lying.clamp(0.0, 1.0) * _sometimes(rng, count, 0.3)
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
    # Up to what the sun makes of a wall when it is behind it.
    here_and_there = _uniform(rng, (count, 1, 1, 1), 0.0, _LOCAL_GAMMA) * _smooth(count, height, width, rng)
    gamma = 0.35 * torch.randn((count, 1, 1, 1), generator=rng) + here_and_there
    pictures = pictures.clamp(min=1e-3) ** gamma.clamp(-1.4, 1.4).exp()
    pictures = pictures + 0.15 * _uniform(rng, (count, 1, 1, 1)) * _smooth(count, height, width, rng) * pictures
    azimuth = 2.0 * np.pi * torch.arange(width)[None, None, None, :] / width
    slope = _uniform(rng, (count, 1, 1, 1), 0.0, 0.4) * torch.cos(azimuth - _uniform(rng, (count, 1, 1, 1), 0.0, 6.3))
    gain = torch.exp(slope + 0.3 * torch.randn((count, 1, 1, 1), generator=rng))
    contrast = torch.exp(_uniform(rng, (count, 1, 1, 1), -0.6, 0.3))
    mean = pictures.mean(dim=(1, 2, 3), keepdim=True)
    return (mean + contrast * (pictures * gain - mean)).clamp(0.0, 1.0)


def _greyed(pictures: Tensor, rng: torch.Generator) -> Tensor:
    """Half of them without any colour, as maps look at pictures: what is learnt by colour is not found in those."""
    grey = torch.einsum("c,nchw->nhw", torch.tensor(_BGR_TO_GREY), pictures)[:, None]
    return torch.lerp(pictures, grey.expand(pictures.shape), _sometimes(rng, len(pictures), _GREY))


def _sensed(pictures: Tensor, torch_rng: torch.Generator, rng: np.random.Generator) -> Tensor:
    """Blurred now and then, and noisy; grey levels 0..255 again."""
    for row in np.flatnonzero(rng.random(len(pictures)) < 0.25):
        padded = functional.pad(pictures[row : row + 1], (1, 1, 1, 1), mode="replicate")
        pictures[row] = functional.avg_pool2d(padded, 3, 1)[0]
    noise = _uniform(torch_rng, (len(pictures), 1, 1, 1), 0.0, 0.04)
    noisy = pictures + noise * torch.randn(pictures.shape, generator=torch_rng)
    return 255.0 * noisy.clamp(0.0, 1.0)


def _occluded(
    pictures: Tensor, cells: FloatArray, anchors: FloatArray, grid: Grid, rng: np.random.Generator
) -> tuple[Tensor, NDArray[np.bool_]]:
    """Things in front of landmarks and anywhere, anchors gone or elsewhere; which pixels (n, height, width) changed."""
    count, _, height, width = pictures.shape
    covered = np.zeros((count, height, width), np.bool_)
    before = pictures
    pictures = pictures.clone()
    for row in range(count):
        covers = [_any_place(height, width, rng) for _ in range(int(rng.integers(_OTHER_THINGS + 1)))]
        for box in _pixels(cells[row], grid):
            if rng.random() < _LIKELY_COVERED:
                covers.append(_before(box, rng))
        for box in _pixels(np.unique(anchors[row], axis=0), grid):
            x, y, w, h = box[0] - 0.6 * box[2], box[1] - 0.6 * box[3], 1.2 * box[2], 1.2 * box[3]
            if rng.random() < 0.5:
                rows, from_columns = _area((x, y, w, h), height, width)
                to_columns = (from_columns + int(rng.integers(width))) % width
                pictures[row][:, rows[:, None], to_columns] = before[row][:, rows[:, None], from_columns]
                covered[row][np.ix_(rows, to_columns)] = True
            if rng.random() < 0.5:
                covers.append((x, y, w, h))
        for area in covers:
            rows, columns = _area(area, height, width)
            # A piece of another picture, upside down: the right way up it could be the landmark itself.
            start, other = int(rng.integers(width)), before[int(rng.integers(count))]
            cover = other[:, rows[::-1, None].copy(), (start + np.arange(len(columns))) % width]
            if rng.random() < 0.6:  # nearly of one colour
                cover = 0.15 * cover + 0.85 * torch.from_numpy(rng.random((3, 1, 1)).astype(np.float32))
            pictures[row][:, rows[:, None], columns] = cover
            covered[row][np.ix_(rows, columns)] = True
    return pictures, covered


def _pixels(cells: FloatArray, grid: Grid) -> FloatArray:
    """Those of boxes (m, 4) in cells that are there, in pixels from the upper left corner."""
    there = cells[np.isfinite(cells[:, 0])]
    return np.asarray((there + np.array([0.5, 0.5, 0.0, 0.0])) * grid.stride, np.float64)


def _area(extent: _Extent, height: int, width: int) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Rows inside of the picture, and columns around the horizon, of left, top, width and height."""
    x, y, w, h = extent
    rows = np.arange(max(int(y), 0), min(int(np.ceil(y + h)), height), dtype=np.int64)
    return rows, np.arange(int(x), int(x) + max(min(int(np.ceil(w)), width), 1), dtype=np.int64) % width


def _any_place(height: int, width: int, rng: np.random.Generator) -> _Extent:
    """Left, top, width and height of something that stands low, as things do."""
    w, h = width * rng.uniform(0.01, 0.12), height * rng.uniform(0.1, 0.7)
    return rng.uniform(0, width), height * rng.uniform(0.5, 1.1) - h, w, h


def _before(box: FloatArray, rng: np.random.Generator) -> _Extent:
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
    for row, landmark in zip(*np.nonzero(np.isfinite(cells[..., 0])), strict=True):
        ((x, y, w, h),) = _pixels(cells[row, landmark : landmark + 1], grid)
        rows, columns = _area((x - w / 2.0, y - h / 2.0, w, h), height, width)
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
