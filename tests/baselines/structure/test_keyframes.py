import numpy as np
import pytest

from andante.baselines.structure.keyframes import read_keyframes, spaced
from andante.baselines.structure.localizer import Extractor
from andante.baselines.structure.views import FisheyeView
from andante.data import CameraSpec, Pose2D
from andante.errors import RecordingError
from andante.recordings import MemoryRecording

pytestmark = pytest.mark.usefixtures("colmap")

SPEC = CameraSpec(centre_px=(31.5, 31.5), radius_px=32.0)


def drive(poses, *, odometry=None, spec=SPEC, name="monday") -> MemoryRecording:
    images = [np.full((64, 64), 80, np.uint8)] * len(poses)
    return MemoryRecording(
        images, np.arange(float(len(poses))), spec, reference=poses, odometry=odometry or poses, name=name
    )


def straight(n: int, step_m: float = 0.1) -> list[Pose2D]:
    return [Pose2D(step_m * i, 0.0, 0.5) for i in range(n)]


def read(recordings, **options):
    extractor = Extractor(FisheyeView.of(SPEC, 88.0), (64, 64))
    values = {"positions": "reference", "every_m": 0.25, "progress": None, **options}
    return read_keyframes(recordings, extractor, **values)


def test_chosen_frames_are_apart_from_all_others_and_none_is_far_from_one() -> None:
    xy = np.random.default_rng(0).uniform(0, 3, (300, 2))
    xy[::7] = np.nan
    chosen = spaced(xy, 0.3)
    known = xy[np.isfinite(xy).all(axis=1)]
    apart = np.linalg.norm(xy[chosen][:, None] - xy[chosen], axis=2) + 9 * np.eye(len(chosen))
    assert apart.min() >= 0.3
    assert np.linalg.norm(known[:, None] - xy[chosen], axis=2).min(axis=1).max() < 0.3


def test_no_distance_takes_every_frame() -> None:
    assert spaced(np.zeros((4, 2)), 0.0) == [0, 1, 2, 3]


def test_drives_are_read_one_after_the_other() -> None:
    told = []
    found = read([drive(straight(40)), drive(straight(30))], progress=lambda *step: told.append(step))
    assert len(found) == 14 + 10
    assert found.session.tolist() == [0] * 14 + [1] * 10
    np.testing.assert_allclose(found.xy[:3], [[0, 0], [0.3, 0], [0.6, 0]], atol=1e-9)
    np.testing.assert_allclose(found.heading, 0.5)
    assert told[-1] == ("key points", 24, 24)


@pytest.mark.parametrize(
    ("recordings", "options", "message"),
    [
        ([], {}, r"no recording was given"),
        (
            [drive(straight(20))],
            {},
            r"7 frames of 'monday' have a reference position and lie 0\.25 m apart, at least 10",
        ),
        ([drive([None] * 40)], {}, r"0 frames of 'monday' have a reference position"),
        (
            [drive(straight(40)), drive(straight(40), spec=CameraSpec(radius_px=9.0), name="tuesday")],
            {},
            r"'monday' and 'tuesday' come from different cameras",
        ),
        ([drive(straight(40))] * 2, {"positions": "odometry"}, r"odometry of each of 2 drives has a frame of its own"),
    ],
)
def test_drives_that_cannot_be_reconstructed_are_refused(recordings, options, message) -> None:
    with pytest.raises(RecordingError, match=message):
        read(recordings, **options)
