import shutil
from pathlib import Path

import pytest

from andante.errors import InputError, RecordingError
from andante.evaluation.experiments.cache import ResultStore, code_hash, default_cache, rendered
from andante.evaluation.experiments.plans import COW, STATIC, UNSEEN

KEY = {"contender": {"name": "a", "config": {"ridge": 0.1}}, "train": [["f00d", None]], "code": "1"}


def written(cache):
    return {path: path.stat().st_mtime_ns for path in cache.glob("*/*/frames.csv")}


def test_sessions_lie_under_their_fingerprints_and_are_rendered_once(cache, singles):
    before = written(cache)
    found = rendered(singles, cache)
    assert list(found) == [session.name for session in singles.sessions]
    for name, recording in found.items():
        assert recording.folder == cache / singles.fingerprint(name) / name
    assert written(cache) == before


def test_a_changed_plan_renders_only_what_changed(cache, singles):
    before = written(cache)
    static, unseen = singles.session(STATIC), singles.session(UNSEEN)
    foggy = unseen.model_copy(update={"conditions": unseen.conditions.model_copy(update={"noise": 9.0})})
    rendered(singles.model_copy(update={"sessions": (static, foggy)}), cache)
    after = written(cache)
    assert {path: after[path] for path in before} == before
    assert [path.parent.name for path in set(after) - set(before)] == [UNSEEN]


def test_what_was_left_half_way_goes_on(cache, singles):
    before = written(cache)
    lost = cache / singles.fingerprint(COW)
    shutil.rmtree(lost)
    found = rendered(singles, cache)
    assert (lost / COW).is_dir()
    assert len(found[COW].infos) == 70
    assert all(written(cache)[path] == when for path, when in before.items() if COW not in path.parts)


def test_another_recording_in_its_place_is_an_error(cache, singles):
    own, other = (cache / singles.fingerprint(name) / name for name in (STATIC, UNSEEN))
    shutil.rmtree(own)
    shutil.copytree(other, own)
    with pytest.raises(RecordingError, match="holds another recording, not session 'static' of this plan; remove it"):
        rendered(singles, cache)


def test_a_folder_with_something_else_is_an_error(cache, singles):
    own = cache / singles.fingerprint(STATIC) / STATIC
    shutil.rmtree(own)
    own.mkdir()
    with pytest.raises(RecordingError):
        rendered(singles, cache)


def test_results_are_found_by_all_of_their_key(tmp_path):
    store = ResultStore(tmp_path)
    assert store.load(KEY) is None
    store.save(KEY, {"xy": [[1.5, 2.0]]})
    assert ResultStore(tmp_path).load(dict(reversed(KEY.items()))) == {"xy": [[1.5, 2.0]]}
    for change in ({"code": "2"}, {"train": [["f00d", [1]]]}, {"contender": {"name": "b"}}):
        assert store.load({**KEY, **change}) is None


@pytest.mark.parametrize("text", ["", "{", "[]", '{"key": 1}', b"\xff"])
def test_a_damaged_result_is_no_result(tmp_path, text):
    store = ResultStore(tmp_path)
    store.save(KEY, {"xy": []})
    (path,) = (tmp_path / "results").iterdir()
    path.write_bytes(text.encode() if isinstance(text, str) else text)
    assert store.load(KEY) is None


def test_a_key_without_its_result_is_no_result(tmp_path):
    store = ResultStore(tmp_path)
    store.save(KEY, {"xy": []})
    (path,) = (tmp_path / "results").iterdir()
    path.write_text(path.read_text(encoding="utf-8").replace('"result"', '"resolt"'), encoding="utf-8")
    assert store.load(KEY) is None


def test_a_file_is_no_place_for_results(tmp_path):
    (tmp_path / "results").write_text("")
    with pytest.raises(InputError, match=r"cache folder .*results cannot be made: File exists; choose another place"):
        ResultStore(tmp_path).save(KEY, {})


def test_default_cache(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert default_cache() == tmp_path / "andante" / "simulated"
    for ignored in ("", "relative/folder"):
        monkeypatch.setenv("XDG_CACHE_HOME", ignored)
        assert default_cache() == Path.home() / ".cache" / "andante" / "simulated"


def test_code_hash_is_stable():
    assert len(code_hash()) == 16
    code_hash.cache_clear()
    assert code_hash() == code_hash()
