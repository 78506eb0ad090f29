import math

import numpy as np
import pytest

from andante.camera import PanoramaGeometry

torch = pytest.importorskip("torch", reason="the extra torch is not installed")

from andante.baselines.posenet.augmentation import Augmentation, sky, turned  # noqa: E402

NOTHING = {"contrast": 0.0, "brightness": 0.0, "noise": 0.0, "hidden": 0.0, "clouds": 0.0}


def test_a_roll_turns_the_heading_by_as_much():
    panoramas = torch.arange(2 * 3 * 8.0).reshape(2, 1, 3, 8)
    rolled, heading = turned(panoramas, torch.tensor([0.1, math.nan]), torch.tensor([2, 5]))
    for picture, before, columns in zip(rolled, panoramas, (2, 5), strict=True):
        np.testing.assert_array_equal(picture, np.roll(before.numpy(), columns, axis=2))
    assert heading[0].item() == pytest.approx(0.1 + 2 * math.pi * 2 / 8)
    assert heading[1].isnan()


def test_a_roll_is_what_the_camera_of_a_turned_robot_sees(garden):
    columns, width = 37, 120
    pose = np.array([1.0, -0.5, 0.4])
    turn = np.array([0, 0, 2 * np.pi * columns / width])
    picture = torch.from_numpy(garden.panorama(pose).astype(np.float32))[None, None]
    rolled, heading = turned(picture, torch.tensor([pose[2]]), torch.tensor([columns]))
    np.testing.assert_allclose(rolled[0, 0], garden.panorama(pose + turn), atol=1)
    assert heading.item() == pytest.approx((pose + turn)[2])
    # The same convention as every panorama of the camera room.
    azimuths = PanoramaGeometry(width, 12).azimuths_rad()
    assert azimuths[0] - azimuths[columns] == pytest.approx(turn[2])


def test_without_anything_to_change_only_the_turn_is_left():
    panoramas, heading = torch.randn(6, 1, 4, 16), torch.zeros(6)
    changed, after = Augmentation(turn=True, **NOTHING)(panoramas, heading, torch.Generator().manual_seed(0))
    columns = (after / (2 * math.pi / 16)).round().long()
    assert len(set(columns.tolist())) > 1
    torch.testing.assert_close(changed, turned(panoramas, heading, columns)[0])
    still, same = Augmentation(turn=False, **NOTHING)(panoramas, heading, torch.Generator().manual_seed(0))
    assert torch.equal(still, panoramas)
    assert torch.equal(same, heading)


def test_the_seed_decides_and_nothing_is_changed_in_place():
    panoramas, heading = torch.randn(5, 1, 6, 20), torch.zeros(5)
    before = panoramas.clone()
    first, again = (Augmentation(turn=True)(panoramas, heading, torch.Generator().manual_seed(4)) for _ in range(2))
    other = Augmentation(turn=True)(panoramas, heading, torch.Generator().manual_seed(5))
    assert torch.equal(first[0], again[0])
    assert torch.equal(first[1], again[1])
    assert not torch.equal(first[0], other[0])
    assert torch.equal(panoramas, before)


def test_a_window_is_blanked_that_may_lie_across_the_seam():
    augmentation = Augmentation(turn=False, **NOTHING | {"hidden": 0.5})
    changed, _ = augmentation(torch.ones(200, 1, 2, 40), torch.zeros(200), torch.Generator().manual_seed(0))
    blank = (changed[:, 0] == 0).all(1)
    assert 0.2 < blank.float().mean().item() < 0.3
    assert (blank[:, 0] & blank[:, -1]).any()
    # Going around, each has one window at most: one step into it and one out of it.
    assert ((blank != blank.roll(1, 1)).sum(1) <= 2).all()


def test_clouds_are_smooth_and_of_about_unit_deviation():
    clouds = sky(torch.Size((50, 1, 32, 256)), torch.Generator().manual_seed(0))
    assert 0.6 < clouds.std().item() < 1.6
    assert (clouds[..., 1:] - clouds[..., :-1]).std() < 0.3 * clouds.std()
