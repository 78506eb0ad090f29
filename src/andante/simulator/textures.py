"""Ten tileable textures that multiply the colour of a surface, with a pyramid against flicker in the distance."""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray
from andante.simulator.mesh import FloatArray32, Layer, f32
from andante.simulator.noise import tileable_noise

_SIZE = 256
_LEVELS = 8
_SEED = 20240601  # textures are the same in every garden

_PERIOD_M: dict[Layer, float] = {
    Layer.SMOOTH: 1.0,
    Layer.GRASS: 5.0,
    Layer.BRICK: 1.5,
    Layer.PLASTER: 3.0,
    Layer.TILES: 1.5,
    Layer.WOOD: 0.9,
    Layer.BARK: 0.8,
    Layer.LEAF: 0.6,
    Layer.STONE: 1.2,
    Layer.GRAVEL: 1.0,
}


class TextureAtlas:
    """All layers and their halved copies in one table of pixels."""

    def __init__(self) -> None:
        levels = [f32([_texture(layer) for layer in Layer])]
        while len(levels) < _LEVELS:
            fine = levels[-1]
            levels.append(f32((fine[:, ::2, ::2] + fine[:, 1::2, ::2] + fine[:, ::2, 1::2] + fine[:, 1::2, 1::2]) / 4))
        self._pixels = np.concatenate([level.reshape(-1, 3) for level in levels])
        sizes = np.array([_SIZE >> level for level in range(_LEVELS)])
        self._sizes = sizes.astype(np.int32)
        self._starts = np.concatenate([[0], np.cumsum(len(Layer) * sizes**2)[:-1]]).astype(np.int32)
        self._per_metre = f32([1.0 / _PERIOD_M[layer] for layer in Layer])

    def sample(self, layer: NDArray[np.int32], uv: FloatArray32, pixel_m: FloatArray32) -> FloatArray32:
        """Factors (k, 3) at ``uv`` (k, 2) metres; ``pixel_m`` (k,) is how wide a picture's pixel is there."""
        scale = self._per_metre[layer]
        coarse = np.log2(np.maximum(pixel_m * scale * np.float32(_SIZE), 1.0))
        level = np.minimum(coarse.astype(np.int32), _LEVELS - 1)
        size = self._sizes[level]
        position = uv * scale[:, None]
        texel = ((position - np.floor(position)) * size[:, None]).astype(np.int32)
        np.minimum(texel, size[:, None] - 1, out=texel)
        index = self._starts[level] + (layer * size + texel[:, 1]) * size + texel[:, 0]
        return np.asarray(self._pixels.take(index, axis=0), np.float32)


@cache
def texture_atlas() -> TextureAtlas:
    """The atlas, made once a process."""
    return TextureAtlas()


def _texture(layer: Layer) -> FloatArray:
    """(size, size, 3) factors of mean about 1; rows are v, columns u."""
    rng = np.random.default_rng(np.random.SeedSequence(_SEED, spawn_key=(int(layer),)))
    fine = tileable_noise(rng, _SIZE, 0.6)
    match layer:
        case Layer.SMOOTH:
            factor = np.ones((_SIZE, _SIZE))
        case Layer.GRASS:
            return _grass(rng, fine)
        case Layer.BRICK:
            return _bricks(rng, 6, 18, 0.10, 1.75)
        case Layer.TILES:
            factor = _tiles(rng) * (1.0 + 0.06 * fine)
        case Layer.WOOD:
            factor = _planks(rng)
        case Layer.BARK:
            factor = np.clip(1.0 + 0.3 * _stretched(rng, 5), 0.35, 1.8)
        case Layer.LEAF:
            factor = np.clip(1.0 + 0.28 * tileable_noise(rng, _SIZE, 1.1, 3.0), 0.4, 1.7)
        case Layer.PLASTER:
            factor = 1.0 + 0.05 * fine + 0.06 * tileable_noise(rng, _SIZE, 1.6)
        case Layer.STONE:
            factor = np.clip(1.0 + 0.18 * tileable_noise(rng, _SIZE, 1.2), 0.4, 1.7)
        case Layer.GRAVEL:
            factor = np.clip(1.0 + 0.3 * tileable_noise(rng, _SIZE, 0.8, 12.0), 0.3, 1.8)
    return np.repeat(factor[..., None], 3, axis=2)


def _grass(rng: np.random.Generator, fine: FloatArray) -> FloatArray:
    """Blades, and patches that are drier."""
    patches = tileable_noise(rng, _SIZE, 1.5)
    shade = np.clip(1.0 + 0.26 * fine, 0.35, 1.9)[..., None]
    dry = np.array([0.16, 0.05, 0.02]) * patches[..., None]
    return np.asarray(np.clip(shade * (1.0 + dry), 0.2, 2.2), np.float64)


def _bricks(rng: np.random.Generator, across: int, rows: int, joint: float, mortar: float) -> FloatArray:
    """Courses in running bond, every brick of its own shade, paler and greyer joints."""
    v, u = np.mgrid[0:_SIZE, 0:_SIZE] / _SIZE
    row = np.floor(v * rows).astype(int)
    shifted = u * across + 0.5 * (row % 2)
    column = np.floor(shifted).astype(int) % across
    shade = rng.uniform(0.72, 1.22, (rows, across))[row, column]
    in_joint = ((v * rows) % 1.0 < 2.0 * joint) | (shifted % 1.0 < joint)
    grey = np.array([0.95, 1.55, 2.0]) / 1.5 * mortar
    bricks = np.where(in_joint[..., None], grey, shade[..., None])
    return np.asarray(bricks * (1.0 + 0.08 * tileable_noise(rng, _SIZE, 0.5))[..., None], np.float64)


def _tiles(rng: np.random.Generator) -> FloatArray:
    """Rows of roof tiles, dark under each lower edge."""
    v, u = np.mgrid[0:_SIZE, 0:_SIZE] / _SIZE
    rows, across = 5, 6
    row = np.floor(v * rows).astype(int)
    shifted = u * across + 0.5 * (row % 2)
    shade = rng.uniform(0.8, 1.2, (rows, across))[row, np.floor(shifted).astype(int) % across]
    rounding = 0.82 + 0.3 * np.sin(np.pi * (shifted % 1.0))
    lower_edge = np.where((v * rows) % 1.0 < 0.12, 0.5, 1.0)
    return np.asarray(shade * rounding * lower_edge, np.float64)


def _planks(rng: np.random.Generator) -> FloatArray:
    """Upright boards with grain along v."""
    u = np.arange(_SIZE)[None, :] / _SIZE
    boards = 6
    shade = rng.uniform(0.82, 1.15, boards)[np.floor(u * boards).astype(int)]
    gap = np.where((u * boards) % 1.0 < 0.05, 0.4, 1.0)
    return np.asarray(shade * gap * np.clip(1.0 + 0.12 * _stretched(rng, 10), 0.5, 1.5), np.float64)


def _stretched(rng: np.random.Generator, factor: int) -> FloatArray:
    """Noise drawn out along v, still tileable."""
    rows = np.fft.fftfreq(_SIZE)[:, None] * _SIZE * factor
    columns = np.fft.rfftfreq(_SIZE)[None, :] * _SIZE
    gain = np.maximum(np.hypot(rows, columns), 2.0) ** -0.9
    noise = np.fft.irfft2(np.fft.rfft2(rng.standard_normal((_SIZE, _SIZE))) * gain, (_SIZE, _SIZE))
    return np.asarray((noise - noise.mean()) / noise.std(), np.float64)
