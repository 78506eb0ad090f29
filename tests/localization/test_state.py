"""A state as a file: exact, and never trusted."""

import contextlib
import json
import struct
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from safetensors.numpy import load, save

from andante.data import FrameInfo
from andante.errors import MapError
from andante.localization import KalmanConfig, KalmanTracker, ParticleConfig, ParticleTracker, make_tracker

SEVERAL = settings(max_examples=40, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
FEW = ParticleConfig(particles=60)
OLD = FrameInfo(0, "", 0.0)


def told(estimate):
    return estimate.as_dict(), estimate.hypotheses


@pytest.mark.parametrize("stop", [0, 1, 7, 60])
def test_one_that_is_resumed_never_stopped(world, kind, slowmap, tmp_path, stop):
    poses = world.loop(90)
    evidence, infos = world.images(poses), world.infos(poses)
    one = make_tracker(slowmap, kind, seed=1)
    for seen, info in zip(evidence[:stop], infos, strict=False):
        one.fuse(seen, info)
    one.save(tmp_path / "state")
    other = make_tracker(slowmap, kind, seed=99)
    other.resume(tmp_path / "state")
    for n in range(max(stop - 1, 0), 90):
        seen = evidence[n] if n % 20 else evidence[(n + 40) % 90]
        assert told(one.fuse(seen, infos[n])) == told(other.fuse(seen, infos[n]))
    one.save(tmp_path / "one")
    other.save(tmp_path / "other")
    assert (tmp_path / "one").read_bytes() == (tmp_path / "other").read_bytes()
    assert sorted(path.name for path in tmp_path.iterdir()) == ["one", "other", "state"]


def test_a_state_does_not_grow_with_the_drive(world, slowmap, tmp_path):
    tracker, sizes = ParticleTracker(slowmap, FEW), []
    poses = world.loop(600)
    for n, (seen, info) in enumerate(zip(world.images(poses), world.infos(poses), strict=True)):
        tracker.fuse(seen, info)
        if n in (50, 599):
            tracker.save(tmp_path / "state")
            sizes.append((tmp_path / "state").stat().st_size)
    assert sizes[1] < sizes[0] + 300  # digits of numbers come and go


def test_states_of_others_are_refused(slowmap, other_map, tmp_path):
    ParticleTracker(slowmap, FEW).save(tmp_path / "state")
    for tracker, what in [
        (ParticleTracker(other_map, FEW), "it belongs to another map"),
        (ParticleTracker(slowmap), "a tracker with another configuration"),
        (KalmanTracker(slowmap), "a tracker of kind 'particles'"),
        (KalmanTracker(slowmap, KalmanConfig(gate=3.0)), "a tracker of kind 'particles'"),
    ]:
        with pytest.raises(MapError, match=what):
            tracker.resume(tmp_path / "state")


@pytest.fixture
def moving(world, slowmap):
    tracker = ParticleTracker(slowmap, FEW)
    poses = world.loop(20)
    for seen, info in zip(world.images(poses), world.infos(poses), strict=True):
        tracker.fuse(seen, info)
    return tracker


@SEVERAL
@given(st.data())
def test_damage_is_told_and_changes_nothing(moving, tmp_path, slowmap, data):
    path = tmp_path / "state"
    moving.save(path)
    whole = path.read_bytes()
    cut = data.draw(st.integers(0, len(whole) - 1))
    path.write_bytes(whole[:cut])
    tracker = ParticleTracker(slowmap, FEW)
    with pytest.raises(MapError, match="tracker state"):
        tracker.resume(path)
    (length,) = struct.unpack("<Q", whole[:8])
    at = data.draw(st.integers(0, 8 + length - 1))
    path.write_bytes(whole[:at] + bytes([whole[at] ^ data.draw(st.integers(1, 255))]) + whole[at + 1 :])
    with contextlib.suppress(MapError):  # nothing else is raised; a changed number may well be a state
        tracker.resume(path)


def parts(data):
    (length,) = struct.unpack("<Q", data[:8])
    return json.loads(json.loads(data[8 : 8 + length])["__metadata__"]["andante-tracker"]), load(data)


def refused(moving, path, change):
    moving.save(path)
    header, arrays = parts(path.read_bytes())
    change(header, arrays)
    path.write_bytes(save(arrays, metadata={"andante-tracker": json.dumps(header)}))
    before = moving.fuse(None, OLD)
    with pytest.raises(MapError) as caught:
        moving.resume(path)
    assert told(moving.fuse(None, OLD)) == told(before)
    return str(caught.value)


def test_what_does_not_fit_is_told(moving, tmp_path):
    path = tmp_path / "state"

    def set_nan(header, arrays):
        arrays["filter.state"][0, 0] = np.nan

    def shorten(header, arrays):
        arrays["filter.weight"] = arrays["filter.weight"][:-1].copy()

    def drop(header, arrays):
        del arrays["trail"]

    def newer(header, arrays):
        header["schema_version"] = 9

    def unknown(header, arrays):
        header["surprise"] = 1

    def bad_status(header, arrays):
        header["status"] = "fine"

    def no_generator(header, arrays):
        header["generator"] = None

    def bad_generator(header, arrays):
        header["generator"] = {"bit_generator": "PCG64"}

    def whole_numbers(header, arrays):
        arrays["trail"] = arrays["trail"].astype(np.float32)

    def negative(header, arrays):
        arrays["filter.weight"][0] = -1

    messages = [
        refused(moving, path, change)
        for change in (
            set_nan,
            shorten,
            drop,
            newer,
            unknown,
            bad_status,
            no_generator,
            bad_generator,
            whole_numbers,
            negative,
        )
    ]
    assert "not finite" in messages[0]
    assert "60 particles" in messages[1]
    assert "schema 9" in messages[3]
    assert "F64" in messages[8]
    assert all("begin without it" in message for message in messages)
    assert all(one != other for one, other in pairwise(messages))


def test_places_that_cannot_be_read_or_written(moving, tmp_path, slowmap):
    with pytest.raises(MapError, match="cannot be written"):
        moving.save(tmp_path / "absent" / "state")
    for path in (tmp_path / "absent", tmp_path):
        with pytest.raises(MapError, match="tracker state"):
            moving.resume(path)
    slowmap.save(tmp_path / "map")
    with pytest.raises(MapError, match="no state of a tracker"):
        moving.resume(tmp_path / "map")
