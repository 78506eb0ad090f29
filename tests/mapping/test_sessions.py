"""From a recording to what can be learnt from: which frames, where, which features, and never a drive twice."""

import dataclasses

import numpy as np
import pytest

from andante.data import Pose2D
from andante.errors import ConfigError, RecordingError
from andante.mapping import BuildLog, FrontEnd, MapConfig, build_map, encode_session
from andante.mapping import sessions as sessions_module
from andante.mapping.frontend import camera_and_size
from andante.mapping.sessions import (
    positions_of,
    require_distinct,
    short_fingerprint,
    unused_positions,
    usable_frames,
)
from andante.recordings import picture_fingerprint

CONFIG = MapConfig()


@pytest.fixture(scope="module")
def front_end(days) -> FrontEnd:
    return FrontEnd(*camera_and_size(days[0]), CONFIG.panorama, CONFIG.features)


@pytest.fixture(scope="module")
def encode(front_end):
    """``encode(recording)`` -> the mapped session."""
    return lambda recording, **more: encode_session(recording, front_end, "reference", CONFIG, **more)


@pytest.fixture(scope="module")
def monday(days, encode):
    return encode(days[0])


def without_place(recording, gone: set[int], copied):
    reference = [None if info.index in gone else info.reference for info in recording.infos]
    return copied(recording, reference=reference)


def test_a_session_is_what_the_recording_shows(monday, days, front_end):
    day = days[0]
    pictures = [day.load(info) for info in day.infos]
    np.testing.assert_array_equal(monday.xy, [(info.reference.x_m, info.reference.y_m) for info in day.infos])
    np.testing.assert_array_equal(monday.number, np.arange(60))
    features = np.array([front_end.features(picture) for picture in pictures])
    np.testing.assert_allclose(monday.codes.rows(), features, atol=0.01)
    assert monday.pictures.dtype == np.uint32
    assert monday.pictures.tolist() == [short_fingerprint(picture_fingerprint(picture)) for picture in pictures]
    source = monday.source
    assert (source.name, source.content_hash, source.frames) == ("monday", day.content_hash(), 60)
    assert (source.poses, source.conditions, source.skipped, source.folder) == ("reference", {"gain": 1.0}, (), None)


def test_frames_without_a_place_and_of_a_stand_are_left_out(garden, encode, copied):
    poses = garden.loop(40)
    drive = garden.drive(np.insert(poses, 20, np.repeat(poses[20:21], 5, axis=0), axis=0))
    log = BuildLog()
    session = encode(without_place(drive, {3, 30}, copied), log=log)
    assert session.number.tolist() == [*range(3), *range(4, 21), *range(26, 30), *range(31, 45)]
    assert (log.stationary, log.without_position) == (5, 2)
    assert set(log.seconds) == {"decode", "features"}
    assert len(session) == len(session.codes) == len(session.pictures) == session.source.frames == 38


def test_a_picture_gives_the_same_codes_whatever_else_is_there(garden, days, encode, copied, monkeypatch):
    """Neither its neighbours, their number and order, nor the size of stacks decide what a frame becomes."""
    whole = encode(days[0])
    few = encode(without_place(days[0], set(range(60)) - {7, 20, 59}, copied))
    np.testing.assert_array_equal(few.codes.codes, whole.codes.codes[[7, 20, 59]])
    np.testing.assert_array_equal(few.codes.scale, whole.codes.scale[[7, 20, 59]])
    pictures = [days[0].load(info) for info in days[0].infos]
    reversed_day = copied(days[0], images=pictures[::-1])
    monkeypatch.setattr(sessions_module, "STACK", 5)
    backwards = encode(reversed_day)
    np.testing.assert_array_equal(backwards.codes.codes, whole.codes.codes[::-1])
    np.testing.assert_array_equal(backwards.codes.scale, whole.codes.scale[::-1])
    np.testing.assert_array_equal(backwards.pictures, whole.pictures[::-1])


def test_unreadable_pictures_are_named_without_their_folder(days, on_disk, encode):
    recording = on_disk(days[0])
    for index in (4, 17):
        (recording.folder / recording.infos[index].image).write_bytes(b"no picture")
    log = BuildLog()
    session = encode(recording, log=log)
    assert session.number.tolist() == [index for index in range(60) if index not in (4, 17)]
    assert len(session) == session.source.frames == len(session.pictures) == len(session.codes) == 58
    assert session.source.folder == str(recording.folder.resolve())
    assert len(session.source.skipped) == 2
    for reason, index in zip(session.source.skipped, (4, 17), strict=True):
        assert recording.infos[index].image in reason
        assert str(recording.folder) not in reason
        assert str(recording.folder.parent) not in reason


def test_progress_counts_to_the_end(days, encode):
    told = []
    encode(days[0], progress=lambda *step: told.append(step))
    assert {step[0] for step in told} == {"monday"}
    assert [done for _, done, _ in told] == sorted({done for _, done, _ in told})
    assert told[-1] == ("monday", 60, 60)


def test_a_camera_of_another_kind_is_refused(garden, encode):
    with pytest.raises(ConfigError, match=r"this map was made from panorama images .* the new fisheye camera gives"):
        encode(garden.drive(garden.loop(30), fisheye=True, name="up"))


def test_of_a_stand_the_first_frame_with_a_position_is_kept(garden, copied):
    drive = garden.drive(garden.loop(12))
    still = [Pose2D(1.0, 1.0)] * 6 + [Pose2D(2.0 + i, 1.0) for i in range(6)]
    reference = [None, None, None, *(info.reference for info in drive.infos[3:])]
    indices, xy = usable_frames(copied(drive, odometry=still, reference=reference), "reference", MapConfig())
    assert indices == list(range(3, 12))
    np.testing.assert_array_equal(xy[0], [reference[3].x_m, reference[3].y_m])
    indices, _ = usable_frames(copied(drive, odometry=still, reference=None), "odometry", MapConfig())
    assert indices == [0, *range(6, 12)]


@pytest.mark.parametrize(
    ("positions", "columns"),
    [("reference", "x_m and y_m"), ("odometry", "odom_x_m and odom_y_m"), ("place", "place")],
)
def test_no_frame_with_a_position_is_an_error_that_names_the_columns(days, copied, positions, columns):
    blind = copied(days[1], reference=None)
    message = (
        rf"'tuesday' has no {positions} positions \({columns} of frames\.csv are blank\); choose other --positions"
    )
    with pytest.raises(RecordingError, match=message):
        usable_frames(blind, positions, CONFIG)


def test_places_are_numbers_on_a_line(days, copied):
    numbered = copied(days[0], reference=None, place=[None, *range(1, 60)])
    indices, xy = usable_frames(numbered, "place", CONFIG)
    assert indices == list(range(1, 60))
    np.testing.assert_array_equal(xy, [(float(place), 0.0) for place in range(1, 60)])


def test_positions_that_are_asked_for_are_taken(days):
    for wanted in ("reference", "odometry", "place"):
        assert positions_of(days, wanted) == wanted


def test_positions_are_found(days, copied):
    poses = [Pose2D(0.1 * i, 9.0) for i in range(60)]
    full = [copied(day, odometry=poses, place=list(range(60))) for day in days]
    places = [copied(day, reference=None) for day in full]
    odometry = [copied(day, reference=None, place=None) for day in full]
    assert positions_of(full, "auto") == "reference"
    assert positions_of(places, "auto") == "place"
    assert positions_of([full[0], places[1]], "auto") == "place"
    assert positions_of(odometry[:1], "auto") == "odometry"
    assert positions_of(odometry, "auto") == "odometry"
    with pytest.raises(RecordingError, match="no kind of position in common"):
        positions_of([odometry[0], copied(days[1])], "auto")


def test_no_recordings_have_no_positions():
    with pytest.raises(RecordingError, match="a map needs at least one recording, got none"):
        positions_of([], "reference")


def test_a_single_recording_without_any_positions(days, copied):
    with pytest.raises(RecordingError, match=r"'monday' has neither reference poses, places nor odometry; a map needs"):
        positions_of([copied(days[0], reference=None)], "auto")


def test_no_positions(days, copied):
    blind = copied(days[1], reference=None)
    with pytest.raises(RecordingError, match="recording 'tuesday' has neither reference poses, places nor odometry"):
        build_map([days[0], blind])
    with pytest.raises(RecordingError, match=r"'tuesday' has no reference positions \(x_m and y_m of frames\.csv are"):
        build_map([days[0], blind], MapConfig(positions="reference"))
    with pytest.raises(RecordingError, match=r"'monday' has no place positions \(place of frames\.csv are blank"):
        build_map(days, MapConfig(positions="place"))


def test_different_drives_are_distinct(days, encode, monday):
    require_distinct([])
    require_distinct([monday])
    require_distinct([monday, encode(days[1])])


def test_the_same_content_is_not_distinct(monday, days, encode):
    twin = dataclasses.replace(monday, source=dataclasses.replace(monday.source, name="twin"))
    with pytest.raises(RecordingError, match="recordings 'monday' and 'twin' have the same content; leave one out"):
        require_distinct([monday, encode(days[1]), twin])


@pytest.mark.parametrize(("common", "distinct"), [(0, True), (3, True), (4, False), (60, False)])
def test_one_picture_in_twenty_may_be_shared(monday, days, encode, common, distinct):
    tuesday = encode(days[1])
    pictures = np.concatenate([monday.pictures[:common], tuesday.pictures[common:]])
    other = dataclasses.replace(tuesday, pictures=pictures)
    if distinct:
        require_distinct([monday, other])
    else:
        message = f"recordings 'monday' and 'tuesday' have {common} pictures in common; leave one out"
        with pytest.raises(RecordingError, match=message):
            require_distinct([monday, other])


def test_a_piece_of_a_drive_is_not_distinct(monday):
    """However short: what counts is the share of the shorter one."""
    piece = monday.subset(np.arange(10, 13))
    piece = dataclasses.replace(piece, source=dataclasses.replace(piece.source, name="piece", content_hash="other"))
    with pytest.raises(RecordingError, match="'monday' and 'piece' have 3 pictures in common"):
        require_distinct([monday, piece])


def test_a_fingerprint_is_shortened_to_32_bits(days):
    whole = picture_fingerprint(days[0].load(days[0].infos[0]))
    assert short_fingerprint(whole) == int(whole, 16) >> (4 * (len(whole) - 8))
    assert 0 <= short_fingerprint(whole) < 2**32


def test_what_is_better_and_not_used_is_said(days, copied):
    odometry = [info.reference for info in days[0].infos]
    both = [copied(day, odometry=odometry) for day in days]
    blind = copied(days[1], reference=None, odometry=odometry)
    assert unused_positions(both, "reference") == ""
    assert unused_positions([both[0], blind], "odometry").endswith("better positions of monday are not used")
