import numpy as np
import pytest

from andante.baselines import StagedLocalizer
from andante.baselines.method import Method
from andante.baselines.thumbnails import ThumbnailMethod, spectra_of, thumbnails
from andante.data import CameraSpec, Pose2D, Status
from andante.errors import RecordingError
from andante.recordings import MemoryRecording

COLUMNS = 240


def world(count: int) -> list[np.ndarray]:
    """Panoramas of unlike places."""
    rng = np.random.default_rng(5)
    coarse = rng.uniform(20, 235, (count, 6, 24))
    return [np.kron(one, np.ones((4, 10))).astype(np.uint8) for one in coarse]


def drive(pictures, poses, **more) -> MemoryRecording:
    return MemoryRecording(pictures, np.arange(len(pictures)) * 1.0, CameraSpec(model="panorama"), **more)


@pytest.fixture(scope="module")
def learned():
    poses = [Pose2D(float(at), 0.0, 0.3 * at) for at in range(12)]
    return ThumbnailMethod().learn([drive(world(12), poses, reference=poses)])


def test_it_is_a_method(learned):
    assert isinstance(ThumbnailMethod(), Method)
    assert isinstance(learned.localizer, StagedLocalizer)
    assert learned.bytes == 12 * (12 * 120 + 24)
    assert learned.preprocessing_s > 0


@pytest.mark.parametrize("turn", [0, 1, 17, 100, 239])
def test_a_turned_robot_is_where_it_was_and_looks_elsewhere(learned, turn):
    # Turning to the left shifts the panorama to the right.
    seen = np.roll(world(12)[7], turn, axis=1)
    estimate = learned.localizer.localize(seen)
    # Other places vote a little, the more so the less of a column the turn is.
    assert (estimate.x_m, estimate.y_m) == (pytest.approx(7, abs=0.5), 0)
    wanted = 0.3 * 7 + 2 * np.pi * turn / COLUMNS
    assert abs(np.angle(np.exp(1j * (estimate.heading_rad - wanted)))) < np.radians(1)


def test_steps_are_what_localize_does(learned):
    image = world(12)[3]
    whole, steps = learned.localizer.localize(image), learned.localizer.locate(learned.localizer.prepare(image))
    assert whole == steps


def test_a_blank_picture_is_lost(learned):
    estimate = learned.localizer.localize(np.full((24, COLUMNS), 9, np.uint8))
    assert estimate.status is Status.LOST
    assert "shows nothing" in estimate.reason


def test_brightness_and_contrast_matter_little():
    panoramas = np.stack(world(3))
    darker = (0.5 * panoramas + 20).astype(np.uint8)
    one, other = spectra_of(thumbnails(panoramas)), spectra_of(thumbnails(darker))
    alike = (one * other.conj()).real.sum(axis=(1, 2))
    assert np.allclose((np.abs(one) ** 2).sum(axis=(1, 2)), 1, atol=1e-5)
    assert (alike > 0.98).all()


def test_without_headings_there_is_none():
    poses = [Pose2D(float(at), 0.0) for at in range(12)]
    learned = ThumbnailMethod().learn([drive(world(12), poses, reference=poses)])
    assert learned.localizer.localize(world(12)[2]).heading_rad is None


def test_drives_without_a_common_frame():
    poses = [Pose2D(float(at), 0.0, 0.0) for at in range(12)]
    drives = [drive(world(12), poses, odometry=poses, name=name) for name in "ab"]
    with pytest.raises(RecordingError, match="the odometry of 2 recordings is in as many frames"):
        ThumbnailMethod().learn(drives, positions="odometry")
