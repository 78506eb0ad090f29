"""Small cameras and gardens, so that a picture takes milliseconds."""

from functools import cache

import pytest

from andante.simulator import Conditions, GardenSpec, Plan, Renderer, Scene, Session, SimulatedCamera, make_garden


@pytest.fixture(scope="session")
def embree():
    return pytest.importorskip("embreex", reason="rays need the extra sim: pip install 'andante[sim]'")


@pytest.fixture(scope="session")
def garden():
    return make_garden(GardenSpec(seed=3))


@pytest.fixture(scope="session")
def scene():
    return Scene.of(make_garden(GardenSpec(seed=3, size_x_m=10, size_y_m=10)).things)


@pytest.fixture(scope="session")
def view(embree, scene):
    """Renderers of the small scene without noise, made once for each camera."""
    return cache(lambda camera: Renderer(scene, Conditions(noise=0.0), camera))


@pytest.fixture(scope="session")
def tiny_camera():
    return SimulatedCamera(width_px=64, height_px=64)


@pytest.fixture(scope="session")
def tiny_plan(tiny_camera):
    session = Session(name="monday", seed=1, drive={"kind": "border", "laps": 0.08}, objects=("car", "cow"))
    return Plan(garden=GardenSpec(seed=3, size_x_m=10, size_y_m=10), camera=tiny_camera, sessions=(session,))
