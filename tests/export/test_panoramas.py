"""Unwrapping in a graph is what OpenCV does, to the last pixel."""

import numpy as np
import pytest

from andante.camera import PanoramaGeometry, Unwrapper
from andante.data import CameraSpec
from andante.export.panoramas import add_panorama

FISHEYE = CameraSpec(centre_px=(101.3, 98.2), radius_px=95.0)


def noise(shape, seed=0):
    return np.random.default_rng(seed).integers(0, 256, shape).astype(np.uint8)


@pytest.mark.parametrize(
    ("geometry", "halvings", "blur"),
    [
        (PanoramaGeometry(600, 90, 0, 85), 0, False),
        (PanoramaGeometry(300, 60, 3, 50), 0, True),
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
        np.testing.assert_array_equal(found, unwrapper(image))


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
    np.testing.assert_array_equal(found, unwrapper(image))


def test_positions_in_fixed_point(monkeypatch, run_piece):
    """OpenCV 4 rounds positions to 1/32 px; what it would make of a picture is worked out from its definition."""
    import cv2

    unwrapper = Unwrapper(FISHEYE, (199, 203), PanoramaGeometry(600, 90, 0, 85))
    remap = cv2.remap

    def coarse(image, x, y, interpolation):
        return remap(image, np.rint(x * 32) / np.float32(32), np.rint(y * 32) / np.float32(32), interpolation)

    monkeypatch.setattr("cv2.remap", coarse)
    image = noise((199, 203))
    found = run_piece(lambda graph, name: add_panorama(graph, name, unwrapper), image, unwrapper.shape)
    # Halves go up in fixed point, to even in floating point.
    assert np.abs(found - unwrapper(image).astype(float)).max() <= 1
    assert (found == unwrapper(image)).mean() > 0.99
