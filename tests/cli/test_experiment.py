import json
import sys
from dataclasses import replace

import pytest

from andante.evaluation.experiments import EXPERIMENTS, Scale

TINY = Scale(frames=70, image_px=64, sessions=2, permutations=1)


@pytest.fixture(autouse=True)
def tiny(monkeypatch):
    """Small is tiny here."""
    smaller = tuple(replace(experiment, small=TINY) for experiment in EXPERIMENTS)
    monkeypatch.setattr("andante.evaluation.experiments.registry.EXPERIMENTS", smaller)


@pytest.fixture
def needs_rays():
    pytest.importorskip("embreex", reason="rays need the extra sim: pip install 'andante[sim]'")


@pytest.mark.parametrize("arguments", [(), ("--list",), ("static", "--list")])
def test_list(andante, arguments):
    answer = andante("experiment", *arguments)
    assert (answer.exit_code, answer.stderr) == (0, "")
    for experiment in EXPERIMENTS:
        assert experiment.name in answer.stdout
        assert experiment.title in answer.stdout


def test_list_as_json(andante):
    listed = andante("experiment", "--json").json["experiments"]
    names = [
        "static",
        "slow-light",
        "dynamic-object",
        "long-term",
        "tracking",
        "stress",
        "off-map",
        "gaze",
        "navigation",
        "comparison",
        "landmarks",
    ]
    assert [one["name"] for one in listed] == names
    assert all(set(one) == {"name", "title", "source", "thesis"} for one in listed)


@pytest.mark.usefixtures("needs_rays")
def test_from_nothing_to_files_and_again(andante, tmp_path):
    options = ("--out", tmp_path / "out", "--cache", tmp_path / "cache", "--workers", 1)
    answer = andante("experiment", "dynamic-object", *options)
    assert answer.exit_code == 0, answer.stderr
    assert "Localized with a cow that was not mapped" in answer.stdout
    assert "thesis 6.3.1, figure 6.9: mean 0.12 m" in answer.stdout
    for name in ("dynamic-object.json", "dynamic-object.png", "dynamic-object.html"):
        assert (tmp_path / "out" / name).is_file()
        assert str(tmp_path / "out" / name) in answer.stdout
    first = json.loads((tmp_path / "out" / "dynamic-object.json").read_text(encoding="utf-8"))
    values = andante("experiment", "dynamic-object", *options, "--json").json
    assert values.pop("files")["json"] == str(tmp_path / "out" / "dynamic-object.json")
    assert values == first  # seconds included: nothing was done twice
    assert values["seed"] == 23


@pytest.mark.usefixtures("needs_rays")
def test_seed_and_default_places(andante, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path / "home"))
    values = andante("experiment", "static", "--seed", 6, "--workers", 1, "--json").json
    assert values["seed"] == 6
    assert (tmp_path / "output" / "experiments" / "static.png").is_file()
    assert len(list((tmp_path / "home" / "andante" / "simulated").glob("*/static/recording.toml"))) == 1


def test_unknown_experiment(andante, fails, tmp_path):
    answer = andante("experiment", "fly", "--out", tmp_path)
    fails(answer, "there is no experiment 'fly'; choose one of static, slow-light, dynamic-object, long-term")


@pytest.mark.parametrize("option", ["--out", "--cache"])
def test_a_file_is_no_folder(andante, fails, tmp_path, option):
    (tmp_path / "file").write_text("")
    fails(andante("experiment", "static", option, tmp_path / "file"), f"{option} .*file is a file; give the name")


@pytest.mark.parametrize("options", [("--scale", "huge"), ("--seed", "-1"), ("--workers", "0")])
def test_wrong_usage(andante, options):
    assert andante("experiment", "static", *options).exit_code == 2


def test_without_embreex_it_says_what_to_install(andante, tmp_path, fails, monkeypatch):
    for name in {"embreex", *(name for name in sys.modules if name.startswith("embreex."))}:
        monkeypatch.setitem(sys.modules, name, None)
    options = ("--out", tmp_path, "--cache", tmp_path / "cache", "--workers", 1)
    fails(andante("experiment", "static", *options), r"embreex is not installed; install it .*'andante\[sim\]'")
