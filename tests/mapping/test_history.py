"""Versions of a map: nothing is ever lost, half written or swapped, whenever the process dies."""

import contextlib
import dataclasses
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest

from andante.errors import MapError
from andante.mapping import SlowMap, update_map
from andante.mapping.history import MAX_VERSIONS, digest_of, replace_map, roll_back, versions_of

UPDATER = """
import sys, time
from andante.mapping import SlowMap
from andante.mapping.history import digest_of, replace_map
path, *others = sys.argv[1:]
maps = [SlowMap.load(other, with_memory=True) for other in others]
print("ready", flush=True)
while True:
    for slowmap in maps:
        replace_map(slowmap, path, expected=digest_of(path))
"""


@pytest.fixture
def path(slowmap, tmp_path):
    slowmap.save(tmp_path / "m.andante")
    return tmp_path / "m.andante"


@pytest.fixture(scope="module")
def next_map(slowmap, garden):
    return update_map(slowmap, garden.another_day())[0]


def test_a_replaced_map_is_kept(path, next_map):
    before = path.read_bytes()
    size = replace_map(next_map, path, expected=digest_of(path))
    assert size == path.stat().st_size
    (version,) = versions_of(path)
    assert (version.number, version.bytes) == (1, len(before))
    assert version.path.read_bytes() == before
    assert len(SlowMap.load(path).sources) == 3


def test_rolling_back_restores_the_bytes_and_loses_nothing(path, slowmap, next_map):
    first = path.read_bytes()
    replace_map(next_map, path, expected=digest_of(path))
    second = path.read_bytes()
    assert roll_back(path).number == 1
    assert path.read_bytes() == first
    assert [version.path.read_bytes() for version in versions_of(path)] == [first, second]
    assert roll_back(path, 2).number == 2
    assert path.read_bytes() == second
    assert len(versions_of(path)) == 2


def test_rolling_back_again_goes_further_back(path, slowmap, next_map):
    states = [path.read_bytes()]
    for slowmap_ in (next_map, SlowMap.load(path)):
        replace_map(slowmap_, path, expected=digest_of(path))
        states.append(path.read_bytes())
    roll_back(path)
    assert path.read_bytes() == states[1]
    roll_back(path)
    assert path.read_bytes() == states[0]
    with pytest.raises(MapError, match=r"has no earlier version; versions kept: 1, 2, 3"):
        roll_back(path)


def test_rolling_back_goes_to_what_the_map_was_before(path, slowmap, next_map):
    """A, then B, back to A, then C: before C the map was A, whatever B was for."""
    third = dataclasses.replace(slowmap, name="third")
    first = path.read_bytes()
    replace_map(next_map, path, expected=digest_of(path))
    roll_back(path)
    replace_map(third, path, expected=digest_of(path))
    roll_back(path)
    assert path.read_bytes() == first


def test_the_predecessor_is_never_among_the_oldest(path, slowmap, next_map):
    first = path.read_bytes()
    for number in range(MAX_VERSIONS - 1):
        replace_map(dataclasses.replace(slowmap, name=f"map{number}", memory=None), path)
    roll_back(path, 1)
    replace_map(next_map, path)
    assert versions_of(path)[-1].path.read_bytes() == first


def test_two_processes_take_turns(path, next_map, monkeypatch):
    """While one changes the map, another waits for the lock and then sees that it has changed."""
    from andante.mapping import history

    expected = digest_of(path)

    @contextlib.contextmanager
    def waited(folder):
        assert folder == path.parent
        next_map.save(path)
        yield

    monkeypatch.setattr(history, "_locked", waited)
    with pytest.raises(MapError, match="changed by someone else meanwhile"):
        replace_map(next_map, path, expected=expected)


def test_a_new_place_has_no_history(slowmap, tmp_path):
    assert replace_map(slowmap, tmp_path / "new.andante") == (tmp_path / "new.andante").stat().st_size
    assert [entry.name for entry in tmp_path.iterdir()] == ["new.andante"]


def test_parts_of_killed_processes_are_swept(path, next_map):
    old = path.parent / f".{path.name}.0123.part"
    young = path.parent / f".{path.name}.4567.part"
    for part in (old, young):
        part.write_bytes(b"half")
    os.utime(old, (0, 0))
    replace_map(next_map, path)
    assert not old.exists()
    assert young.exists()


def test_someone_else_was_faster(path, slowmap, next_map):
    expected = digest_of(path)
    next_map.save(path)
    with pytest.raises(MapError, match="changed by someone else meanwhile; nothing was written"):
        replace_map(slowmap, path, expected=expected)
    assert versions_of(path) == []


def test_faults(path, next_map, tmp_path):
    with pytest.raises(MapError, match="has no earlier version; versions kept: none"):
        roll_back(path)
    with pytest.raises(MapError, match="cannot be read"):
        digest_of(tmp_path / "none.andante")
    replace_map(next_map, path, expected=digest_of(path))
    with pytest.raises(MapError, match="has no version 7; versions kept: 1"):
        roll_back(path, 7)
    versions_of(path)[0].path.write_bytes(b"rotten")
    now = path.read_bytes()
    with pytest.raises(MapError, match=r"version 1 of map .* is damaged"):
        roll_back(path)
    assert path.read_bytes() == now
    (path.parent / "other.andante").write_bytes(now)
    (path.parent / "other.andante.history").write_text("in the way")
    with pytest.raises(MapError, match=r"history of map .* cannot be written"):
        replace_map(next_map, path.parent / "other.andante", expected=digest_of(path))


def test_the_oldest_versions_go(path, slowmap, next_map):
    for number in range(MAX_VERSIONS + 3):
        replace_map(dataclasses.replace(slowmap, name=f"map{number}", memory=None), path, expected=digest_of(path))
    numbers = [version.number for version in versions_of(path)]
    assert len(numbers) == MAX_VERSIONS
    assert numbers[-1] == MAX_VERSIONS + 3


@pytest.mark.skipif(not hasattr(signal, "SIGKILL"), reason="this system cannot kill a process at once")
def test_killed_at_twenty_random_moments_a_whole_map_is_left(path, next_map, tmp_path):
    other = tmp_path / "next.andante"
    next_map.save(other)
    first = tmp_path / "first.andante"
    first.write_bytes(path.read_bytes())
    whole = {first.read_bytes(), other.read_bytes()}
    rng = np.random.default_rng(0)
    for _ in range(20):
        process = subprocess.Popen(
            [sys.executable, "-c", UPDATER, path, other, first], stdout=subprocess.PIPE, env={**os.environ}
        )
        assert process.stdout is not None
        assert process.stdout.readline() == b"ready\n"
        time.sleep(float(rng.uniform(0, 0.05)))
        process.kill()
        process.wait()
        process.stdout.close()
        assert path.read_bytes() in whole
        SlowMap.load(path, with_memory=True)
        assert all(version.path.read_bytes() in whole for version in versions_of(path))


@pytest.mark.skipif(sys.platform == "win32", reason="there are no locks on folders")
def test_the_lock_holds_another_process_off(path, slowmap, next_map):
    """A process that wants to change a map waits until the one before it is done."""
    from andante.mapping.history import _locked

    wait = "with _locked(pathlib.Path(sys.argv[1])): print('in')"
    script = f"import sys, pathlib; from andante.mapping.history import _locked\n{wait}"
    with _locked(path.parent):
        process = subprocess.Popen([sys.executable, "-c", script, path.parent], stdout=subprocess.PIPE)
        with pytest.raises(subprocess.TimeoutExpired):
            process.wait(timeout=1.5)
    assert process.communicate(timeout=30)[0] == b"in\n"
