"""Maps that grow, merge and go back, through the command line."""

import shutil

import pytest

from andante.cli.trials import held_out_mean, missing_condition


@pytest.fixture
def grown(garden, andante, tmp_path):
    """A map of monday alone, and the command that learns tuesday into it."""
    path = tmp_path / "m.andante"
    assert andante("map", garden.monday, "-o", path).exit_code == 0
    return path, andante("update", path, garden.tuesday, "--json")


def test_update(grown, garden, andante):
    path, answer = grown
    assert answer.exit_code == 0, answer.stderr
    values = answer.json
    assert values["map"] == str(path)
    assert values["bytes"] == path.stat().st_size
    assert values["recordings"] == ["monday", "tuesday"]
    assert values["frames"] == 80
    assert values["added"][0]["agreeing"] > 0.8
    assert values["added"][0]["objection"] is None
    assert set(values["seconds"]) == {"decode", "features", "learn", "readout", "total"}
    assert values["held_out_mean"] > 0


def test_update_tells_people_how_it_fitted(garden, andante, tmp_path):
    path = tmp_path / "m.andante"
    andante("map", garden.monday, "-o", path)
    answer = andante("update", path, garden.tuesday)
    assert answer.exit_code == 0
    assert "How the new drives fitted" in answer.stdout
    assert "Errors on drives left out" in answer.stdout


def test_refused(garden, andante, fails, tmp_path, write_drive):
    path = shutil.copy(garden.map, tmp_path / "m.andante")
    before = path.read_bytes()
    fails(andante("update", path, garden.monday), "recording 'monday' is in the map already")
    fails(andante("update", path, garden.no_poses), "has no reference positions")
    fails(andante("update", tmp_path / "none.andante", garden.sunday), "cannot be read")
    assert path.read_bytes() == before


def test_history_and_rollback(grown, andante, fails):
    path, _ = grown
    now = path.read_bytes()
    versions = andante("history", path, "--json").json["versions"]
    assert [one["version"] for one in versions] == [1, None]
    assert [one["new"] for one in versions] == [["monday"], ["tuesday"]]
    assert [one["current"] for one in versions] == [False, True]
    assert "tuesday" in andante("history", path).stdout
    answer = andante("rollback", path, "--json")
    assert answer.json["version"] == 1
    assert andante("info", path, "--json").json["recordings"][0]["name"] == "monday"
    fails(andante("rollback", path), "has no earlier version")
    assert "version 2 again" in andante("rollback", path, "--to", 2).stdout
    assert path.read_bytes() == now


def test_merge(garden, andante, tmp_path, fails):
    one, other, both = (tmp_path / f"{name}.andante" for name in ("one", "other", "both"))
    andante("map", garden.monday, "-o", one)
    andante("map", garden.tuesday, "-o", other)
    answer = andante("merge", one, other, "-o", both, "--json")
    assert answer.exit_code == 0, answer.stderr
    assert answer.json["recordings"] == ["monday", "tuesday"]
    assert "How the new drives" in andante("merge", one, other, "-o", both).stdout
    together = tmp_path / "together.andante"
    andante("map", garden.monday, garden.tuesday, "-o", together)
    assert both.read_bytes() == together.read_bytes()


def test_localize_only_maps_are_small_and_final(garden, andante, tmp_path, fails):
    path, whole = tmp_path / "small.andante", tmp_path / "whole.andante"
    small = andante("map", garden.monday, garden.tuesday, "-o", path, "--localize-only", "--json").json
    assert small["bytes"] < andante("map", garden.monday, garden.tuesday, "-o", whole, "--json").json["bytes"]
    assert andante("info", path, "--json").json["updatable"] is False
    assert andante("info", whole, "--json").json["updatable"] is True
    fails(andante("update", path, garden.sunday), "does not remember its frames")


def fold(name: str, mean: float, season: str, n: int = 10) -> dict:
    return {"left_out": name, "n": n, "median": mean, "mean": mean, "conditions": [{"season": season}]}


def test_which_season_is_missing():
    trial = {
        "kind": "sessions",
        "folds": [fold("a", 0.1, "summer"), fold("b", 0.12, "autumn"), fold("c", 0.6, "winter", 20)],
    }
    told = missing_condition(trial, "m")
    assert "least known is what c (winter) shows: without it 0.600 m" in told
    assert held_out_mean(trial) == pytest.approx(14.2 / 40)
    assert missing_condition({"folds": trial["folds"][:2]}, "m") is None
    assert missing_condition({"folds": trial["folds"][2:]}, "m") is None
    assert held_out_mean({"kind": "sessions", "folds": []}) is None
    assert held_out_mean({**trial, "kind": "blocks"}) is None


def test_a_refused_drive_leaves_the_map_as_it_was_with_those_before_it(garden, andante, tmp_path, fails):
    path = tmp_path / "m.andante"
    andante("map", garden.monday, "-o", path)
    before = path.read_bytes()
    fails(andante("update", path, garden.tuesday, garden.monday), "'monday' is in the map already")
    assert path.read_bytes() == before


def test_what_is_replaced_is_kept(garden, andante, tmp_path):
    path = tmp_path / "m.andante"
    andante("map", garden.monday, "-o", path)
    first = path.read_bytes()
    andante("map", garden.tuesday, "-o", path)
    andante("merge", path, garden.map, "-o", path, "--force")
    assert [one["version"] for one in andante("history", path, "--json").json["versions"]] == [1, 2, None]
    andante("rollback", path, "--to", 1)
    assert path.read_bytes() == first


def test_a_damaged_version_is_told_among_the_others(grown, andante):
    path, _ = grown
    version = next((path.parent / f"{path.name}.history").glob("*.andante"))
    version.write_bytes(version.read_bytes()[:100])
    answer = andante("history", path, "--json")
    assert answer.exit_code == 0
    assert "damaged" in answer.json["versions"][0]["damaged"]
    assert "damaged" in andante("history", path).stdout
