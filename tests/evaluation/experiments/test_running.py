import json
from dataclasses import replace
from importlib.metadata import version

import cv2
import pytest

from andante.errors import InputError
from andante.evaluation.experiments import EXPERIMENTS, Scale, experiment_named, registry, run_experiment
from andante.mapping import MapConfig

TINY = Scale(frames=70, image_px=64, sessions=3, permutations=1)


RECORDED = [experiment.name for experiment in EXPERIMENTS if experiment.name != "navigation"]
"""Navigation drives instead of recording: see test_navigation.py."""


@pytest.mark.parametrize("name", RECORDED)
def test_all_experiments_write_their_files(embree, name, cache, tmp_path):
    # What a part of a lap shows has to be seen in thirty frames, so that a third can be held out.
    scale = TINY.model_copy(update={"frames": 150}) if name == "landmarks" else TINY
    written = run_experiment(name, tmp_path / "out", scale=scale, cache=cache, seed=5)
    values = json.loads(written.json.read_text(encoding="utf-8"), parse_constant=pytest.fail)
    assert values == json.loads(json.dumps(written.values))
    assert (values["experiment"], values["seed"], values["version"]) == (name, 5, version("andante"))
    assert values["scale"] == scale.model_dump()
    assert MapConfig.checked(values["configurations"]["andante"]) == MapConfig()
    assert set(values["fingerprints"]) == {session["name"] for session in values["plan"]["sessions"]}
    assert [cv2.imread(str(plot)) is not None for plot in written.plots] == [True] * len(written.plots)
    page = written.page.read_text(encoding="utf-8")
    assert page.count("data:image/png;base64,") == len(written.plots)
    for table in written.outcome.tables:
        assert f"<h2>{table.title.replace(chr(39), '&#39;')}</h2>" in page
    assert {path.name for path in (tmp_path / "out").iterdir()} == {
        path.name for path in (written.json, written.page, *written.plots)
    }


def test_again_gives_the_same_bytes(cache, tmp_path):
    first, second = (run_experiment("static", tmp_path / name, scale=TINY, cache=cache, seed=5) for name in ("a", "b"))
    assert first.json.read_bytes() == second.json.read_bytes()
    assert first.plots[0].read_bytes() == second.plots[0].read_bytes()
    assert first.page.read_bytes() == second.page.read_bytes()


def test_the_scale_decides_the_plan(monkeypatch, tmp_path):
    asked = []

    def plan(seed, scale):
        asked.append((seed, scale))
        raise KeyboardInterrupt

    experiment = EXPERIMENTS[0]
    monkeypatch.setattr(registry, "EXPERIMENTS", (replace(experiment, plan=plan),))
    for scale in ("small", "thesis", TINY):
        with pytest.raises(KeyboardInterrupt):
            run_experiment(experiment.name, tmp_path, scale=scale)
    assert asked == [(23, experiment.small), (23, experiment.full), (23, TINY)]


def test_the_thesis_scales():
    assert [one.full.frames for one in EXPERIMENTS] == [279, 279, 279, 297, 297, 297, 297, 297, 15_000, 1083, 2000]
    assert (experiment_named("long-term").full.sessions, experiment_named("long-term").full.permutations) == (10, 15)
    assert (experiment_named("navigation").full.errands, experiment_named("navigation").full.repeats) == (200, 5)


def test_unknown_experiment(tmp_path):
    with pytest.raises(
        InputError, match="no experiment 'dynamic'; choose one of static, slow-light, dynamic-object, l"
    ):
        run_experiment("dynamic", tmp_path)


def test_a_file_is_no_place_for_the_files(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match=r"folder .*file cannot be made: File exists; choose another place"):
        run_experiment("static", tmp_path / "file", scale=TINY, cache=tmp_path)
