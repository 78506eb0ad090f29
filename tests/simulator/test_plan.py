import pytest

from andante.errors import ConfigError
from andante.simulator import BorderRun, Conditions, GardenSpec, InfieldRun, Placed, Plan, Session

GOOD = """
[garden]
seed = 3
size_x_m = 20
[camera]
model = "panorama"
width_px = 120
height_px = 24
[[sessions]]
name = "monday"
drive = { kind = "border", laps = 2 }
[sessions.conditions]
season = "winter"
[[sessions]]
name = "tuesday"
seed = 4
objects = ["car"]
drive = { kind = "infield", frames = 30 }
"""


def read(tmp_path, text):
    path = tmp_path / "plan.toml"
    path.write_text(text)
    return Plan.from_toml(path)


def test_a_plan_is_read_with_defaults_for_what_it_leaves_out(tmp_path):
    plan = read(tmp_path, GOOD)
    assert [session.name for session in plan.sessions] == ["monday", "tuesday"]
    assert plan.session("monday").drive == BorderRun(laps=2)
    assert plan.session("monday").conditions == Conditions(season="winter")
    assert plan.session("tuesday").drive == InfieldRun(frames=30)
    assert plan.camera.spec.model == "panorama"


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (
            ("seed = 3", "sed = 3"),
            r"plan .*plan.toml: unknown key 'garden.sed'; allowed here are seed, size_x_m, size_y_m, v_obstacle, walls",
        ),
        (('"winter"', '"monsoon"'), r"season = 'monsoon' is not allowed: input should be 'spring', 'summer'"),
        (('kind = "border"', 'kind = "spiral"'), r"drive = .* is not allowed: .*'border', 'infield', 'grid', 'poses'"),
        (
            ("laps = 2", "lap = 2"),
            r"unknown key 'sessions.0.drive.border.lap'; allowed here are clockwise, inset_m, kind",
        ),
        (("laps = 2", "laps = 0"), r"laps = '0' is not allowed: input should be greater than 0"),
        (('name = "tuesday"', 'name = "monday"'), r"two sessions are called 'monday'; give each its own name"),
        (('name = "tuesday"', 'name = "../up"'), r"name = '../up' is not allowed"),
        (('name = "tuesday"\n', ""), r"'sessions.1.name' is missing; add it"),
        (('["car"]', '["dragon"]'), r"objects.0 = 'dragon' is not allowed: input should be 'car', 'bicycle'"),
        (("[garden]", "[garden"), r"plan .*plan.toml is no valid TOML"),
        (("width_px = 120", "width_px = 1"), r"camera.width_px = '1' is not allowed"),
    ],
)
def test_faults_name_the_key_the_value_and_what_is_allowed(tmp_path, change, message):
    assert change[0] in GOOD
    with pytest.raises(ConfigError, match=message) as fault:
        read(tmp_path, GOOD.replace(*change))
    assert "\n" not in str(fault.value)


def test_a_plan_without_sessions_and_a_missing_file_are_errors(tmp_path):
    with pytest.raises(ConfigError, match="'sessions' is missing; add it"):
        read(tmp_path, "")
    with pytest.raises(ConfigError, match=r"plan .*nowhere.toml cannot be read: No such file or directory"):
        Plan.from_toml(tmp_path / "nowhere.toml")


def test_an_unknown_session_names_those_there_are(tmp_path):
    with pytest.raises(ConfigError, match="there is no session 'friday' in this plan; it has monday, tuesday"):
        read(tmp_path, GOOD).session("friday")


def test_values_made_in_code_are_checked_too():
    with pytest.raises(ConfigError, match="sun_energy = '9' is not allowed: input should be less than or equal to 8"):
        Conditions(sun_energy=9)
    with pytest.raises(ConfigError, match="unknown key 'sesaon'"):
        Conditions(sesaon="winter")


def test_the_fingerprint_changes_with_what_a_session_depends_on_and_with_nothing_else(tmp_path):
    plan = read(tmp_path, GOOD)
    same = read(tmp_path, GOOD.replace("frames = 30", "frames = 31"))
    assert same.fingerprint("monday") == plan.fingerprint("monday")
    assert same.fingerprint("tuesday") != plan.fingerprint("tuesday")
    other = read(tmp_path, GOOD.replace("seed = 3", "seed = 5"))
    assert other.fingerprint("monday") != plan.fingerprint("monday")
    shared = Session(name="x", objects=("car",), objects_seed=1)
    alone, joined = Plan(sessions=(shared,)), Plan(sessions=(shared, Session(name="y", seed=7, objects_seed=1)))
    assert alone.fingerprint("x") != joined.fingerprint("x")  # y's way moves the car


def test_putting_things_down_changes_the_fingerprint_and_nothing_put_down_does_not():
    def plan(*placed):
        first = Session(name="a", seed=1, objects=("car", "cow"), objects_seed=9, placed=placed)
        return Plan(garden=GardenSpec(seed=3), sessions=(first, Session(name="b", seed=2, objects_seed=9)))

    assert plan().fingerprint("a") == "a3e17956ddf6dfb1"  # as before anything could be put down
    bicycle, car = Placed(kind="bicycle", x_m=1.0, y_m=2.0), Placed(kind="car", x_m=1.0, y_m=2.0)
    assert len({plan(*placed).fingerprint("a") for placed in ((), (bicycle,), (car,))}) == 3
    assert plan(bicycle).fingerprint("b") == plan().fingerprint("b")  # it has no objects that keep clear of it
