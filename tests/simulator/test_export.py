import numpy as np
import pytest

from andante.errors import ConfigError, RecordingError
from andante.protocols import Recording
from andante.recordings import open_recording
from andante.simulator import GardenSpec, Plan, Session, SimulatedRecording, render_plan, render_session


@pytest.fixture(scope="module")
def rendered(embree, tiny_plan, tmp_path_factory):
    """The tiny plan, rendered in this process."""
    folder = tmp_path_factory.mktemp("alone")
    return render_plan(tiny_plan, folder, boxes=True)[0]


def content(recording):
    return {path.name: path.read_bytes() for path in recording.folder.rglob("*") if path.is_file()}


def test_it_is_a_recording_with_truth_and_odometry(embree, tiny_plan):
    recording = SimulatedRecording(tiny_plan, "monday")
    assert isinstance(recording, Recording)
    assert recording.infos[0].odometry.x_m == 0.0
    assert recording.infos[1].timestamp_s > recording.infos[0].timestamp_s
    assert recording.load(recording.infos[0]).shape == (64, 64)
    assert recording.load(recording.infos[0], colour=True).shape == (64, 64, 3)
    assert recording.conditions["season"] == "summer"


def test_frames_decoded_in_threads_are_those_rendered_one_by_one(embree, tiny_plan):
    recording = SimulatedRecording(tiny_plan, "monday")
    for frame in recording.frames([0, 3, 7], colour=True):
        np.testing.assert_array_equal(frame.image, recording.rendering(frame.info.index).image)


def test_content_hash_depends_on_the_content_only(tiny_plan):
    first, again = SimulatedRecording(tiny_plan, "monday"), SimulatedRecording(tiny_plan, "monday")
    assert first.content_hash() == again.content_hash()
    other = Plan(garden=tiny_plan.garden, camera=tiny_plan.camera, sessions=(Session(name="monday", seed=2),))
    assert SimulatedRecording(other, "monday").content_hash() != first.content_hash()


def test_what_is_written_is_what_is_rendered(rendered, tiny_plan):
    assert open_recording(rendered.folder).camera == tiny_plan.camera.spec
    fresh = SimulatedRecording(tiny_plan, "monday")
    assert [info.reference for info in rendered.infos] == [info.reference for info in fresh.infos]
    assert [info.odometry for info in rendered.infos] == [info.odometry for info in fresh.infos]
    difference = rendered.load(rendered.infos[4]).astype(int) - fresh.load(fresh.infos[4])
    assert np.abs(difference).mean() < 5  # JPEG


def test_two_processes_write_the_same_bytes_as_one(rendered, tiny_plan, tmp_path):
    twice = render_plan(tiny_plan, tmp_path, workers=2, boxes=True)[0]
    assert content(twice) == content(rendered)
    tables = [r.folder.with_name("monday.boxes.csv").read_bytes() for r in (rendered, twice)]
    assert tables[0] == tables[1]
    assert tables[0].count(b"\n") > len(rendered.infos)


class KilledError(Exception):
    """Stands for a run that was stopped."""


def test_a_killed_run_leaves_nothing_half_done_and_goes_on_with_the_same_bytes(rendered, tiny_plan, tmp_path):
    sessions = (tiny_plan.sessions[0], Session(name="second", seed=2, drive={"kind": "border", "laps": 0.08}))
    plan = Plan(garden=tiny_plan.garden, camera=tiny_plan.camera, sessions=sessions)

    def stop_in_the_second(name, done, _):
        if (name, done) == ("second", 3):
            raise KilledError

    with pytest.raises(KilledError):
        render_plan(plan, tmp_path, boxes=True, progress=stop_in_the_second)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["monday", "monday.boxes.csv"]
    kept = (tmp_path / "monday" / "frames.csv").stat().st_mtime_ns
    seen = []
    both = render_plan(plan, tmp_path, boxes=True, progress=lambda *step: seen.append(step))
    assert (tmp_path / "monday" / "frames.csv").stat().st_mtime_ns == kept
    assert content(both[0]) == content(rendered)
    count = len(both[1].infos)
    assert seen == [("monday", count, count), *(("second", done, count) for done in range(1, count + 1))]


def test_a_folder_that_holds_something_else_is_not_taken_for_a_finished_session(rendered, tiny_plan):
    other = Plan(garden=GardenSpec(seed=9), camera=tiny_plan.camera, sessions=tiny_plan.sessions)
    with pytest.raises(RecordingError, match="holds another recording, not session 'monday' of this plan; remove it"):
        render_session(other, "monday", rendered.folder)


def test_boxes_cannot_be_added_later(embree, tiny_plan, tmp_path):
    short = Plan(camera=tiny_plan.camera, sessions=(Session(name="a", drive={"kind": "poses", "poses": [(0, 0, 0)]}),))
    render_session(short, "a", tmp_path / "a")
    with pytest.raises(RecordingError, match="was rendered without boxes; remove it or choose another folder"):
        render_session(short, "a", tmp_path / "a", boxes=True)


def test_no_workers_render_nothing(tiny_plan, tmp_path):
    with pytest.raises(ConfigError, match="workers = 0 is not allowed; use 1 or more"):
        render_plan(tiny_plan, tmp_path, workers=0)
