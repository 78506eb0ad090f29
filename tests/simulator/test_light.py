import numpy as np

from andante.simulator import Conditions
from andante.simulator.light import Sky, light_at
from andante.simulator.mesh import f32


def test_the_sun_stands_where_the_conditions_put_it():
    for y in (-10.0, 10.0):
        assert np.sign(light_at(Conditions(sun_y_m=y), 0.0).to_sun[1]) == np.sign(y)
    morning, evening = (light_at(Conditions(hour=hour), 0.0).to_sun for hour in (8, 16))
    assert morning[0] > 0 > evening[0]  # it rises at +x
    heights = {s: light_at(Conditions(season=s, sun_y_m=0), 0.0).to_sun[2] for s in ("summer", "autumn", "winter")}
    assert heights["summer"] > heights["autumn"] > heights["winter"] > 0
    assert abs(np.linalg.norm(morning) - 1) < 1e-6


def test_drift_ends_where_it_is_told_to():
    drifting, later = Conditions(hour=9, drift_hours=3, drift_energy=0.2), Conditions(hour=12)
    np.testing.assert_allclose(light_at(drifting, 1.0).to_sun, light_at(later, 0.0).to_sun, atol=1e-6)
    np.testing.assert_allclose(light_at(drifting, 1.0).sun, 1.2 * light_at(drifting, 0.0).sun, rtol=1e-5)


def test_more_clouds_whiten_more_of_the_sky():
    directions = np.random.default_rng(0).normal(size=(5000, 3))
    directions[:, 2] = np.abs(directions[:, 2])
    directions = f32(directions / np.linalg.norm(directions, axis=1, keepdims=True))

    def blue(clouds):
        seen = Sky(Conditions(clouds=clouds), np.random.default_rng(1)).look(directions)
        return float((seen[:, 2] > 1.25 * seen[:, 0]).mean())

    assert blue(0.0) > 0.9
    assert blue(0.0) > blue(0.5) > blue(1.0)


def test_the_sky_has_no_seam():
    near = np.pi - 1e-4
    left, right = (f32([[np.cos(a), np.sin(a), 0.3]]) for a in (near, -near))
    sky = Sky(Conditions(clouds=0.8), np.random.default_rng(1))
    np.testing.assert_allclose(sky.look(left), sky.look(right), atol=0.01)


def test_an_overcast_day_has_next_to_no_sun_and_not_less_sky():
    sunny, overcast = (light_at(Conditions(overcast=o), 0.0) for o in (False, True))
    assert overcast.sun.max() < 0.1 * sunny.sun.max()
    assert (overcast.sky >= sunny.sky).all()
