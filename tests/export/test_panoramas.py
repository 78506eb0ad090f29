"""Unwrapping in a graph is what OpenCV does.

Whole blocks, smoothing and halving agree to the last pixel. Interpolation and averages over parts of pixels are sums in
single precision, whose last digit depends on the processor; where such a sum ends on a half it may be rounded the
other way: by one grey level, measured for 1 of 60,000 pixels of white noise and 1 of 260 where 24 rows become 7.
"""

import cv2
import numpy as np
import pytest

from andante.camera import PanoramaGeometry, Unwrapper
from andante.data import CameraSpec
from andante.export.panoramas import add_panorama

FISHEYE = CameraSpec(centre_px=(101.3, 98.2), radius_px=95.0)


def noise(shape, seed=0):
    return np.random.default_rng(seed).integers(0, 256, shape).astype(np.uint8)


def assert_same(found, expected, share: float) -> None:
    """The same but for a share of pixels that are off by one."""
    off = np.abs(found - expected.astype(np.float32))
    assert off.max() <= 1
    assert (off > 0).mean() <= share


@pytest.mark.parametrize(
    ("geometry", "halvings", "blur"),
    [
        (PanoramaGeometry(600, 90, 0, 85), 0, False),
        (PanoramaGeometry(200, 40, 3, 50), 0, True),
        (PanoramaGeometry(60, 12, 3, 50), 1, True),
        (PanoramaGeometry(30, 6, 3, 50), 2, True),
    ],
)
def test_fisheye(geometry, halvings, blur, run_piece):
    unwrapper = Unwrapper(FISHEYE, (199, 203), geometry)
    assert (unwrapper.lookup.halvings, unwrapper.lookup.blur) == (halvings, blur)
    for seed in range(5):
        image = noise((199, 203), seed)
        found = run_piece(lambda graph, name: add_panorama(graph, name, unwrapper), image, unwrapper.shape)
        assert_same(found, unwrapper(image), share=1e-3)


@pytest.mark.parametrize("spec", [
    CameraSpec(model="panorama"),
    CameraSpec(model="panorama", forward_deg=77.0),
    CameraSpec(model="panorama", forward_deg=-30.0, mirrored=True),
    CameraSpec(model="perspective"),
])  # fmt: skip
@pytest.mark.parametrize("size", [(48, 24), (97, 31), (48, 12), (48, 6), (48, 8), (32, 24), (37, 7), (200, 90)])
def test_panoramas_and_pictures(spec, size, run_piece):
    unwrapper = Unwrapper(spec, (24, 96), PanoramaGeometry(*size))
    image = noise((24, 96))
    found = run_piece(lambda graph, name: add_panorama(graph, name, unwrapper), image, unwrapper.shape)
    whole = all(old % new == 0 for old, new in zip(image.shape, unwrapper.shape, strict=True))
    assert_same(found, unwrapper(image), share=0 if whole else 0.01)


def test_positions_in_fixed_point(monkeypatch, run_piece):
    """OpenCV 4 rounds positions to 1/32 px."""
    unwrapper, image = Unwrapper(FISHEYE, (199, 203), PanoramaGeometry(600, 90, 0, 85)), noise((199, 203))
    remap = cv2.remap

    def coarse(image, x, y, interpolation):
        return remap(image, np.rint(x * 32) / np.float32(32), np.rint(y * 32) / np.float32(32), interpolation)

    monkeypatch.setattr("cv2.remap", coarse)
    found = run_piece(lambda graph, name: add_panorama(graph, name, unwrapper), image, unwrapper.shape)
    # Halves go up in fixed point, to even in this version of OpenCV.
    assert_same(found, unwrapper(image), share=0.01)
