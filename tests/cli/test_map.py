from pathlib import Path
from typing import get_args

import pytest

from andante.cli import map as map_command
from andante.errors import LearningError
from andante.mapping import config as mapping_config


def test_json_tells_all(garden):
    assert garden.built.exit_code == 0, garden.built.stderr
    values = garden.built.json
    assert values["map"] == str(garden.map)
    assert [one["name"] for one in values["recordings"]] == ["monday", "tuesday"]
    assert values["frames"] == 80
    assert len(values["deltas"]) == values["slow_features"] > 0
    assert values["feature_dim"] > values["slow_features"]
    assert values["bytes"] == garden.map.stat().st_size
    assert set(values["seconds"]) == {"decode", "network", "features", "learn", "readout", "landmarks", "total"}
    assert values["seconds"]["total"] >= values["seconds"]["learn"] > 0
    assert values["skipped"] == []
    assert (values["stationary"], values["without_position"]) == (0, 0)
    assert values["cross_validation"]["kind"] == "sessions"


def test_table_and_hint_for_one_session(garden, andante, tmp_path):
    answer = andante("map", garden.monday, "-o", tmp_path / "m.andante", "--slow-features", 4)
    assert answer.exit_code == 0
    assert "40 of monday" in answer.stdout
    assert "4 slow features" in answer.stdout
    assert "hint: of one drive only parts can be left out" in answer.stderr


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        ((), ("local", 7, 5)),
        (("--readout", "gaussian-process"), ("gaussian-process", 7, 5)),
        (("--slow-features", 3, "--seed", 6), ("local", 3, 6)),
    ],
)
def test_flag_wins_over_file_wins_over_preset(garden, andante, tmp_path, monkeypatch, arguments, expected):
    configs = []

    def build_map(_recordings, config, **_):
        configs.append(config)
        raise LearningError("stop here")

    monkeypatch.setattr("andante.mapping.build_map", build_map)
    file = tmp_path / "config.toml"
    file.write_text('seed = 5\n[learning]\nslow_features = 7\n[readout]\nkind = "local"\n')
    andante("map", garden.monday, "-o", tmp_path / "m", "--preset", "thesis", "--config", file, *arguments)
    assert (configs[0].readout.kind, configs[0].learning.slow_features, configs[0].seed) == expected
    assert configs[0].learning.order == "restructured"  # of the preset, said nowhere else


def test_options_know_the_words_of_the_configuration():
    fields = mapping_config.FeatureConfig.model_fields
    assert get_args(map_command.Features) == get_args(fields["kind"].annotation)
    assert map_command.Order == mapping_config.Order
    assert map_command.Positions == mapping_config.Positions
    assert map_command.ReadoutKind == mapping_config.ReadoutKind


def test_failure_leaves_the_old_map(garden, andante, tmp_path):
    path = tmp_path / "m.andante"
    path.write_bytes(b"old")
    assert andante("map", garden.no_poses, "-o", path).exit_code == 1
    assert path.read_bytes() == b"old"
    assert [one.name for one in tmp_path.iterdir()] == ["m.andante"]


@pytest.mark.parametrize(
    ("place", "message"),
    [("missing/m.andante", "folder .*missing does not exist"), (".", "is a folder; give the name of a file")],
)
def test_place_is_checked_before_the_work(garden, andante, tmp_path, fails, monkeypatch, place, message):
    monkeypatch.setattr("andante.mapping.build_map", lambda *_, **__: pytest.fail("work was done"))
    fails(andante("map", garden.monday, "-o", tmp_path / place), message)


def test_expected_errors(garden, andante, tmp_path, fails):
    out = ("-o", tmp_path / "m.andante")
    fails(andante("map", garden.no_poses, *out), "no_poses.*x_m and y_m")
    fails(andante("map", tmp_path / "nowhere", *out), "nowhere does not exist")
    fails(andante("map", garden.monday / "images", *out), "recording.toml is missing")
    file = tmp_path / "config.toml"
    file.write_text("[learning]\nslow_feature = 3\n")
    fails(andante("map", garden.monday, *out, "--config", file), "unknown key 'learning.slow_feature'; allowed here")
    file.write_text("[learning\n")
    fails(andante("map", garden.monday, *out, "--config", file), "no valid TOML")
    fails(andante("map", garden.monday, *out, "--config", Path("no.toml")), "no.toml cannot be read")


@pytest.mark.parametrize(
    "arguments",
    [
        ("map",),
        ("map", "rec"),
        ("map", "rec", "-o", "m", "--slow-features", "0"),
        ("map", "rec", "-o", "m", "--order", "alphabetical"),
        ("map", "rec", "-o", "m", "--no-such-option"),
    ],
)
def test_wrong_usage(andante, arguments):
    answer = andante(*arguments)
    assert answer.exit_code == 2
    assert answer.stdout == ""
    assert "Usage: " in answer.stderr


@pytest.mark.parametrize(
    ("option", "value", "within_m"), [("--features", "pixels", 0.2), ("--preset", "thesis-pixels", 1.0)]
)
def test_raw_images_from_drives_to_figures(garden, andante, tmp_path, option, value, within_m):
    path = tmp_path / "m.andante"
    answer = andante("map", garden.monday, garden.tuesday, "-o", path, option, value, "--json")
    assert answer.exit_code == 0, answer.stderr
    assert answer.json["seconds"]["network"] > 0
    told = andante("info", path, "--json").json
    assert (told["features"], told["heading_invariant"]) == ("pixels", False)
    assert told["config"]["network"]["depth"] == (2 if option == "--features" else 4)
    assert andante("localize", path, garden.sunday, "--json").exit_code == 0
    figures = andante("evaluate", path, garden.sunday, "--baselines", "--json").json
    assert figures["median_m"] < within_m
    assert andante("update", path, garden.sunday, "--json", "--force").json["frames"] == 120


def test_cameras_too_small_for_a_network(andante, fails, tmp_path, write_drive):
    from andante.data import CameraSpec

    drive = write_drive(tmp_path / "drive", camera=CameraSpec(model="perspective"))
    config = tmp_path / "c.toml"
    config.write_text("[panorama]\nwidth_px = 64\nheight_px = 20\n")
    answer = andante("map", drive, "-o", tmp_path / "m", "--features", "pixels", "--config", config)
    fails(answer, "at least 36x24 px, this camera gives 64x20; take features of kind flat")
