import json
import math

import pytest

from andante.cli.worlds import world_of
from andante.simulator import GardenSpec, SimulatedCamera, make_garden
from andante.simulator.plan import Plan

PLAN = """
[garden]
seed = 5
size_x_m = 8
size_y_m = 14

[camera]
model = "panorama"
width_px = 120
height_px = 12
min_deg = 5
max_deg = 50
antialias = false

[[sessions]]
name = "mapped"
seed = 1
drive = { kind = "infield", frames = 1500 }
conditions = { clouds = 0.0 }
"""
KEYS = {
    *("arrived", "outcome", "reason", "distance_m", "path_m", "shortest_m", "seconds"),
    *("collisions", "replans", "ms_per_step", "report"),
}


@pytest.fixture(scope="module")
def mapped(tmp_path_factory, andante):
    pytest.importorskip("embreex", reason="rays need the extra sim: pip install 'andante[sim]'")
    folder = tmp_path_factory.mktemp("lawn")
    (folder / "plan.toml").write_text(PLAN, encoding="utf-8")
    world = folder / "world"
    assert andante("simulate", "-o", world, "--plan", folder / "plan.toml", "--workers", 1).exit_code == 0
    assert andante("map", world / "mapped", "-o", folder / "lawn.andante").exit_code == 0
    return folder


def ends(mapped):
    """The first place of the mapped drive, and the one that is farthest from it."""
    plan = Plan.from_toml(mapped / "plan.toml")
    xy = plan.sessions[0].truth(make_garden(plan.garden)).xy_m
    far = xy[((xy - xy[0]) ** 2).sum(axis=1).argmax()]
    return "{:.2f},{:.2f},0.3".format(*xy[0]), "{:.2f},{:.2f}".format(*far)


def test_drives_to_a_goal_and_reports(andante, mapped, tmp_path):
    start, goal = ends(mapped)
    answer = andante("navigate", mapped / "lawn.andante", "--world", mapped / "plan.toml", f"--start={start}",
                     f"--goal={goal}", "--report", tmp_path / "report", "--json")  # fmt: skip
    assert answer.exit_code == 0, answer.stderr
    values = answer.json
    assert set(values) == KEYS
    assert values["arrived"], values
    assert values["distance_m"] < 0.6
    assert values["collisions"] == 0
    assert values["path_m"] < 1.6 * values["shortest_m"]
    assert values["shortest_m"] >= math.dist(*([float(n) for n in one.split(",")[:2]] for one in (start, goal))) - 0.1
    assert json.loads((tmp_path / "report" / "drive.json").read_text(encoding="utf-8")) == values
    page = (tmp_path / "report" / "report.html").read_text(encoding="utf-8")
    assert page.count("data:image/svg+xml") == 2
    assert "Arrived: " in page
    assert "<script" not in page


def test_a_named_place(andante, mapped, fails):
    start, goal = ends(mapped)
    x, y = goal.split(",")
    (mapped / "lawn.places.toml").write_text(f"charging-station = [{x}, {y}]\n", encoding="utf-8")
    command = ("navigate", mapped / "lawn.andante", "--world", mapped / "plan.toml", f"--start={start}")
    values = andante(*command, "--goal-place", "charging-station", "--json").json
    assert values["arrived"], values
    fails(andante(*command, "--goal-place", "pond"), r".*there is no place 'pond' in .*; it has charging-station")


def test_down_the_gradient(andante, mapped, tmp_path):
    start, goal = ends(mapped)
    answer = andante("navigate", mapped / "lawn.andante", "--world", mapped / "plan.toml", f"--start={start}",
                     f"--goal={goal}", "--navigator", "gradient", "--timeout", 20,
                     "--report", tmp_path, "--json")  # fmt: skip
    assert answer.exit_code == 0, answer.stderr
    assert set(answer.json) == KEYS
    assert "by slow features alone" in (tmp_path / "report.html").read_text(encoding="utf-8")


def test_the_gradient_needs_the_images_of_the_map(andante, mapped, fails, tmp_path):
    recording = mapped / "world" / "mapped"
    recording.rename(tmp_path / "elsewhere")
    try:
        fails(
            andante("navigate", mapped / "lawn.andante", "--world", mapped / "plan.toml", "--goal=0,0",
                    "--navigator", "gradient"),
            r"the gradient learns from images, and no recording of this map is where it was mapped from",
        )  # fmt: skip
    finally:
        (tmp_path / "elsewhere").rename(recording)


def test_a_timeout_is_an_answer_and_no_error(andante, mapped):
    start, goal = ends(mapped)
    answer = andante("navigate", mapped / "lawn.andante", "--world", mapped / "plan.toml", f"--start={start}",
                     f"--goal={goal}", "--timeout", 2, "--season", "winter", "--no-guard")  # fmt: skip
    assert answer.exit_code == 0, answer.stderr
    assert "timed_out" in answer.stdout


@pytest.mark.parametrize(
    ("options", "message"),
    [
        (("--goal=1",), r"--goal '1' is no pose"),
        (("--goal=1,nan",), r"--goal '1,nan' is no pose"),
        (("--goal=0,0", "--start=1,2"), r"--start '1,2' is no pose; give X,Y,HEADING"),
        (("--goal=50,0",), r"the goal \(50.00, 0.00\) is .* m from everything that was mapped"),
    ],
)
def test_expected_errors(andante, mapped, fails, options, message):
    fails(andante("navigate", mapped / "lawn.andante", "--world", mapped / "plan.toml", *options), message)


def test_a_folder_that_was_not_simulated_is_no_world(andante, garden, fails, tmp_path):
    fails(andante("navigate", garden.map, "--world", garden.monday, "--goal=1,0"), r".*was not simulated")
    fails(andante("navigate", garden.map, "--world", tmp_path, "--goal=1,0"), r".*holds no recording")


def test_a_rendered_folder_tells_its_world(andante, mapped, fails, tmp_path):
    options = ("--size", "10x10", "--sessions", "winter", "--frames", 2, "--image-px", 64, "--workers", 1)
    assert andante("simulate", "-o", tmp_path, *options).exit_code == 0
    for path in (tmp_path, tmp_path / "winter"):
        world = world_of(path, None)
        assert (world.garden, world.conditions.season) == (GardenSpec(seed=0, size_x_m=10, size_y_m=10), "winter")
        assert world.camera.spec == SimulatedCamera(width_px=64, height_px=64).spec
    assert world_of(tmp_path, "summer").conditions.season == "summer"
    fails(
        andante("navigate", mapped / "lawn.andante", "--world", mapped / "world", "--goal=0,0"),
        r".*does not say which elevations its panorama shows; give its plan instead",
    )


def test_one_goal_is_needed(andante, garden):
    assert andante("navigate", garden.map, "--world", garden.monday).exit_code == 2
