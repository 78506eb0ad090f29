import numpy as np
import pytest

from andante.camera import PanoramaGeometry, Unwrapper
from andante.data import Pose2D
from andante.errors import MissingExtraError
from andante.simulator import Conditions, Renderer, SimulatedCamera
from andante.simulator.garden import NO_OBJECT
from andante.simulator.raycaster import RayCaster

POSE = Pose2D(2.5, -2.5, 0.3)
QUIET = Conditions(noise=0.0)
PANORAMA = SimulatedCamera(model="panorama", width_px=180, height_px=40)


@pytest.mark.parametrize("projection", ["equidistant", "equisolid", "stereographic"])
def test_unwrapping_a_fisheye_gives_the_panorama_that_is_rendered_directly(projection, view):
    geometry = PanoramaGeometry(120, 16, 8.0, 56.0)
    lens = {"projection": projection, "forward_deg": 40.0, "mirrored": projection == "equisolid"}
    fisheye = SimulatedCamera(width_px=320, height_px=320, **lens)
    image = view(fisheye).render(POSE).image
    unwrapped = Unwrapper(fisheye.spec, image.shape, geometry)(image).astype(float)
    direct = SimulatedCamera(model="panorama", width_px=480, height_px=64, min_deg=8.0, max_deg=56.0)
    panorama = view(direct).render(POSE).image.astype(float)
    panorama = panorama.reshape(16, 4, 120, 4, 3).mean(axis=(1, 3))
    difference = np.abs(unwrapped - panorama)
    assert np.median(difference) < 3.0
    assert difference.mean() < 7.0
    for shift in (-2, 2):  # and nowhere does it fit as well as here
        assert np.abs(np.roll(unwrapped, shift, axis=1) - panorama).mean() > 1.3 * difference.mean()


def test_turning_the_robot_shifts_the_panorama(view):
    renderer = view(SimulatedCamera(model="panorama", width_px=180, height_px=40, antialias=False))
    ahead = renderer.render(Pose2D(2.5, -2.5, 0.0)).object_id
    turned = renderer.render(Pose2D(2.5, -2.5, np.radians(40.0))).object_id
    assert (np.roll(ahead, 20, axis=1) == turned).mean() > 0.98


def test_range_is_the_distance_to_the_ground_below_the_horizon(view):
    camera = SimulatedCamera(model="panorama", width_px=60, height_px=30, min_deg=-30, max_deg=0)
    seen = view(camera).render(POSE)
    elevation = PanoramaGeometry(60, 30, -30, 0).elevations_rad()
    expected = np.broadcast_to((camera.mount_height_m / -np.sin(elevation))[:, None], seen.range_m.shape)
    ground = seen.object_id == 0
    assert ground.mean() > 0.3
    np.testing.assert_allclose(seen.range_m[ground], expected[ground], rtol=1e-3)


def test_the_sky_is_infinitely_far_and_nothing_else_is(view):
    seen = view(PANORAMA).render(POSE)
    np.testing.assert_array_equal(seen.object_id == NO_OBJECT, np.isinf(seen.range_m))


def test_looking_at_the_sky_coarsely_first_loses_next_to_nothing(embree, scene):
    camera = SimulatedCamera(width_px=200, height_px=200, antialias=False)
    renderer = Renderer(scene, Conditions(season="winter", noise=0.0), camera)
    seen = renderer.render(Pose2D(2.5, -2.5, 0.0)).object_id[renderer._valid]
    every = renderer._ids(renderer._cast(POSE, renderer._directions).face)
    assert (seen != every).mean() < 0.002


def test_the_same_seed_gives_the_same_bytes_and_each_frame_its_own_noise(embree, scene, tiny_camera):
    first, again = (Renderer(scene, Conditions(), tiny_camera, seed=5) for _ in range(2))
    again.render(POSE, 3)  # what was rendered before does not matter
    np.testing.assert_array_equal(first.render(POSE, 7).image, again.render(POSE, 7).image)
    assert (first.render(POSE, 7).image != first.render(POSE, 8).image).mean() > 0.3


def test_conditions_change_the_light_as_they_say(embree, scene, tiny_camera):
    def mean(**values):
        return Renderer(scene, Conditions(noise=0.0, **values), PANORAMA).render(POSE).image.mean(axis=(0, 1))

    usual = mean()
    assert (mean(sun_energy=8) > usual + 3).all()
    red = mean(sun_red=1.0)
    assert red[2] > usual[2] + 0.5
    assert abs(red[0] - usual[0]) < 0.5
    assert (mean(exposure=0.5) < usual - 10).all()
    assert mean(season="winter").mean() > usual.mean()


def test_light_drifts_within_a_recording_only_where_it_is_told_to(scene, tiny_camera, view):
    still = view(tiny_camera)
    np.testing.assert_array_equal(still.render(POSE, share=0.0).image, still.render(POSE, share=1.0).image)
    drifting = Renderer(scene, Conditions(noise=0.0, drift_energy=-0.5), tiny_camera)
    grey = [drifting.render(POSE, share=share).image.mean() for share in (0.0, 0.5, 1.0)]
    assert grey[0] > grey[1] > grey[2]


def test_outside_of_the_image_circle_it_is_black(embree, scene, tiny_camera):
    image = Renderer(scene, Conditions(), tiny_camera).render(POSE).image
    assert not image[0, 0].any()
    assert image[32, 32].any()


def test_without_embreex_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "embreex.rtcore_scene", None)
    monkeypatch.setitem(__import__("sys").modules, "embreex.mesh_construction", None)
    with pytest.raises(MissingExtraError, match=r"pip install 'andante\[sim\]'"):
        RayCaster(np.zeros((1, 3, 3), np.float32))


def test_sunlight_that_was_baked_is_what_rays_would_find(scene, view, tiny_camera):
    baked = view(tiny_camera).render(POSE).image.astype(int)
    asked = Renderer(scene, Conditions(noise=0.0, drift_hours=1e-9), tiny_camera).render(POSE).image.astype(int)
    assert np.abs(baked - asked).mean() < 2.0
    assert (np.abs(baked - asked).max(axis=-1) > 10).mean() < 0.08  # edges of shadows on leaves
