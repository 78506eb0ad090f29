import numpy as np
import pytest

from andante.errors import ConfigError
from andante.evaluation.experiments import Scale
from andante.evaluation.experiments.plans import COW, GROWING, STATIC, UNSEEN, long_term_plan, single_plan
from andante.simulator import BorderRun, Conditions, GardenSpec, Plan, Session, SimulatedCamera, make_garden
from andante.simulator.movables import MOVABLE_KINDS

FULL = Scale(frames=297, image_px=480, sessions=10, permutations=15)
ALL = (STATIC, GROWING, UNSEEN, COW)


def recipe(seed: int, frames: int, sessions: int) -> Plan:
    """Written down once more; what was rendered by this recipe is found in the cache."""
    garden = GardenSpec(seed=seed)
    lap = make_garden(garden).border.inset(0.1).length_m
    found = []
    for n in range(sessions):
        rng = np.random.default_rng([seed, n])
        conditions = Conditions(
            season=("summer", "autumn", "winter", "spring")[n % 4],
            hour=round(rng.uniform(8, 16), 1),
            sun_energy=round(rng.uniform(3, 8), 2),
            sun_y_m=round(rng.uniform(-10, 10), 2),
            sun_red=round(rng.uniform(0.5, 1), 2),
            clouds=round(rng.uniform(0.1, 0.9), 2),
            overcast=bool(rng.random() < 0.25),
        )
        objects = tuple(str(kind) for kind in rng.choice(sorted(MOVABLE_KINDS), size=int(rng.integers(0, 4))))
        drive = BorderRun(start=round(n * 0.618 % 1, 3), rate_hz=frames * 0.67 / lap)
        name = f"{n:02d}-{conditions.season}"
        found.append(Session(name=name, seed=seed * 100 + n, drive=drive, conditions=conditions, objects=objects))
    camera = SimulatedCamera(width_px=480, height_px=480)
    return Plan(garden=garden, camera=camera, sessions=tuple(found))


@pytest.mark.parametrize("seed", [11, 23])
def test_long_term_follows_the_recipe(seed):
    plan, again = long_term_plan(seed, FULL), recipe(seed, 297, 10)
    assert plan == again
    for session in plan.sessions:
        assert plan.fingerprint(session.name) == again.fingerprint(session.name)


def test_long_term_has_everything_that_changes_in_a_year():
    sessions = long_term_plan(23, FULL).sessions
    assert [session.conditions.season for session in sessions[:4]] == ["summer", "autumn", "winter", "spring"]
    assert {len(session.objects) for session in sessions} <= {0, 1, 2, 3}
    assert len({session.seed for session in sessions}) == len({session.drive.start for session in sessions}) == 10
    for conditions in (session.conditions for session in sessions):
        assert 3 <= conditions.sun_energy <= 8
        assert -10 <= conditions.sun_y_m <= 10
        assert 0.5 <= conditions.sun_red <= 1
    garden = make_garden(GardenSpec(seed=23))
    assert all(abs(len(session.truth(garden).xy_m) - 297) <= 1 for session in sessions)


def test_fewer_sessions_are_the_first_ones():
    few, many = (long_term_plan(2, Scale(frames=70, image_px=64, sessions=count)) for count in (3, 6))
    assert few.sessions == many.sessions[:3]
    assert [few.fingerprint(one.name) for one in few.sessions] == [many.fingerprint(one.name) for one in few.sessions]


def test_only_the_light_grows_and_only_the_cow_is_new():
    plan = single_plan(23, Scale(frames=279, image_px=480), ALL)
    static, growing, again, cow = plan.sessions
    assert growing.conditions.drift_energy > 1
    assert growing.conditions.drift_hours == 0
    assert static.conditions == again.conditions == cow.conditions
    assert static.conditions.clouds == 0
    assert (again.seed, again.drive, again.objects) == (cow.seed, cow.drive, ())
    assert cow.objects == ("cow",)
    assert static.seed != again.seed
    assert static.drive.start != again.drive.start


def test_parts_of_the_single_plan_have_the_same_pictures():
    scale = Scale(frames=70, image_px=64)
    whole, part = single_plan(1, scale, ALL), single_plan(1, scale, (STATIC, UNSEEN))
    assert [session.name for session in part.sessions] == [STATIC, UNSEEN]
    assert all(whole.fingerprint(name) == part.fingerprint(name) for name in (STATIC, UNSEEN))


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"frames": 69}, "frames = '69' is not allowed: .* 70"),
        ({"image_px": 20}, "image_px = '20' is not allowed"),
        ({"sessions": 1}, "sessions = '1' is not allowed"),
        ({"permutations": 0}, "permutations = '0' is not allowed"),
        ({"frame": 80}, "unknown key 'frame'; allowed here are"),
    ],
)
def test_scales_are_checked(values, message):
    with pytest.raises(ConfigError, match=message):
        Scale(**{"frames": 70, "image_px": 64, **values})
