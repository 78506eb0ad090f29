"""The image circle is found off centre, cut off, in noise and behind dark objects; and not where there is none."""

from pathlib import Path

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.camera import MIN_CONFIDENCE, find_image_circle, with_found_circle
from andante.data import CameraSpec, ImageArray
from andante.errors import ImageError

SIZE = 400


def scene(x: float, y: float, radius: float, seed: int = 0, dark_share: float = 0.25) -> ImageArray:
    """A sky burnt out at the rim with dark objects before it, seen through a circle, four samples a pixel."""
    rng = np.random.default_rng(seed)
    rows, columns = (np.mgrid[: 2 * SIZE, : 2 * SIZE] + 0.5) / 2 - 0.5
    distance = np.hypot(columns - x, rows - y) / radius
    turn = np.arctan2(rows - y, columns - x)
    values = np.where(distance > 0.8, 255.0, 120.0 + 60.0 * np.cos(5 * columns / radius))
    for start in rng.uniform(-np.pi, np.pi, 6):
        width = dark_share * 2 * np.pi / 6
        object_ = (np.mod(turn - start, 2 * np.pi) < width) & (distance > rng.uniform(0.7, 0.95))
        values[object_] = rng.uniform(25.0, 60.0)
    values[distance > 1.0] = 2.0
    return cv2.resize(values, (SIZE, SIZE), interpolation=cv2.INTER_AREA).astype(np.uint8)


def noisy(image: ImageArray, sigma: float, seed: int = 0) -> ImageArray:
    noise = np.random.default_rng(seed).normal(0.0, sigma, image.shape)
    return np.clip(np.rint(image + noise), 0, 255).astype(np.uint8)


def assert_found(images: ImageArray | list[ImageArray], x: float, y: float, radius: float) -> None:
    circle = find_image_circle(images)
    assert np.hypot(circle.centre_px[0] - x, circle.centre_px[1] - y) < 2.0
    assert abs(circle.radius_px - radius) < 2.0
    assert circle.confidence > MIN_CONFIDENCE


@given(
    x=st.floats(180.0, 220.0),
    y=st.floats(180.0, 220.0),
    radius=st.floats(120.0, 199.0),
    sigma=st.floats(0.0, 8.0),
    seed=st.integers(0, 1000),
)
@settings(max_examples=12, deadline=None)
def test_finds_circles_anywhere_in_noise(x: float, y: float, radius: float, sigma: float, seed: int) -> None:
    assert_found(noisy(scene(x, y, radius, seed), sigma, seed), x, y, radius)


@given(share=st.floats(0.0, 0.15), side=st.integers(0, 3), sigma=st.floats(0.0, 8.0), seed=st.integers(0, 1000))
@settings(max_examples=12, deadline=None)
def test_finds_circles_that_the_picture_cuts_off(share: float, side: int, sigma: float, seed: int) -> None:
    radius, middle = 190.0, (SIZE - 1) / 2
    image = np.rot90(noisy(scene(middle, middle, radius, seed), sigma, seed), side)
    cut = round(middle - radius + share * 2 * radius)
    assert_found(np.ascontiguousarray(image[cut:]), middle, middle - cut, radius)


def test_several_frames_outshine_dark_objects() -> None:
    frames = [scene(190.0, 205.0, 170.0, seed, dark_share=0.7) for seed in range(5)]
    assert_found(frames, 190.0, 205.0, 170.0)
    single = find_image_circle(frames[0]).confidence
    assert find_image_circle(frames).confidence >= single


def test_colour_and_large_pictures_work_alike() -> None:
    large = cv2.resize(scene(190.0, 205.0, 170.0), (1600, 1600), interpolation=cv2.INTER_LINEAR)
    circle = find_image_circle(cv2.cvtColor(large, cv2.COLOR_GRAY2BGR))
    assert circle.centre_px == pytest.approx((190.5 * 4 - 0.5, 205.5 * 4 - 0.5), abs=2.0)
    assert circle.radius_px == pytest.approx(680.0, abs=3.0)


def test_pictures_without_a_circle_get_no_confidence() -> None:
    rng = np.random.default_rng(0)
    blobs = cv2.GaussianBlur(rng.normal(0.0, 1.0, (SIZE, SIZE)), (0, 0), 20.0)
    photo = cv2.normalize(blobs, None, 0, 255, cv2.NORM_MINMAX).astype(np.uint8)
    night = noisy(np.zeros((SIZE, SIZE), np.uint8), 8.0)
    square = np.zeros((SIZE, SIZE), np.uint8)
    square[50:350, 50:350] = 200
    for image in (photo, night, square, np.full((SIZE, SIZE), 255, np.uint8), np.zeros((1, 1), np.uint8)):
        assert find_image_circle(image).confidence < 0.3


def test_the_camera_is_completed_only_where_it_says_nothing() -> None:
    image = scene(190.0, 205.0, 170.0)
    spec = with_found_circle(CameraSpec(forward_deg=30.0), image)
    assert spec.centre_px == pytest.approx((190.0, 205.0), abs=1.0)
    assert spec.radius_px == pytest.approx(170.0, abs=1.0)
    assert spec.forward_deg == 30.0
    assert with_found_circle(CameraSpec(radius_px=165.0), [image]).radius_px == 165.0
    complete = CameraSpec(centre_px=(1.0, 2.0), radius_px=3.0)
    assert with_found_circle(complete, image) is complete
    panorama = CameraSpec(model="panorama")
    assert with_found_circle(panorama, image) is panorama


def test_faults_are_named() -> None:
    with pytest.raises(ImageError, match=r"found no image circle: confidence 0.00, at least .*declare centre_px"):
        with_found_circle(CameraSpec(), np.full((100, 100), 255, np.uint8))
    with pytest.raises(ImageError, match="at least one image"):
        find_image_circle([])
    with pytest.raises(ImageError, match=r"one size \(20, 20\), got shape \(20, 21\)"):
        find_image_circle([np.zeros((20, 20), np.uint8), np.zeros((20, 21), np.uint8)])
    with pytest.raises(ImageError, match="type float64"):
        find_image_circle([np.zeros((20, 20))])  # type: ignore[list-item]


@pytest.mark.parametrize("session", ["border_summer", "border_autumn", "border_winter", "infield_summer"])
def test_finds_the_declared_circle_of_the_garden(shared_data: Path, session: str) -> None:
    for path in sorted((shared_data / "garden_a" / session / "images").iterdir())[::97]:
        image = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        assert_found(image, 239.5, 239.5, 240.0)
        assert_found(noisy(image[72:], 8.0), 239.5, 167.5, 240.0)
        canvas = np.zeros((620, 700), np.uint8)
        canvas[100:580, 37:517] = image
        assert_found(noisy(canvas, 8.0), 276.5, 339.5, 240.0)
