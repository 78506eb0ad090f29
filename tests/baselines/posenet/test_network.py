import math

import pytest

torch = pytest.importorskip("torch", reason="the extra torch is not installed")

from andante.baselines.posenet.network import PoseNetwork  # noqa: E402

SHAPE = (16, 128)


@pytest.fixture(scope="module")
def network():
    with torch.random.fork_rng(devices=[]):
        torch.manual_seed(0)
        return PoseNetwork(SHAPE, wrap=True, channels=8).eval()


@pytest.mark.parametrize("columns", [16, 48, 112])
def test_turning_on_the_spot_turns_the_heading_and_leaves_the_position(network, columns):
    panoramas = torch.randn(3, 1, *SHAPE, generator=torch.Generator().manual_seed(1))
    with torch.inference_mode():
        position, heading = network(panoramas)
        moved, turned = network(panoramas.roll(columns, 3))
    torch.testing.assert_close(moved, position, atol=1e-5, rtol=1e-4)
    by = 2 * math.pi * columns / SHAPE[1]
    before, after = torch.atan2(heading[:, 1], heading[:, 0]), torch.atan2(turned[:, 1], turned[:, 0])
    difference = after - before - by
    torch.testing.assert_close(difference.cos(), torch.ones(3), atol=1e-5, rtol=0)


def test_a_picture_alone_gives_the_same_as_among_others(network):
    panoramas = torch.randn(4, 1, *SHAPE, generator=torch.Generator().manual_seed(2))
    with torch.inference_mode():
        alone, among = network(panoramas[:1]), network(panoramas)
    for one, many in zip(alone, among, strict=True):
        torch.testing.assert_close(one, many[:1], atol=1e-5, rtol=1e-4)


@pytest.mark.parametrize("shape", [(12, 64), (5, 33), (1, 8)])
@pytest.mark.parametrize("wrap", [True, False])
def test_panoramas_of_any_shape_give_poses(shape, wrap):
    position, heading = PoseNetwork(shape, wrap=wrap, channels=8)(torch.zeros(2, 1, *shape))
    assert position.shape == heading.shape == (2, 2)
    assert torch.isfinite(position).all()
    assert torch.isfinite(heading).all()
