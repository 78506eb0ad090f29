import sys
from dataclasses import replace

import numpy as np
import pytest

from andante.baselines import (
    METHODS,
    Baseline,
    MapMethod,
    MethodOptions,
    StagedLocalizer,
    default_methods,
    make_methods,
    methods,
)
from andante.baselines.method import Method
from andante.data import Status
from andante.errors import InputError, MissingExtraError, RecordingError

LIGHT = ("andante", "nearest-1", "nearest-5", "thumbnails", "ridge", "gaussian-process")


def test_names_are_unique_and_the_own_one_is_first():
    names = [one.name for one in METHODS]
    assert len({*names}) == len(names)
    assert names[0] == "andante"
    assert {*LIGHT, "thesis"} <= {*names}


def test_methods_in_the_order_asked_for_and_once():
    assert [one.name for one in make_methods(["ridge", "andante", "ridge"])] == ["ridge", "andante"]
    assert all(isinstance(one, Method) for one in make_methods(LIGHT))


def test_an_unknown_one_lists_all():
    with pytest.raises(InputError, match=r"no method 'sift'; choose from andante, thesis, .*gaussian-process"):
        make_methods(["andante", "sift"])


def test_what_is_missing_is_left_out_or_told(monkeypatch):
    there = METHODS[0]
    absent = replace(there, name="absent", package="no_such_package", extra="torch")
    weighty = replace(there, name="weighty", needs_weights=True)
    monkeypatch.setattr(methods, "METHODS", (there, absent, weighty))
    chosen, left_out = default_methods()
    assert [one.name for one in chosen] == ["andante"]
    assert left_out[0] == (
        "absent is left out: no_such_package is not installed; install it with: pip install 'andante[torch]'"
    )
    assert left_out[1].endswith("--weights FILE")
    with pytest.raises(MissingExtraError, match=r"andante\[torch\]"):
        make_methods(["absent"])
    with pytest.raises(InputError, match="'weighty' needs the ONNX file"):
        make_methods(["weighty"])


def test_options_reach_the_methods():
    (own,) = make_methods(["andante"], MethodOptions(seed=4))
    (thesis,) = make_methods(["thesis"])
    assert isinstance(own, MapMethod)
    assert isinstance(thesis, MapMethod)
    assert own.config.seed == 4
    assert not thesis.config.off_path.enabled


def test_heavy_libraries_stay_out():
    import subprocess

    code = "import sys, andante.baselines; print(*sys.modules)"
    loaded = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True).stdout.split()
    assert not {"torch", "pycolmap", "onnxruntime"} & {*loaded}


@pytest.mark.parametrize("name", LIGHT)
def test_every_method_learns_and_answers_in_two_steps(make_drive, name):
    (method,) = make_methods([name])
    told = []
    learned = method.learn([make_drive(1)], progress=lambda *step: told.append(step))
    assert isinstance(learned.localizer, StagedLocalizer)
    assert learned.localizer.name
    assert min(learned.preprocessing_s, learned.mapping_s, learned.bytes) > 0
    assert told
    test = make_drive(2)
    errors = []
    for info in test.infos:
        image = test.load(info)
        estimate = learned.localizer.locate(learned.localizer.prepare(image))
        assert estimate.as_dict() == learned.localizer.localize(image).as_dict()
        best = estimate.hypotheses[0]
        errors.append(np.hypot(best.x_m - info.reference.x_m, best.y_m - info.reference.y_m))
    assert np.median(errors) < 0.5
    assert learned.localizer.localize(np.zeros_like(image)).status is Status.LOST


@pytest.mark.parametrize("name", LIGHT)
def test_bad_recordings(make_drive, name):
    (method,) = make_methods([name])
    with pytest.raises(RecordingError, match="at least one recording"):
        method.learn([])
    with pytest.raises(RecordingError, match="no odometry positions"):
        method.learn([make_drive(1)], positions="odometry")


def test_the_gaussian_process_says_what_the_map_readout_says(make_drive):
    (method,) = make_methods(["gaussian-process"])
    localizer = method.learn([make_drive(1)]).localizer
    assert isinstance(localizer, Baseline)
    features = np.random.default_rng(0).normal(size=(3, localizer.front_end.dim))
    told = localizer.process.locate(features).xy
    assert np.allclose([localizer.position(one.astype(np.float32)) for one in features], told, atol=1e-4)
