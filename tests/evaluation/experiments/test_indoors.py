import numpy as np

from andante.evaluation.experiments.indoors import furnished_room, indoor_pictures
from andante.simulator import SimulatedCamera


def test_rooms_differ_and_are_closed_but_for_windows(embree):
    camera = SimulatedCamera(width_px=48, height_px=48)
    pictures = list(indoor_pictures(np.random.default_rng(3), camera, 3))
    assert [(one.shape, one.dtype) for one in pictures] == [((48, 48), np.uint8)] * 3
    assert all(one[15:33, 15:33].mean() > 20 for one in pictures)
    assert (pictures[0] != pictures[1]).any()
    again = list(indoor_pictures(np.random.default_rng(3), camera, 3))
    assert all((a == b).all() for a, b in zip(pictures, again, strict=True))


def test_the_robot_has_room_to_stand():
    for seed in range(20):
        scene = furnished_room(np.random.default_rng(seed))
        corners = scene.mesh.corners.reshape(-1, 3)
        low = corners[(corners[:, 2] > 0.1) & (corners[:, 2] < 1.0)]
        assert (np.abs(low[:, :2]).max(axis=1) > 0.8).all()
