"""A panorama shows the world at its azimuths and elevations, whatever camera took it."""

import csv
from dataclasses import replace
from pathlib import Path

import cv2
import numpy as np
import pytest
from numpy.typing import NDArray

from andante.camera import PanoramaGeometry, Unwrapper, project, rays, scaled
from andante.data import CameraSpec, FloatArray, ImageArray
from andante.errors import ConfigError, ImageError

GEOMETRY = PanoramaGeometry()
UP = CameraSpec(centre_px=(239.5, 239.5), radius_px=240.0)

CAMERAS = {
    "plain": UP,
    "forward": replace(UP, forward_deg=77.0),
    "mirrored": replace(UP, mirrored=True, forward_deg=-31.0),
    "equisolid": replace(UP, projection="equisolid", field_of_view_deg=200.0),
    "stereographic": replace(UP, projection="stereographic"),
    "kannala-brandt": replace(UP, projection="kannala-brandt", coefficients=(0.02, -0.004, 0.0, 0.0)),
    "ocam": replace(UP, projection="ocam", radius_px=None, coefficients=(150.0, 0.0, -0.0027)),
    "down-mirror": replace(UP, facing="down-mirror", field_of_view_deg=290.0, projection="stereographic"),
    "down-mirror, mirrored": replace(UP, facing="down-mirror", field_of_view_deg=290.0, mirrored=True),
    "off centre": replace(UP, centre_px=(233.2, 244.9), radius_px=230.0),
}


def world(azimuth: FloatArray, elevation: FloatArray) -> FloatArray:
    """A smooth brightness of every direction, different for each."""
    return 128 + 50 * np.cos(azimuth - 0.4) + 30 * np.sin(3 * azimuth + 4 * elevation) + 40 * np.sin(5 * elevation)


def picture(spec: CameraSpec, shape: tuple[int, int] = (480, 480)) -> ImageArray:
    azimuth, elevation, valid = rays(spec, shape)
    return np.where(valid, np.clip(np.rint(world(azimuth, elevation)), 0, 255), 0).astype(np.uint8)


def expected(geometry: PanoramaGeometry = GEOMETRY) -> FloatArray:
    return np.clip(world(geometry.azimuths_rad()[None, :], geometry.elevations_rad()[:, None]), 0, 255)


@pytest.mark.parametrize("spec", CAMERAS.values(), ids=CAMERAS.keys())
def test_every_camera_gives_the_same_panorama(spec: CameraSpec) -> None:
    unwrapper = Unwrapper(spec, (480, 480), GEOMETRY)
    panorama = unwrapper(picture(spec))
    assert panorama.shape == unwrapper.shape == (60, 600)
    assert panorama.dtype == np.uint8
    assert unwrapper.valid.mean() > 0.95  # one camera is off centre and a little cut off
    error = np.abs(panorama - expected())[unwrapper.valid]
    assert error.max() < 4.0
    assert error.mean() < 0.6


@pytest.mark.parametrize("scale", [0.25, 0.5, 1.0, 3.0])
def test_pictures_of_another_scale_give_the_same_panorama(scale: float) -> None:
    size = int(480 * scale)
    spec = replace(UP, forward_deg=20.0)
    image = picture(scaled(spec, scale), (size, size))
    panorama = Unwrapper(spec, (size, size), GEOMETRY, scale=scale)(image)
    assert np.abs(panorama - expected()).mean() < (0.5 if scale >= 1.0 else 1.0)


def test_turning_the_camera_shifts_the_columns() -> None:
    steps = 37
    turned = replace(UP, forward_deg=steps * 360.0 / 600)
    image = np.random.default_rng(0).integers(0, 256, (480, 480), np.uint8)
    plain = Unwrapper(UP, (480, 480), GEOMETRY)(image).astype(int)
    shifted = Unwrapper(turned, (480, 480), GEOMETRY)(image).astype(int)
    # Forward further left in the image: what was left of forward comes to the middle, so all moves right.
    assert np.abs(np.roll(plain, steps, axis=1) - shifted).max() <= 1


def test_the_seam_is_like_any_other_pair_of_columns() -> None:
    panorama = Unwrapper(UP, (480, 480), GEOMETRY)(picture(UP)).astype(int)
    steps = np.abs(panorama - np.roll(panorama, 1, axis=1)).mean(axis=0)
    assert steps[0] <= steps[1:].max()


def test_colour_channels_are_unwrapped_one_by_one() -> None:
    channels = [picture(replace(UP, forward_deg=angle)) for angle in (0.0, 50.0, 100.0)]
    unwrapper = Unwrapper(UP, (480, 480))
    panorama = unwrapper(np.dstack(channels))
    assert panorama.shape == (60, 600, 3)
    for index, channel in enumerate(channels):
        np.testing.assert_allclose(panorama[..., index].astype(int), unwrapper(channel).astype(int), atol=1)


def averaged(spec: CameraSpec, image: ImageArray, samples: int = 12) -> FloatArray:
    """The slow reference: each panorama pixel the mean of many samples."""
    fine = PanoramaGeometry(GEOMETRY.width_px * samples, GEOMETRY.height_px * samples)
    x_px, y_px = project(spec, fine.azimuths_rad()[None, :], fine.elevations_rad()[:, None])
    sampled = cv2.remap(
        image.astype(np.float32), x_px.astype(np.float32), y_px.astype(np.float32), cv2.INTER_LINEAR
    ).astype(np.float64)
    return sampled.reshape(GEOMETRY.height_px, samples, GEOMETRY.width_px, samples).mean(axis=(1, 3))


def checkerboard(size: int) -> ImageArray:
    rows, columns = np.mgrid[:size, :size]
    return (255 * ((rows + columns) % 2)).astype(np.uint8)


@pytest.mark.parametrize("factor", [1, 2, 3])
def test_a_fine_checkerboard_becomes_grey(factor: int) -> None:
    size = 480 * factor
    panorama = Unwrapper(UP, (size, size), GEOMETRY, scale=factor)(checkerboard(size)).astype(float)
    assert np.abs(panorama - 127.5).max() < 4.0


@pytest.mark.parametrize(("factor", "most"), [(1, 10.0), (2, 11.0), (3, 8.0)])
def test_noise_is_averaged_like_the_slow_reference(factor: int, most: float) -> None:
    size = 480 * factor
    image = np.random.default_rng(0).integers(0, 256, (size, size), np.uint8)
    error = Unwrapper(UP, (size, size), GEOMETRY, scale=factor)(image) - averaged(scaled(UP, factor), image)
    assert np.sqrt((error**2).mean()) < most  # without smoothing 29, 44 and 47


def test_what_the_camera_does_not_see_is_held_and_marked() -> None:
    below = PanoramaGeometry(min_deg=-20.0, max_deg=40.0)
    unwrapper = Unwrapper(UP, (480, 480), below)
    np.testing.assert_array_equal(unwrapper.valid, np.broadcast_to(below.elevations_rad()[:, None] > 0, (60, 600)))
    panorama = unwrapper(np.full((480, 480), 200, np.uint8))
    assert (panorama == 200).all()
    cut = Unwrapper(replace(UP, centre_px=(239.5, 169.5)), (410, 480))
    assert 0.7 < cut.valid.mean() < 0.95
    assert (cut(np.full((410, 480), 200, np.uint8)) == 200).all()
    assert not cut.valid.flags.writeable


@pytest.mark.parametrize("model", ["panorama", "perspective"])
def test_unwrapped_pictures_shrink_but_never_grow(model: str) -> None:
    spec = CameraSpec(model=model)  # type: ignore[arg-type]
    image = np.random.default_rng(0).integers(0, 256, (25, 120), np.uint8)
    assert Unwrapper(spec, image.shape, GEOMETRY).shape == (25, 120)
    np.testing.assert_array_equal(Unwrapper(spec, image.shape, GEOMETRY)(image), image)
    np.testing.assert_array_equal(Unwrapper(spec, image.shape)(image), image)
    small = Unwrapper(spec, image.shape, PanoramaGeometry(40, 60))
    assert small.shape == small.valid.shape == (25, 40)
    means = image.reshape(25, 40, 3).mean(axis=2)
    np.testing.assert_allclose(small(image), means, atol=0.5)


def test_a_panorama_keeps_its_columns_circular() -> None:
    image = np.random.default_rng(0).integers(0, 256, (60, 1200), np.uint8)
    unwrapper = Unwrapper(CameraSpec(model="panorama"), image.shape, GEOMETRY)
    np.testing.assert_array_equal(unwrapper(np.roll(image, 2, axis=1)), np.roll(unwrapper(image), 1, axis=1))


def test_forward_and_mirrored_panoramas_are_turned() -> None:
    image = np.zeros((10, 360), np.uint8)
    image[:, 90] = 255  # 90 degrees left of the middle column
    ahead = Unwrapper(CameraSpec(model="panorama", forward_deg=90.0), image.shape)(image)
    assert ahead[0].argmax() == 180
    mirrored = Unwrapper(CameraSpec(model="panorama", mirrored=True), image.shape)(image)
    assert mirrored[0].argmax() == 360 - 1 - 90
    both = Unwrapper(CameraSpec(model="panorama", mirrored=True, forward_deg=90.0), image.shape)(image)
    assert both[0].argmax() == 360 - 1 - 180


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"width_px": 0}, "at least 1, got 0 and 60"),
        ({"min_deg": 50.0}, "min_deg 50 and max_deg 50"),
        ({"max_deg": 91.0}, "got min_deg 5 and max_deg 91"),
        ({"min_deg": float("nan")}, "min_deg nan"),
    ],
)
def test_empty_panoramas_are_refused(arguments: dict[str, float], message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        PanoramaGeometry(**arguments)  # type: ignore[arg-type]


def test_faults_are_named() -> None:
    with pytest.raises(ConfigError, match="find the image circle"):
        Unwrapper(CameraSpec(), (480, 480))
    with pytest.raises(ConfigError, match="sees nothing between 5 and 50 degrees"):
        Unwrapper(replace(UP, field_of_view_deg=60.0), (480, 480))
    with pytest.raises(ConfigError, match="check these and the scale"):
        Unwrapper(replace(UP, centre_px=(2000.0, 2000.0)), (480, 480))
    with pytest.raises(ConfigError, match="forward_deg must be 0 for a panorama of only 180 degrees"):
        Unwrapper(CameraSpec(model="panorama", horizontal_field_of_view_deg=180.0, forward_deg=9.0), (10, 20))
    with pytest.raises(ImageError, match="at least one pixel"):
        Unwrapper(UP, (0, 480))


@pytest.mark.parametrize(
    "image", [np.zeros((480, 479), np.uint8), np.zeros((480, 480, 4), np.uint8), np.zeros((480, 480))]
)
def test_other_images_are_refused(image: NDArray[np.generic]) -> None:
    with pytest.raises(
        ImageError, match=r"cannot unwrap an image of shape .* takes \(480, 480\) or \(480, 480, 3\) uint8"
    ):
        Unwrapper(UP, (480, 480))(image)  # type: ignore[arg-type]


def test_a_turn_of_the_robot_shifts_the_panorama_of_the_garden(shared_data: Path) -> None:
    folder = shared_data / "garden_a" / "infield_summer"
    with (folder / "frames.csv").open() as file:
        rows = list(csv.DictReader(file))
    pose = np.array([[float(row[key]) for key in ("x_m", "y_m", "heading_rad")] for row in rows])
    distance = np.hypot(*(pose[:, None, :2] - pose[None, :, :2]).transpose(2, 0, 1))
    turn = np.mod(pose[None, :, 2] - pose[:, None, 2] + np.pi, 2 * np.pi) - np.pi
    pairs = np.argwhere((distance < 0.25) & (np.abs(turn) > 0.4))[:600:60]
    assert len(pairs) > 5
    unwrapper = Unwrapper(UP, (480, 480), GEOMETRY)
    for pair in pairs:
        spectra = [
            np.fft.rfft(unwrapper(cv2.imread(str(folder / rows[index]["image"]), cv2.IMREAD_GRAYSCALE)), axis=1)
            for index in pair
        ]
        product = np.conj(spectra[0]) * spectra[1]
        product[:, 0] = 0.0
        # A robot that turned left sees all move to the right.
        shift = np.fft.irfft(product.sum(axis=0), 600).argmax() * 2 * np.pi / 600
        assert np.cos(shift - turn[tuple(pair)]) > np.cos(np.radians(2.0))
