"""From a picture to its features."""

import numpy as np
import pytest

from andante.data import CameraSpec
from andante.errors import BlankImageError, ImageError
from andante.features import FourierEncoder, PixelEncoder
from andante.mapping.config import FeatureConfig, PanoramaConfig
from andante.mapping.frontend import MIN_CONTRAST, FrontEnd, camera_of, make_encoder
from andante.mapping.timing import TimedRecording

PERSPECTIVE = CameraSpec(model="perspective")


def front_end(camera: CameraSpec, shape: tuple[int, int], **features) -> FrontEnd:
    return FrontEnd(camera, shape, PanoramaConfig(), FeatureConfig(**features))


def test_features_are_those_of_the_grey_panorama(garden):
    front = front_end(garden.fisheye_camera, (120, 120))
    picture = garden.fisheye(garden.loop(5)[0])
    panorama = front.panorama(picture)
    assert panorama.shape == front.panorama_shape == (24, 300)
    np.testing.assert_array_equal(front.features(picture), front.encoder.encode(panorama))
    assert front.dim == len(front.features(picture))


def test_an_encoded_picture_holds_features_and_phases_of_one_panorama(garden):
    front = front_end(garden.fisheye_camera, (120, 120))
    picture = garden.fisheye(garden.loop(5)[0])
    encoded, panorama = front.encode(picture), front.grey_panorama(picture)
    assert len(encoded.features) == 1
    np.testing.assert_array_equal(encoded.features[0], front.features(picture))
    np.testing.assert_array_equal(encoded.phase, front.phases(panorama[None]))
    np.testing.assert_array_equal(encoded.phase[0], front.phase_encoder.encode(panorama))
    assert encoded.phase.shape == (1, front.phase_dim)
    with pytest.raises(BlankImageError):
        front.encode(np.zeros((120, 120), np.uint8))


@pytest.mark.parametrize("camera", [PERSPECTIVE, CameraSpec(model="panorama", horizontal_field_of_view_deg=200.0)])
def test_who_does_not_look_all_around_sees_no_phases(camera, garden):
    front = front_end(camera, (12, 120))
    assert (front.phase_encoder, front.phase_dim) == (None, 0)
    encoded = front.encode(garden.panorama(garden.loop(5)[0]))
    assert (encoded.features.shape, encoded.phase.shape) == ((1, front.dim), (1, 0))


def test_auto_is_fourier_where_a_turn_only_shifts_columns_and_flat_elsewhere():
    assert front_end(CameraSpec(model="panorama"), (12, 120)).feature_kind == "fourier"
    assert front_end(PERSPECTIVE, (12, 120)).feature_kind == "flat"
    narrow = CameraSpec(model="panorama", horizontal_field_of_view_deg=200.0)
    assert front_end(narrow, (12, 120)).feature_kind == "flat"
    assert front_end(PERSPECTIVE, (12, 120), kind="fourier").feature_kind == "fourier"


def test_encoders_take_the_configured_values():
    config = FeatureConfig(n_frequencies=7, orientations=3, deviation_floor=11.0, window_share=(0.1, 0.3))
    encoder = make_encoder(config, (8, 48), wrap=True)
    assert encoder == FourierEncoder(8, 48, 7, True, (0.1, 0.3), 11.0, 3)
    flat = make_encoder(config.model_copy(update={"kind": "flat"}), (8, 48), wrap=False)
    assert flat == PixelEncoder(8, 48, True, (0.1, 0.3), 11.0, False)


def test_a_narrow_picture_offers_fewer_frequencies():
    assert front_end(CameraSpec(model="panorama"), (12, 20)).dim == 12 * 11 * 3


def test_contrast_decides_what_shows_nothing():
    front = front_end(CameraSpec(model="panorama"), (12, 120))
    stripes = np.tile(np.arange(120) % 2, (12, 1)).astype(np.uint8)
    enough = int(MIN_CONTRAST)
    assert front.grey_panorama(100 + 2 * enough * stripes).std() == enough
    with pytest.raises(BlankImageError, match=r"contrast of \d\.\d grey levels, at least \d is needed; is the lens"):
        front.grey_panorama(100 + (2 * enough - 1) * stripes)


def test_colour_becomes_grey(garden):
    front = front_end(CameraSpec(model="panorama"), (12, 120))
    blue = np.zeros((12, 120, 3), np.uint8)
    blue[:, ::2, 0] = 200
    assert front.panorama(blue).shape == (12, 120, 3)
    assert front.grey_panorama(blue).max() == round(0.114 * 200)


def test_a_declared_circle_is_taken_as_it_is(garden):
    drive = garden.drive(garden.loop(3), fisheye=True)
    assert camera_of(drive) is drive.camera


def test_no_circle_in_the_pictures_is_an_error_that_says_what_to_do(garden):
    drive = garden.drive(garden.loop(5))
    drive.camera = CameraSpec()
    with pytest.raises(ImageError, match=r"found no image circle: .* or declare centre_px and radius_px"):
        camera_of(drive)


def test_a_timed_recording_is_the_recording_and_counts(garden):
    drive = garden.drive(garden.loop(6))
    timed = TimedRecording(drive)
    assert (timed.name, timed.camera, timed.infos) == (drive.name, drive.camera, drive.infos)
    assert (timed.conditions, timed.content_hash()) == (drive.conditions, drive.content_hash())
    assert timed.load_seconds == 0
    np.testing.assert_array_equal(timed.load(drive.infos[2]), drive.load(drive.infos[2]))
    assert timed.load_seconds > 0
    assert len(list(timed.frames())) == 6
