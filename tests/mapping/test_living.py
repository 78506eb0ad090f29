"""Maps that learn more: exactly as if all had been there from the beginning, and nothing that does harm."""

import dataclasses

import numpy as np
import pytest

from andante.data import Pose2D
from andante.errors import MapError, RecordingError, SessionRefusedError
from andante.mapping import MapConfig, SlowMap, build_map, merge_maps, update_map
from andante.recordings import MemoryRecording


@pytest.fixture(scope="module")
def friday(garden):
    return garden.another_day()


@pytest.fixture(scope="module")
def updated(slowmap, friday) -> tuple:
    return update_map(slowmap, friday)


def with_poses(recording: MemoryRecording, poses: np.ndarray, name: str = "forged") -> MemoryRecording:
    """The same pictures, taken elsewhere if one believes the table."""
    return MemoryRecording(
        [recording.load(info) for info in recording.infos],
        [info.timestamp_s for info in recording.infos],
        recording.camera,
        reference=[Pose2D(*pose) for pose in poses.tolist()],
        name=name,
    )


def poses_of(recording: MemoryRecording) -> np.ndarray:
    return np.array([(info.reference.x_m, info.reference.y_m, info.reference.heading_rad) for info in recording.infos])


def test_an_updated_map_is_the_map_of_all_recordings(updated, days, friday, tmp_path):
    together = build_map([*days, friday])
    updated[0].save(tmp_path / "updated.andante")
    together.save(tmp_path / "together.andante")
    assert (tmp_path / "updated.andante").read_bytes() == (tmp_path / "together.andante").read_bytes()


def test_the_same_through_a_file_and_up_to_rounding_in_the_subspace(slowmap, updated, friday, tmp_path):
    slowmap.save(tmp_path / "m.andante")
    loaded, _ = update_map(SlowMap.load(tmp_path / "m.andante", with_memory=True), friday)
    one, other = (np.linalg.qr(m.model._rows.T.astype(float))[0] for m in (loaded, updated[0]))
    assert np.linalg.norm(one @ (one.T @ other) - other) < 1e-8


def test_phases_are_remembered_as_they_were_and_headings_learnt_from_all(slowmap, updated, days, friday, tmp_path):
    merged, _ = merge_maps(slowmap, build_map([days[1], friday]))
    alone = build_map([friday]).memory[0]
    for learnt in (updated[0], merged):
        learnt.save(tmp_path / "m.andante")
        for built in (learnt, SlowMap.load(tmp_path / "m.andante", with_memory=True)):
            for session, expected in zip(built.memory, [*slowmap.memory, alone], strict=True):
                np.testing.assert_array_equal(session.phase.codes, expected.phase.codes)
                np.testing.assert_array_equal(session.phase.scale, expected.phase.scale)
        off = []
        for info in friday.infos:
            turn = learnt.localize(friday.load(info)).heading_rad - info.reference.heading_rad
            off.append(abs(np.degrees(np.mod(turn + np.pi, 2 * np.pi) - np.pi)))
        assert np.median(off) < 1
        assert learnt.calibration.heading_factor < 2 * slowmap.calibration.heading_factor


def test_what_the_trial_tells(updated, friday):
    trial = updated[1]
    assert trial.objection is None
    assert (trial.name, trial.frames, trial.overlap) == ("friday", 37, 37)
    assert trial.agreeing > 0.9
    assert trial.chance < 0.3
    assert trial.contradicting == 0
    assert trial.before is not None
    assert trial.as_dict()["objection"] is None


def test_more_drives_make_a_better_map(slowmap, updated, garden, errors_m):
    sunday = garden.drive(garden.loop(41, 0.7, 3.0), name="sunday", gain=1.1, offset=-20)
    # Mapped places against mapped places: what is imagined between them is coarser, however much is mapped.
    before, after = (dataclasses.replace(one, scenery=None) for one in (slowmap, updated[0]))
    assert errors_m(after, sunday).mean() < 1.1 * errors_m(before, sunday).mean()


def test_shuffled_poses_are_refused(slowmap, friday):
    rng = np.random.default_rng(0)
    forged = with_poses(friday, rng.permutation(poses_of(friday)))
    with pytest.raises(SessionRefusedError, match=r"'forged' would make the map worse: of \d+ images .* --force"):
        update_map(slowmap, forged)
    learnt, trial = update_map(slowmap, forged, force=True)
    assert len(learnt.sources) == 3
    assert "wrong poses" in trial.objection


def test_partly_shuffled_poses_are_refused(slowmap, friday):
    poses = poses_of(friday)
    poses[20:] = poses[20:][np.random.default_rng(1).permutation(17)]
    with pytest.raises(SessionRefusedError, match="would make the map worse"):
        update_map(slowmap, with_poses(friday, poses))


def test_a_shifted_frame_of_reference_is_refused(slowmap, friday):
    with pytest.raises(SessionRefusedError, match=r"off by 0\.\d+ m in the median"):
        update_map(slowmap, with_poses(friday, poses_of(friday) + np.array([0.75, 0.0, 0.0])))


def test_another_garden_is_refused(slowmap, other_garden):
    with pytest.raises(SessionRefusedError, match="where they claim to be"):
        update_map(slowmap, other_garden.another_day())


def test_a_docked_robot_is_refused(slowmap, friday):
    dock = np.repeat(poses_of(friday)[:1], 37, axis=0) + np.random.default_rng(2).normal(0, 0.02, (37, 3))
    with pytest.raises(
        SessionRefusedError, match=r"has \d+ images of [1-4] places, at least 10 of 5 are needed: .* dock"
    ):
        update_map(slowmap, with_poses(friday, dock))


def test_a_drive_that_touches_nothing_mapped_cannot_be_judged(slowmap, garden):
    outside = garden.drive(garden.loop(40, 0.0, 6.0), name="outside")
    with pytest.raises(SessionRefusedError, match=r"0 of its 40 images were taken near mapped places"):
        update_map(slowmap, outside)


def test_a_drive_into_new_places_is_welcome(slowmap, garden):
    turn = np.linspace(0, np.pi, 30)
    inward = np.column_stack([3.6 * np.cos(turn), 3 * np.sin(turn) * np.linspace(1, 0.35, 30), turn])
    learnt, trial = update_map(slowmap, garden.drive(inward, name="inward"))
    assert trial.overlap < trial.frames
    assert len(learnt.sources) == 3


def test_what_is_in_the_map_already(slowmap, days, friday):
    with pytest.raises(RecordingError, match="'monday' is in the map already"):
        update_map(slowmap, days[0])
    with pytest.raises(RecordingError, match=r"'monday' and 'forged' have 60 pictures in common"):
        update_map(slowmap, with_poses(days[0], poses_of(days[0]) + 0.001))


def test_a_map_without_memory(days, friday):
    config = slim_config()
    with pytest.raises(MapError, match=r"does not remember its frames.* --localize-only"):
        update_map(build_map(days, config), friday)


def slim_config() -> MapConfig:
    return MapConfig().with_values({"memory": {"keep": False}})


def test_merged_maps_are_the_map_of_all_their_recordings(days, friday, slowmap, tmp_path):
    other = build_map([days[1], friday])
    merged, trials = merge_maps(slowmap, other)
    assert [trial.name for trial in trials] == ["friday"]
    merged.save(tmp_path / "merged.andante")
    build_map([*days, friday]).save(tmp_path / "together.andante")
    assert (tmp_path / "merged.andante").read_bytes() == (tmp_path / "together.andante").read_bytes()


def test_maps_that_cannot_be_merged(slowmap, friday, other_garden, days):
    other = build_map([friday], MapConfig().with_values({"features": {"n_frequencies": 20}}))
    with pytest.raises(MapError, match="differ in features"):
        merge_maps(slowmap, other)
    with pytest.raises(SessionRefusedError, match="would make the map worse"):
        merge_maps(slowmap, build_map([other_garden.another_day()]))
    with pytest.raises(MapError, match="does not remember"):
        merge_maps(slowmap, build_map([friday], slim_config()))


def test_frames_that_claim_to_be_off_the_map_are_judged_too(garden, friday):
    """A map of one drive knows no held-out session; what it knows for sure is enough against a jump of the receiver."""
    monday = build_map([garden.drive(garden.loop(60), name="monday")])
    jumped = poses_of(friday)
    jumped[28:] += [25.0, 0.0, 0.0]
    with pytest.raises(SessionRefusedError, match=r"knows \d+% of its images from other places"):
        update_map(monday, with_poses(friday, jumped))
    late = np.roll(poses_of(friday), 2, axis=0)
    with pytest.raises(SessionRefusedError, match=r"off by \d\.\d+ m in the median|where they claim to be"):
        update_map(monday, with_poses(friday, late))
    learnt, trial = update_map(monday, friday)
    assert (trial.before, trial.after) == (None, None)
    assert len(learnt.sources) == 2


def test_a_drive_that_knows_only_odometry_does_not_fit_surveyed_poses(slowmap, friday, copied):
    blind = copied(friday, reference=None, odometry=[info.reference for info in friday.infos])
    with pytest.raises(RecordingError, match=r"has no reference positions.* fits a map of odometry alone"):
        update_map(slowmap, blind)
