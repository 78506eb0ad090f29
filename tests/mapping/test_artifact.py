"""The map file: exact, atomic, and never trusted."""

import contextlib
import copy
import dataclasses
import json
import os
import struct
import tracemalloc
from itertools import combinations
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from safetensors.numpy import load, save

from andante.errors import ImageError, MapError
from andante.mapping import MapConfig, SlowMap, build_map
from andante.mapping.codes import Codes
from andante.recordings import open_recording

SEVERAL = settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
KINDS = {
    "local": {},
    "polynomial": {"readout": {"kind": "polynomial", "inputs": 4}},
    "gaussian-process": {"readout": {"kind": "gaussian-process"}},
    "network": {
        "features": {"kind": "pixels"},
        "network": {
            "layers": [
                {"output_dim": 6, "field": (12, 6), "stride": (6, 3), "reduced_dim": 8},
                {"output_dim": 4, "field": (4, 3), "stride": (4, 1), "reduced_dim": 10},
            ],
        },
    },
    "quadratic": {"learning": {"expansion": "quadratic", "slow_features": 6, "reduced_dim": 8}},
}


HELD_BY_MAPS = ("f2", "f4", "f8", "i1", "i8", "u1", "u4")
WIDENED = ("readout.numbers", "model.quadratic.", "compass.cell", "scenery.radius")
"""Arrays that are read as numbers of double precision, whichever type of a map they have."""
MEMORY = {f"memory.{name}" for name in ("codes", "scale", "phase.codes", "phase.scale", "xy", "heading", "number")}


@pytest.fixture(scope="module")
def maps(days, small_config) -> dict[str, SlowMap]:
    small = small_config.with_values({"features": {"n_frequencies": 6, "orientations": 0}})
    return {kind: build_map(days, small.with_values(values)) for kind, values in KINDS.items()}


@pytest.fixture(scope="module")
def files(maps, tmp_path_factory) -> dict[str, bytes]:
    folder = tmp_path_factory.mktemp("maps")
    for kind, built in maps.items():
        built.save(folder / kind)
    return {kind: (folder / kind).read_bytes() for kind in maps}


def parts(data: bytes) -> tuple[dict, dict[str, np.ndarray]]:
    """Header and arrays of a map file."""
    (length,) = struct.unpack("<Q", data[:8])
    return json.loads(json.loads(data[8 : 8 + length])["__metadata__"]["andante"]), load(data)


def joined(header: dict, arrays: dict[str, np.ndarray]) -> bytes:
    contiguous = {name: np.ascontiguousarray(array) for name, array in arrays.items()}
    return save(contiguous, metadata={"andante": json.dumps(header)})


def refused(data: bytes, folder: Path, *, in_memory: bool = False) -> str:
    """The message with which a file is refused, with its memory and, unless the fault is in there, without."""
    path = folder / "bad.andante"
    path.write_bytes(data)
    messages = []
    for with_memory in (True,) if in_memory else (True, False):
        with pytest.raises(MapError) as caught:
            SlowMap.load(path, with_memory=with_memory)
        messages.append(str(caught.value))
    message = messages[0]
    assert "\n" not in message
    assert message.startswith(f"map {path} ")
    assert len(message) < 600
    return message


def same_memory(one: SlowMap, other: SlowMap) -> None:
    for mine, theirs in zip(one.memory, other.memory, strict=True):
        assert mine.source == theirs.source
        for name in ("xy", "heading_rad", "number", "pictures"):
            np.testing.assert_array_equal(getattr(mine, name), getattr(theirs, name))
        for codes, others in ((mine.codes, theirs.codes), (mine.phase, theirs.phase)):
            np.testing.assert_array_equal(codes.codes, others.codes)
            np.testing.assert_array_equal(codes.scale, others.scale)


@pytest.mark.parametrize("kind", KINDS)
def test_a_loaded_map_is_the_saved_one(kind, maps, files, garden, tmp_path):
    path = tmp_path / "map.andante"
    assert maps[kind].save(path) == len(files[kind]) == path.stat().st_size
    loaded = SlowMap.load(path, with_memory=True)
    assert (loaded.config, loaded.calibration) == (maps[kind].config, maps[kind].calibration)
    assert loaded.asked == maps[kind].asked
    assert (loaded.sources, loaded.unit, loaded.name) == (maps[kind].sources, maps[kind].unit, maps[kind].name)
    assert loaded.describe() == maps[kind].describe()
    for pose in garden.loop(9, 0.5):
        picture = garden.panorama(pose)
        assert loaded.localize(picture).as_dict() == maps[kind].localize(picture).as_dict()
        np.testing.assert_array_equal(loaded.slow_features(picture), maps[kind].slow_features(picture))
    np.testing.assert_array_equal(loaded.pictures, maps[kind].pictures)
    same_memory(loaded, maps[kind])
    loaded.save(path)
    assert path.read_bytes() == files[kind]


@pytest.mark.parametrize("kind", KINDS)
def test_a_map_needs_no_memory_to_localize(kind, maps, files, garden, tmp_path):
    path = tmp_path / "map.andante"
    path.write_bytes(files[kind])
    loaded = SlowMap.load(path)
    assert loaded.memory is None
    np.testing.assert_array_equal(loaded.pictures, maps[kind].pictures)
    pictures = [garden.panorama(pose) for pose in garden.loop(9, 0.5)]
    expected = [maps[kind].localize(picture).as_dict() for picture in pictures]
    assert [loaded.localize(picture).as_dict() for picture in pictures] == expected
    assert loaded.describe() == maps[kind].describe()
    # Saved so, it is smaller by its memory and by nothing else.
    assert loaded.save(path) < len(files[kind])
    header, arrays = parts(path.read_bytes())
    whole_header, whole = parts(files[kind])
    whole_header["asked"]["memory"]["keep"] = False
    assert header == whole_header
    assert set(whole) - set(arrays) == MEMORY
    for name, array in arrays.items():
        np.testing.assert_array_equal(array, whole[name])
    forgetful = SlowMap.load(path, with_memory=True)
    assert forgetful.memory is None
    assert [forgetful.localize(picture).as_dict() for picture in pictures] == expected


def test_arrays_in_any_memory_layout_are_written_right(maps, garden, tmp_path):
    built = maps["local"]
    codes = built.readout.codes
    strided = Codes(np.repeat(codes.codes, 2, axis=1)[:, ::2], np.repeat(codes.scale, 2)[::2])
    readout = dataclasses.replace(built.readout, codes=strided, xy=np.asfortranarray(built.readout.xy))
    model = dataclasses.replace(built.model, weights=np.asfortranarray(built.model.weights))
    pictures = tuple(np.repeat(own, 2)[::2] for own in built.pictures)
    memory = tuple(dataclasses.replace(session, xy=np.asfortranarray(session.xy)) for session in built.memory)
    assert not strided.codes.flags.c_contiguous
    dataclasses.replace(built, readout=readout, model=model, pictures=pictures, memory=memory).save(
        tmp_path / "map.andante"
    )
    loaded = SlowMap.load(tmp_path / "map.andante", with_memory=True)
    np.testing.assert_array_equal(loaded.readout.references, built.readout.references)
    np.testing.assert_array_equal(loaded.readout.xy, built.readout.xy)
    np.testing.assert_array_equal(loaded.model.weights, built.model.weights)
    np.testing.assert_array_equal(loaded.pictures, built.pictures)
    same_memory(loaded, built)


def test_a_new_file_has_the_rights_that_any_new_file_has(maps, tmp_path):
    (tmp_path / "plain").touch()
    maps["local"].save(tmp_path / "map.andante")
    assert (tmp_path / "map.andante").stat().st_mode == (tmp_path / "plain").stat().st_mode


@pytest.mark.parametrize("step", ["replace", "fsync"])
def test_a_write_that_fails_leaves_the_old_map_and_nothing_else(maps, files, tmp_path, monkeypatch, step):
    path = tmp_path / "map.andante"
    maps["local"].save(path)

    def fail(*arguments):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(os, step, fail)
    with pytest.raises(
        MapError, match=r"map\.andante cannot be written: No space left on device; choose another place"
    ):
        maps["polynomial"].save(path)
    monkeypatch.undo()
    assert path.read_bytes() == files["local"]
    assert list(tmp_path.iterdir()) == [path]


def test_an_interrupt_leaves_nothing_behind(maps, tmp_path, monkeypatch):
    def interrupt(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "fsync", interrupt)
    with pytest.raises(KeyboardInterrupt):
        maps["local"].save(tmp_path / "map.andante")
    assert list(tmp_path.iterdir()) == []


def test_places_that_cannot_be_written(maps, tmp_path):
    (tmp_path / "file").touch()
    for place in (tmp_path / "nowhere" / "map.andante", tmp_path / "file" / "map.andante", tmp_path):
        with pytest.raises(MapError, match="cannot be written"):
            maps["local"].save(place)
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


@pytest.mark.parametrize("condition", [float("nan"), {1, 2}, object()])
def test_conditions_that_no_file_can_hold(maps, tmp_path, condition):
    source = dataclasses.replace(maps["local"].sources[0], conditions={"weather": condition})
    with pytest.raises(MapError, match="conditions of recordings hold text, finite numbers") as caught:
        dataclasses.replace(maps["local"], sources=(source,)).save(tmp_path / "map.andante")
    assert "\n" not in str(caught.value)
    assert list(tmp_path.iterdir()) == []


def test_places_that_cannot_be_read(tmp_path):
    with pytest.raises(
        MapError, match=r"nowhere/map\.andante cannot be read: No such file or directory; make one with"
    ):
        SlowMap.load(tmp_path / "nowhere" / "map.andante")
    with pytest.raises(MapError, match="is a folder, not a map"):
        SlowMap.load(tmp_path)
    os.mkfifo(tmp_path / "pipe")
    with pytest.raises(MapError, match="is no map"):
        SlowMap.load(tmp_path / "pipe")


def test_a_file_too_large_for_a_map_is_not_read(tmp_path):
    with (tmp_path / "large").open("wb") as file:
        file.truncate(2**31 + 1)
    with pytest.raises(MapError, match=r"2147483649 bytes, a map is a file of at most 2147483648"):
        SlowMap.load(tmp_path / "large")


def test_recording_and_map_can_move_together(garden, on_disk, small_config, tmp_path, monkeypatch):
    home = tmp_path / "home"
    home.mkdir()
    recording = on_disk(garden.drive(garden.loop(30)), home / "monday")
    monkeypatch.chdir(home)
    built = build_map([open_recording("monday")], small_config)
    assert built.sources[0].folder == str(home / "monday")
    monkeypatch.chdir(tmp_path)
    built.save(home / "map.andante")
    home.rename(tmp_path / "moved")
    folder = SlowMap.load("moved/map.andante").sources[0].folder
    assert folder == str(tmp_path / "moved" / "monday")
    assert open_recording(folder).content_hash() == built.sources[0].content_hash
    assert recording.name == "monday"


@SEVERAL
@given(kind=st.sampled_from(sorted(KINDS)), share=st.floats(0, 1, exclude_max=True))
def test_truncated_files_are_refused(files, tmp_path, kind, share):
    whole = files[kind]
    refused(whole[: int(share * len(whole))], tmp_path)


@pytest.mark.parametrize("length", [0, 1, 7, 8, 9, 100])
def test_files_truncated_inside_their_header_are_refused(files, tmp_path, length):
    refused(files["local"][:length], tmp_path)


@SEVERAL
@given(st.binary(max_size=200))
def test_random_bytes_are_refused(tmp_path, data):
    assert "is damaged or no map" in refused(data, tmp_path)


@SEVERAL
@given(kind=st.sampled_from(sorted(KINDS)), where=st.floats(0, 1, exclude_max=True))
def test_a_flipped_bit_in_the_header_is_refused_or_harmless(files, tmp_path, garden, kind, where):
    whole = bytearray(files[kind])
    (length,) = struct.unpack("<Q", whole[:8])
    bit = int(where * 8 * (8 + length))
    whole[bit // 8] ^= 1 << bit % 8
    path = tmp_path / "bad.andante"
    path.write_bytes(whole)
    # Where only a digit or a letter changed to another one, the map is another but sound one.
    with contextlib.suppress(MapError, ImageError):
        SlowMap.load(path).localize(garden.panorama(garden.loop(9)[0]))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"schema": 4}, "it has schema 4, this version of andante reads 3; upgrade andante"),
        ({"schema": 2}, "it has schema 2, this version of andante reads 3"),
        ({"schema": None}, "it has schema None"),
        ({"schema": 10**400}, "it has schema 1000"),
        ({"unit": "parsec"}, "its unit is wrong: Input should be 'm' or 'place'"),
        ({"name": {"a": 1}}, "its name is wrong"),
        ({"config": {"learning": {"speed": 1}}}, "its config.learning.speed is wrong: Extra inputs are not permitted"),
        ({"config": {"panorama": {"width_px": 10**12}}}, "its config.panorama.width_px is wrong"),
        ({"config": {"panorama": {"width_px": 8}}}, "expected float32"),
        ({"config": {"panorama": {"min_deg": 30, "max_deg": 10}}}, "elevations -90 <= min_deg < max_deg"),
        ({"config": {"features": {"n_frequencies": 0}}}, "its config.features.n_frequencies is wrong"),
        ({"config": {"features": {"kind": "flat"}}}, "expected float32"),
        ({"config": {"readout": {"kind": "gaussian-process"}}}, "this readout lacks the stored arrays"),
        ({"config": 5}, "its config is wrong"),
        ({"asked": {"learning": {"speed": 1}}}, "its asked.learning.speed is wrong: Extra inputs are not permitted"),
        ({"camera": {"model": "telescope"}}, "its camera.model is wrong"),
        ({"camera": {"model": "fisheye"}}, "the camera declares ne"),
        ({"image_shape": [10**12, 120]}, "its image_shape.0 is wrong"),
        ({"image_shape": [0, 120]}, "its image_shape.0 is wrong"),
        ({"image_shape": [12]}, "its image_shape.1 is wrong: Field required"),
        ({"image_shape": [2, 60]}, "expected float32"),
        ({"calibration": {"kind": "guess"}}, "its calibration.kind is wrong"),
        ({"sources": {"a": 1}}, "its sources is wrong"),
        ({"sources": [{"name": "a"}]}, "its sources.0.content_hash is wrong: Field required"),
    ],
)
def test_a_header_that_was_tampered_with(files, tmp_path, change, message):
    header, arrays = parts(files["local"])

    def merge(into: dict, values: dict) -> None:
        for key, value in values.items():
            if isinstance(value, dict) and isinstance(into.get(key), dict) and key != "name":
                merge(into[key], value)
            else:
                into[key] = value

    merge(header, change)
    assert message in refused(joined(header, arrays), tmp_path)


@pytest.mark.parametrize(
    "key", ["config", "asked", "camera", "image_shape", "calibration", "sources", "unit", "schema"]
)
def test_a_header_that_lacks_something(files, tmp_path, key):
    header, arrays = parts(files["local"])
    del header[key]
    assert ("it has schema None" if key == "schema" else f"its {key} is wrong") in refused(
        joined(header, arrays), tmp_path
    )


@pytest.mark.parametrize(
    "text", ["", "{", "[1]", "null", "NaN", "[" * 100_000, '{"schema": 1e999}', '{"schema": Infinity}']
)
def test_a_header_that_is_no_object(files, tmp_path, text):
    data = save(load(files["local"]), metadata={"andante": text})
    refused(data, tmp_path)


def test_other_safetensors_files_are_no_maps(tmp_path):
    assert "it is no Andante map" in refused(save({"a": np.ones(3)}), tmp_path)
    assert "it is no Andante map" in refused(save({"a": np.ones(3)}, metadata={"format": "pt"}), tmp_path)


def test_numbers_in_the_header_that_are_not_finite(files, tmp_path):
    header, arrays = parts(files["local"])
    for value in (float("nan"), float("inf")):
        for path in (("calibration", "radius_factor"), ("camera", "forward_deg"), ("config", "learning", "ridge")):
            changed = copy.deepcopy(header)
            inner = changed
            for key in path[:-1]:
                inner = inner[key]
            inner[path[-1]] = value
            assert "is no finite number" in refused(joined(changed, arrays), tmp_path)


SHAPE_FAULTS = {
    "longer": lambda array: np.concatenate([array, array[-1:]]),
    "deeper": lambda array: array[..., None],
    "shorter": lambda array: array[..., :-1],
    "empty": lambda array: array[:0],
    "flat": lambda array: array.ravel()[0],
}


@pytest.mark.parametrize("kind", KINDS)
def test_arrays_of_other_shapes_and_types_and_none_at_all(files, tmp_path, kind):
    header, arrays = parts(files[kind])
    for name, array in arrays.items():
        others = {other: arrays[other] for other in arrays if other != name}
        in_memory = name in MEMORY
        refused(joined(header, others), tmp_path, in_memory=in_memory)
        for fault in SHAPE_FAULTS.values():
            spoilt = np.asarray(fault(array))
            if spoilt.size == 1 and name.startswith("model.quadratic.rank"):
                continue  # one number is one number, whatever its shape
            if np.ascontiguousarray(spoilt).shape == array.shape:
                continue  # a single number is written as an array of one
            refused(joined(header, others | {name: spoilt}), tmp_path, in_memory=in_memory)
        for dtype in ("f2", "f4", "f8", "i1", "i4", "i8", "u1", "u4", "?", "c8"):
            if array.dtype != np.dtype(dtype) and not (name.startswith(WIDENED) and dtype in HELD_BY_MAPS):
                with np.errstate(invalid="ignore", over="ignore"):
                    spoilt = array.astype(dtype)
                refused(joined(header, others | {name: spoilt}), tmp_path, in_memory=in_memory)


@pytest.mark.parametrize("kind", KINDS)
def test_swapped_arrays(files, tmp_path, kind):
    header, arrays = parts(files[kind])
    for one, other in combinations(arrays, 2):
        same_type = arrays[one].dtype == arrays[other].dtype or one.startswith(WIDENED) or other.startswith(WIDENED)
        if arrays[one].shape != arrays[other].shape or not same_type:
            swapped = arrays | {one: arrays[other], other: arrays[one]}
            refused(joined(header, swapped), tmp_path, in_memory={one, other} <= MEMORY)


@SEVERAL
@given(kind=st.sampled_from(sorted(KINDS)), where=st.floats(0, 1), value=st.sampled_from([np.nan, np.inf, -np.inf]))
def test_numbers_in_arrays_that_are_not_finite(files, tmp_path, kind, where, value):
    header, arrays = parts(files[kind])
    for name, array in arrays.items():
        may_be_unknown = name == "memory.heading" and np.isnan(value)
        if array.dtype.kind == "f" and not may_be_unknown:
            spoilt = array.copy()
            spoilt.flat[round(where * (array.size - 1))] = value
            message = refused(joined(header, arrays | {name: spoilt}), tmp_path, in_memory=name in MEMORY)
            assert f"array {name} holds" in message


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("memory.codes", -128, "array memory.codes or memory.scale holds what nothing is coded as"),
        ("memory.scale", -1e-3, "array memory.codes or memory.scale holds what nothing is coded as"),
        ("readout.codes", -128, "array readout.codes or readout.scale holds what nothing is coded as"),
        ("readout.scale", -1e-3, "array readout.codes or readout.scale holds what nothing is coded as"),
        ("memory.phase.codes", -128, "array memory.phase.codes or memory.phase.scale holds what nothing is coded as"),
        ("memory.phase.scale", -1e-3, "array memory.phase.codes or memory.phase.scale holds what nothing is coded as"),
        ("compass.codes", -128, "array compass.codes or compass.scale holds what nothing is coded as"),
        ("compass.scale", -1e-3, "array compass.codes or compass.scale holds what nothing is coded as"),
    ],
)
def test_codes_that_nothing_is_coded_as(files, tmp_path, name, value, message):
    header, arrays = parts(files["local"])
    arrays[name] = arrays[name].copy()
    arrays[name].flat[7] = value
    assert message in refused(joined(header, arrays), tmp_path, in_memory=name in MEMORY)


@pytest.mark.parametrize(
    ("name", "value", "message"),
    [
        ("compass.xy", 1e10, "array compass.xy holds numbers beyond 1e+09"),
        ("compass.cell", 0.0, "places of 0 m"),
        ("compass.cell", -1.0, "places of -1 m"),
        ("compass.cell", 1e12, "places of 1e+12 m"),
    ],
)
def test_a_compass_that_bearings_would_stumble_over(files, tmp_path, name, value, message):
    header, arrays = parts(files["local"])
    arrays[name] = arrays[name].copy()
    arrays[name].flat[0] = value
    assert message in refused(joined(header, arrays), tmp_path)


def test_a_compass_without_places(files, tmp_path):
    header, arrays = parts(files["local"])
    arrays |= {f"compass.{name}": arrays[f"compass.{name}"][:0] for name in ("codes", "scale", "xy")}
    assert "a compass of 0 places" in refused(joined(header, arrays), tmp_path)


def test_a_compass_is_of_no_use_to_a_camera_that_looks_one_way(files, tmp_path):
    header, arrays = parts(files["local"])
    header["camera"]["horizontal_field_of_view_deg"] = 200.0
    header["config"]["features"]["kind"] = "fourier"
    remembered = {name: array for name, array in arrays.items() if name not in MEMORY}
    assert "it has a compass, which its camera cannot use" in refused(joined(header, remembered), tmp_path)


def test_a_map_that_lost_its_compass_still_finds_places(maps, files, garden, tmp_path):
    header, arrays = parts(files["local"])
    left = {name: array for name, array in arrays.items() if not name.startswith(("compass.", "scenery."))}
    header["calibration"]["views"] = None
    path = tmp_path / "map.andante"
    path.write_bytes(joined(header, left))
    loaded, pose = SlowMap.load(path), garden.loop(9)[2]
    estimate, whole = (one.localize(garden.panorama(pose)) for one in (loaded, maps["local"]))
    assert (estimate.heading_rad, loaded.compass) == (None, None)
    assert np.hypot(estimate.x_m - whole.x_m, estimate.y_m - whole.y_m) < 0.2


@pytest.mark.parametrize("frames", [[59, 60], [60, 61], [0, 0], [61, 60], [2**62, 2**62]])
def test_sources_with_other_numbers_of_frames(files, tmp_path, frames):
    header, arrays = parts(files["local"])
    for source, count in zip(header["sources"], frames, strict=True):
        source["frames"] = count
    assert "array pictures is uint32 of shape (120,), expected uint32" in refused(joined(header, arrays), tmp_path)
    arrays["pictures"] = np.zeros(min(sum(frames), 200), np.uint32)
    if sum(frames) < 200:
        message = refused(joined(header, arrays), tmp_path, in_memory=True)
        assert "array memory.codes is int8 of shape (120, 72)" in message


def test_a_source_of_less_than_nothing(files, tmp_path):
    header, arrays = parts(files["local"])
    header["sources"][0]["frames"], header["sources"][1]["frames"] = -1, 121
    assert "a source has fewer than 0 frames" in refused(joined(header, arrays), tmp_path)


@pytest.mark.parametrize("sessions", [[2], [-1], [0, 2**70], [0, 7]])
def test_a_trial_on_sessions_that_are_not_there(files, tmp_path, sessions):
    header, arrays = parts(files["local"])
    header["calibration"]["folds"][1]["sessions"] = sessions
    message = refused(joined(header, arrays), tmp_path)
    assert "trial 'tuesday' speaks of sessions" in message or "calibration.folds.1.sessions" in message


@pytest.mark.parametrize("sessions", [None, 0, ["a"], [0.5]])
def test_a_trial_on_no_sessions_at_all(files, tmp_path, sessions):
    header, arrays = parts(files["local"])
    header["calibration"]["folds"][1]["sessions"] = sessions
    assert "its calibration.folds.1.sessions" in refused(joined(header, arrays), tmp_path)


@pytest.mark.parametrize("dtype", ["BF16", "F8_E4M3", "F8_E5M2", "BOOL", "U16", "C64", "F16"])
def test_types_that_no_map_holds(tmp_path, dtype):
    size = {"F8_E4M3": 1, "F8_E5M2": 1, "BOOL": 1, "C64": 8}.get(dtype, 2)
    array = {"dtype": dtype, "shape": [1], "data_offsets": [0, size]}
    header = json.dumps({"__metadata__": {"andante": json.dumps({"schema": 3})}, "model.mean": array}).encode()
    refused(struct.pack("<Q", len(header)) + header + bytes(size), tmp_path)


@pytest.mark.parametrize(
    ("kind", "numbers"),
    [
        *(("local", numbers) for numbers in ([0, 8, 8, 1, 1], [1, 0, 8, 1, 1], [1, 1e300, 8, 1, 1], [1, 8, -1, 1, 1])),
        *(("local", numbers) for numbers in ([1, 8, 8, 0, 1], [1, 8, 8, 1, 0], [1, 8, 8, 1])),
        *(("polynomial", numbers) for numbers in ([0, 2], [21, 2], [4, 0], [4, 5], [2**40, 4], [20, 2**60], [-1, 2])),
        *(("gaussian-process", numbers) for numbers in ([0, 1, 1], [1, 0, 1], [1, 1, -1], [1, 1])),
    ],
)
def test_numbers_of_a_readout_that_localizing_would_stumble_over(files, tmp_path, kind, numbers):
    header, arrays = parts(files[kind])
    arrays["readout.numbers"] = np.array(numbers, dtype=arrays["readout.numbers"].dtype)
    refused(joined(header, arrays), tmp_path)


def test_a_singular_factor_is_refused(files, tmp_path):
    header, arrays = parts(files["gaussian-process"])
    arrays["readout.factor"] = arrays["readout.factor"].copy()
    arrays["readout.factor"][3, 3] = 0
    assert "has to be above zero" in refused(joined(header, arrays), tmp_path)


@pytest.mark.parametrize("declared", [2**40, 2**62, -1])
def test_arrays_declared_larger_than_the_file_are_never_made(tmp_path, declared):
    array = {"dtype": "F32", "shape": [declared], "data_offsets": [0, 4 * max(declared, 1)]}
    header = json.dumps({"__metadata__": {"andante": "{}"}, "model.mean": array}).encode()
    assert "is damaged or no map" in refused(struct.pack("<Q", len(header)) + header + bytes(64), tmp_path)


@pytest.mark.parametrize("camera", ["panorama", "fisheye"])
def test_absurd_but_allowed_settings_cost_little_memory(files, fisheye_map, tmp_path, camera):
    header, arrays = parts(files["local"])
    header["config"] = (
        MapConfig().with_values({"panorama": {"width_px": 4096, "height_px": 2048}}).model_dump(mode="json")
    )
    header["image_shape"] = [2**16, 2**16]
    if camera == "fisheye":
        header["camera"] = dataclasses.asdict(fisheye_map.front_end.camera)
    else:
        header["camera"]["forward_deg"] = 90.0
    data = joined(header, arrays)
    tracemalloc.start()
    try:
        refused(data, tmp_path)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert peak < 600e6
