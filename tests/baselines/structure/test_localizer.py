import numpy as np
import pytest

from andante.baselines.method import StagedLocalizer
from andante.baselines.structure import Keypoints, MatchRule, StructureLocalizer
from andante.baselines.structure.cloud import Cloud
from andante.baselines.structure.localizer import Extractor
from andante.baselines.structure.matching import Matcher
from andante.data import Status
from andante.errors import ImageError


@pytest.fixture(scope="module")
def localizer(world) -> StructureLocalizer:
    n = len(world.xyz)
    cloud = Cloud(world.xyz.astype(np.float32), world.descriptors, np.zeros(n, np.int32), np.arange(n, dtype=np.int32))
    extractor = Extractor(world.view, (240, 240))
    return StructureLocalizer("structure-fisheye", extractor, cloud, Matcher.of(cloud, MatchRule()))


@pytest.mark.parametrize("pose", [(0.0, 0.0, 0.0), (2.0, -1.0, 2.5), (-1.5, 3.0, -1.0)])
def test_a_pose_is_found_with_its_heading_among_wrong_matches(world, localizer, pose) -> None:
    rng = np.random.default_rng(1)
    seen = world.keypoints(np.array(pose), rng)
    wrong = seen.xy.copy()
    wrong[::3] = rng.permutation(wrong[::3])
    estimate = localizer.locate(Keypoints(wrong, seen.descriptors))
    assert estimate.status is Status.OK
    assert np.hypot(estimate.x_m - pose[0], estimate.y_m - pose[1]) < 0.05
    assert abs(np.angle(np.exp(1j * (estimate.heading_rad - pose[2])))) < 0.01
    assert estimate.hypotheses[0].x_m == estimate.x_m


def test_few_agreeing_points_are_a_guess_and_not_a_pose(world, localizer) -> None:
    seen = world.keypoints(np.zeros(3), np.random.default_rng(0))
    estimate = localizer.locate(Keypoints(seen.xy[:8], seen.descriptors[:8]))
    assert estimate.status is Status.LOST
    assert estimate.reason == "only 8 of 8 recognised points agree with the pose, 18 have to"
    assert estimate.x_m is None
    assert np.hypot(estimate.hypotheses[0].x_m, estimate.hypotheses[0].y_m) < 0.2


def test_what_was_never_seen_is_lost(localizer) -> None:
    rng = np.random.default_rng(0)
    estimate = localizer.locate(Keypoints(np.zeros((3, 2), np.float32), rng.integers(0, 90, (3, 128)).astype(np.uint8)))
    assert estimate.status is Status.LOST
    assert "of 3 key points look like a mapped point" in estimate.reason
    assert estimate.hypotheses == ()


def test_a_blank_picture_is_lost(localizer) -> None:
    assert isinstance(localizer, StagedLocalizer)
    estimate = localizer.localize(np.full((240, 240), 90, np.uint8))
    assert estimate.reason == "0 of 0 key points look like a mapped point"


def test_colour_is_understood_and_another_size_is_refused(localizer) -> None:
    grey = np.random.default_rng(0).integers(0, 255, (240, 240)).astype(np.uint8)
    from_grey, from_colour = localizer.prepare(grey), localizer.prepare(np.repeat(grey[:, :, None], 3, axis=2))
    np.testing.assert_array_equal(from_grey.xy, from_colour.xy)
    with pytest.raises(
        ImageError, match=r"of pictures of 240 x 240 pixels, got 100 x 120; give pictures of the camera"
    ):
        localizer.prepare(np.zeros((120, 100), np.uint8))
