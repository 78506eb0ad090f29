import sys

import pytest

from andante.recordings import open_recording

PLAN = """
[garden]
seed = 4
size_x_m = 10
size_y_m = 9

[camera]
width_px = 64
height_px = 64

[[sessions]]
name = "morning"
drive = { kind = "infield", frames = 3 }
conditions = { season = "spring", hour = 8.0 }

[[sessions]]
name = "snow"
drive = { kind = "poses", poses = [[0, 0, 0], [0.5, 0, 1.5]] }
conditions = { season = "winter" }
objects = ["cow"]
"""
TINY = ("--size", "10x10", "--sessions", "summer,winter", "--frames", 4, "--image-px", 64, "--workers", 1)


@pytest.fixture(scope="module", autouse=True)
def embree():
    return pytest.importorskip("embreex", reason="rays need the extra sim: pip install 'andante[sim]'")


@pytest.fixture
def plan(tmp_path):
    path = tmp_path / "plan.toml"
    path.write_text(PLAN, encoding="utf-8")
    return path


def test_renders_then_keeps_what_is_complete(andante, tmp_path):
    folder = tmp_path / "new" / "garden"
    first = andante("simulate", "-o", folder, *TINY, "--json")
    assert (first.exit_code, first.stderr) == (0, "")
    values = first.json
    assert set(values) == {"recordings", "frames", "seconds", "images_per_second", "skipped"}
    assert values["recordings"] == [str(folder / "summer"), str(folder / "winter")]
    assert (values["frames"], values["skipped"]) == (8, [])
    assert values["images_per_second"] == pytest.approx(8 / values["seconds"])
    winter = open_recording(folder / "winter")
    assert winter.conditions["season"] == "winter"
    assert winter.load(winter.infos[0]).shape == (64, 64)
    written = (folder / "summer" / "frames.csv").stat().st_mtime_ns

    again = andante("simulate", "-o", folder, *TINY, "--json")
    assert again.json["skipped"] == ["summer", "winter"]
    assert again.json["images_per_second"] is None
    assert again.stderr.splitlines() == [
        f"hint: {folder / name} is complete already and was kept" for name in ("summer", "winter")
    ]
    assert (folder / "summer" / "frames.csv").stat().st_mtime_ns == written


def test_only_what_is_missing_is_rendered(andante, tmp_path):
    half = andante("simulate", "-o", tmp_path, "--sessions", "summer", *TINY[:2], *TINY[4:])
    assert half.exit_code == 0
    assert "images/s" in half.stdout
    whole = andante("simulate", "-o", tmp_path, *TINY, "--json").json
    assert whole["skipped"] == ["summer"]
    assert whole["images_per_second"] == pytest.approx(4 / whole["seconds"])


def test_sessions_of_a_plan_with_boxes(andante, plan, tmp_path):
    folder = tmp_path / "garden"
    answer = andante("simulate", "-o", folder, "--plan", plan, "--boxes", "--workers", 2, "--json")
    assert answer.exit_code == 0, answer.stderr
    assert [len(open_recording(path).infos) for path in answer.json["recordings"]] == [3, 2]
    assert (folder / "snow.boxes.csv").read_text(encoding="utf-8").startswith("frame,object,x_min")
    assert open_recording(folder / "morning").conditions["season"] == "spring"


@pytest.mark.parametrize("trajectory", ["border", "infield", "grid"])
def test_trajectories(andante, tmp_path, trajectory):
    options = ("--size", "10x10", "--sessions", "summer", "--frames", 9, "--image-px", 64, "--workers", 1)
    frames = andante("simulate", "-o", tmp_path, *options, "--trajectory", trajectory, "--json").json["frames"]
    assert frames in range(3, 16) if trajectory == "grid" else frames == 9


def test_the_same_seed_gives_the_same_garden_and_another_one_another(andante, tmp_path):
    one = ("--size", "10x10", "--sessions", "winter", "--frames", 2, "--image-px", 64, "--workers", 1)
    hashes = []
    for name, seed in (("a", 0), ("b", 0), ("c", 1)):
        folder = tmp_path / name
        assert andante("simulate", "-o", folder, *one, "--seed", seed).exit_code == 0
        hashes.append(open_recording(folder / "winter").content_hash())
    assert hashes[0] == hashes[1] != hashes[2]


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--size", "15"), r"--size '15' is no size; give width and depth in metres, such as 15x15"),
        (("--size", "3x15"), r"size_x_m = '3.0' is not allowed"),
        (("--sessions", "summer,monsoon"), r"--sessions has 'monsoon'; seasons are spring, summer, autumn, winter"),
        (("--sessions", ","), r"--sessions has ','"),
        (("--sessions", "summer,summer"), r"two sessions are called 'summer'; give each its own name"),
        (("--frames", "100000"), r"rate_hz = .* is not allowed"),
        (("--plan", "no.toml"), r"plan no.toml cannot be read"),
    ],
)
def test_expected_errors(andante, tmp_path, fails, options, message):
    fails(andante("simulate", "-o", tmp_path / "x", *options, "--json"), message)
    assert not (tmp_path / "x").exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("seed = 4", "sead = 4", r"unknown key 'garden.sead'; allowed here are"),
        ('"winter"', '"monsoon"', r"sessions.1.conditions.season = 'monsoon' is not allowed"),
        ("[garden]", "[garden", r"is no valid TOML"),
        ('["cow"]', '["whale"]', r"sessions.1.objects.0 = 'whale' is not allowed"),
    ],
)
def test_faults_of_a_plan(andante, plan, tmp_path, fails, old, new, message):
    plan.write_text(PLAN.replace(old, new), encoding="utf-8")
    fails(andante("simulate", "-o", tmp_path / "x", "--plan", plan), message)


def test_a_plan_and_options_at_once_are_wrong_usage(andante, plan, tmp_path):
    answer = andante("simulate", "-o", tmp_path / "x", "--plan", plan, "--image-px", 64)
    assert answer.exit_code == 2
    assert "leave out --image-px" in " ".join(answer.stderr.replace("│", " ").split())


def test_another_recording_is_not_overwritten(andante, tmp_path, fails):
    assert andante("simulate", "-o", tmp_path, *TINY).exit_code == 0
    fails(andante("simulate", "-o", tmp_path, *TINY, "--seed", 5), "holds another recording, not session 'summer'")


def test_a_file_is_no_place_for_recordings(andante, tmp_path, fails):
    (tmp_path / "file").write_text("")
    fails(andante("simulate", "-o", tmp_path / "file"), "-o .*file is a file")


def test_without_embreex_it_says_what_to_install(andante, tmp_path, fails, monkeypatch):
    for name in {"embreex", *(name for name in sys.modules if name.startswith("embreex."))}:
        monkeypatch.setitem(sys.modules, name, None)
    fails(andante("simulate", "-o", tmp_path / "x", *TINY), r"embreex is not installed; install it .*'andante\[sim\]'")
    assert not list((tmp_path / "x").glob("[!.]*"))
