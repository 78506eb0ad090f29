"""Cuts: what is at a pixel is what the panorama shows along its ray, and boxes go there and back."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.camera import PanoramaGeometry
from andante.errors import ConfigError, ImageError
from andante.landmarks.boxes import Box
from andante.landmarks.cuts import FILL, Cuts

GEOMETRY = PanoramaGeometry(720, 140, -20.0, 50.0)


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 7), st.floats(-0.6, 0.6), st.floats(-0.2, 0.6), st.floats(0.02, 0.5), st.floats(0.02, 0.5))
def test_boxes_go_to_a_cut_and_back(number, beside, elevation, width, height):
    cuts = Cuts(GEOMETRY)
    azimuth = float(np.angle(np.exp(1j * (cuts.azimuth_rad(number) + beside))))
    box = Box(azimuth, elevation, width, height)
    pixels = cuts.pixels(number, box)
    assert pixels is not None
    # The middle of a rectangle is not that of its angles, so elevations shift a little at the edge of a wide cut.
    assert cuts.box(number, pixels).iou(box) > 0.9


def test_a_bright_spot_is_where_its_direction_says():
    cuts = Cuts(GEOMETRY, count=6, wide_deg=100.0, size_px=200)
    for azimuth, elevation in ((0.1, 0.2), (np.pi - 0.01, -0.1), (-2.0, 0.5)):
        panorama = np.zeros((140, 720, 3), np.uint8)
        column = int((np.pi - azimuth) / (2 * np.pi) * 720)
        row = int((np.radians(50) - elevation) / np.radians(70) * 140)
        panorama[row - 1 : row + 2, np.mod(np.arange(column - 1, column + 2), 720)] = 255
        seen = 0
        for number, cut in enumerate(cuts(panorama)):
            cut[cut == FILL] = 0
            y, x = np.nonzero(cut[..., 0] > 100)
            if len(x):
                seen += 1
                box = cuts.box(number, (x.min(), y.min(), x.max() + 1.0, y.max() + 1.0))
                assert abs(np.angle(np.exp(1j * (box.azimuth_rad - azimuth)))) < 0.015
                assert box.elevation_rad == pytest.approx(elevation, abs=0.02)
        assert seen >= 1


def test_what_stands_upright_stands_upright():
    panorama = np.zeros((140, 720, 3), np.uint8)
    panorama[:, 300:304] = 255
    cut = Cuts(GEOMETRY, size_px=200)(panorama)[0]
    columns = [np.flatnonzero(row[:, 0] == 255).mean() for row in cut if (row[:, 0] == 255).sum() > 0]
    assert np.ptp(columns) < 1.0


def test_where_the_panorama_ends_the_cut_is_grey():
    cuts = Cuts(PanoramaGeometry(360, 30, 0.0, 30.0), size_px=100)
    cut = cuts(np.full((30, 360, 3), 7, np.uint8))[3]
    assert set(np.unique(cut)) == {7, FILL}
    assert (cut[0] == FILL).all()  # 63 degrees up
    assert (cut[-1] == 7).all()


def test_a_box_behind_a_cut_is_not_in_it():
    assert Cuts(GEOMETRY).pixels(0, Box(3.0, 0.0, 0.1, 0.1)) is None


@pytest.mark.parametrize("arguments", [{"count": 3}, {"count": 0}, {"count": 4, "wide_deg": 160.0}])
def test_cuts_that_leave_gaps_are_refused(arguments):
    with pytest.raises(ConfigError, match=r"leave gaps or are no pictures; take cuts"):
        Cuts(GEOMETRY, **arguments)


def test_a_panorama_of_another_size_is_refused():
    with pytest.raises(ImageError, match=r"need a BGR panorama of shape \(140, 720, 3\), got \(140, 720\)"):
        Cuts(GEOMETRY)(np.zeros((140, 720), np.uint8))


def test_a_panorama_of_the_ground_only_is_refused():
    with pytest.raises(ConfigError, match=r"shows nothing of what stands around"):
        Cuts(PanoramaGeometry(360, 30, -80.0, -50.0))
