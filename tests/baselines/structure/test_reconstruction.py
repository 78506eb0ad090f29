import numpy as np
import pytest

from andante.baselines.structure.alignment import Similarity
from andante.baselines.structure.cloud import Cloud
from andante.baselines.structure.pairs import matched_pairs
from andante.baselines.structure.reconstruction import camera_poses, reconstructions
from andante.baselines.structure.views import colmap_camera


@pytest.fixture(scope="module")
def seen(world, loop):
    rng = np.random.default_rng(0)
    return [world.keypoints(pose, rng) for pose in loop]


@pytest.fixture(scope="module")
def pairs(loop):
    return matched_pairs(loop[:, :2], np.zeros(len(loop), np.int64), neighbours=4, radius_m=2.0)


def test_the_lens_and_given_poses_stay_as_they_are(world, loop, seen, pairs) -> None:
    stages = []
    poses = camera_poses(world.view, loop[:, :2], loop[:, 2])
    (model,) = reconstructions(
        seen, colmap_camera(world.view), pairs, poses=poses, progress=lambda *step: stages.append(step)
    )
    cloud = Cloud.of(model, seen, Similarity.identity())
    for number, pose in enumerate(poses, start=1):
        np.testing.assert_allclose(model.image(number).cam_from_world().matrix(), pose, atol=1e-9)
    np.testing.assert_array_equal(next(iter(model.cameras.values())).params, world.view.params)
    assert len(cloud) > 100
    assert set(cloud.image.tolist()) == set(range(16))
    assert stages[-1] == ("structure", 16, 16)
    assert ("matching", len(pairs), len(pairs)) in stages


def test_given_poses_invert_to_the_robot(world, loop) -> None:
    for pose, camera_from_world in zip(loop, camera_poses(world.view, loop[:, :2], loop[:, 2]), strict=True):
        world_from_robot = camera_from_world[:, :3].T @ world.view.robot_from_camera.T
        np.testing.assert_allclose(-camera_from_world[:, :3].T @ camera_from_world[:, 3], [*pose[:2], 0], atol=1e-12)
        np.testing.assert_allclose(world_from_robot[:, 0], [np.cos(pose[2]), np.sin(pose[2]), 0], atol=1e-12)


def test_clouds_are_joined_with_their_own_sightings() -> None:
    one = Cloud(np.ones((2, 3), np.float32), np.ones((2, 128), np.uint8), np.int32([0, 3]), np.int32([0, 1]))
    both = Cloud.joined([one, one])
    assert both.point.tolist() == [0, 1, 2, 3]
    assert both.image.tolist() == [0, 3, 0, 3]
    assert both.nbytes == 2 * one.nbytes
    assert len(Cloud.joined([])) == 0
