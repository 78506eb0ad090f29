import json

import pytest

from andante.data import Status
from andante.errors import LeakageError, RecordingError
from andante.evaluation import evaluate, figures_of
from andante.evaluation.figures import figures_of_run
from andante.mapping import MapConfig, SlowMap, build_map
from andante.recordings import MemoryRecording, open_recording

DESIGN_KEYS = {
    "n", "median_m", "mean_m", "p95_m", "max_m", "share_over_1m", "share_over_3m", "heading_median_deg", "lost_share",
    "ms_per_image",
}  # fmt: skip
BASELINES = ["nearest-1", "nearest-5", "pca + same readout", "ridge regression"]


def test_a_map_of_the_ring_knows_where_it_is(slowmap, make_drive):
    evaluation = evaluate(slowmap, make_drive(3))
    assert evaluation.figures.n == 40
    assert evaluation.figures.median_m < 1
    assert evaluation.baselines == {}
    assert evaluation.verdict is None
    assert evaluation.notes == ()


def test_training_data_is_refused(slowmap, make_drive):
    with pytest.raises(LeakageError, match=r"learnt from recording 'renamed'.*evaluate on another drive") as caught:
        evaluate(slowmap, make_drive(2, name="renamed"))
    assert "\n" not in str(caught.value)


def altered(drive, first=0, last=None, later_s=0.0):
    """Some of the pictures of a drive, at other times."""
    kept = drive.infos[first:last]
    return MemoryRecording(
        [drive.load(info) for info in kept], [info.timestamp_s + later_s for info in kept], drive.camera,
        reference=[info.reference for info in kept], name="altered",
    )  # fmt: skip


@pytest.mark.parametrize("changes", [{"last": -1}, {"first": 30}, {"later_s": 0.5}])
def test_training_pictures_are_refused_in_another_table_too(slowmap, make_drive, tmp_path, changes):
    twin = altered(make_drive(2), **changes)
    assert not slowmap.learnt_from(twin.content_hash())
    with pytest.raises(LeakageError, match="learnt from pictures of recording 'altered'"):
        evaluate(slowmap, twin)
    slowmap.save(tmp_path / "map")
    assert SlowMap.load(tmp_path / "map").share_learnt(twin) == 1
    assert "training error" in evaluate(slowmap, twin, training_error=True).notes[0]
    assert slowmap.share_learnt(make_drive(3)) == 0


def test_two_recordings_of_the_same_pictures_make_no_map(make_drive):
    one = make_drive(1)
    with pytest.raises(RecordingError, match="'drive 1' and 'altered' have 39 pictures in common; leave one out"):
        build_map([one, altered(one, last=-1)], MapConfig())


def test_unless_the_training_error_is_asked_for_and_said_to_be_one(slowmap, make_drive):
    evaluation = evaluate(slowmap, make_drive(2), training_error=True)
    assert "training error" in evaluation.notes[0]
    assert evaluate(slowmap, make_drive(3), training_error=True).notes == ()


def test_a_recording_without_truth_is_refused(slowmap, place_map, make_drive):
    with pytest.raises(RecordingError, match=r"no reference poses \(x_m, y_m in frames.csv\).*andante localize"):
        evaluate(slowmap, make_drive(3, truth=0.0))
    with pytest.raises(RecordingError, match=r"no place numbers \(place in frames.csv\)"):
        evaluate(place_map, make_drive(3))


def test_frames_without_truth_are_localized_but_not_counted(slowmap, make_drive):
    half, whole = evaluate(slowmap, make_drive(3, truth=0.5)), evaluate(slowmap, make_drive(3))
    assert half.figures.n == 20
    assert len(half.run.frames) == 40
    assert half.figures.max_m == whole.map.errors[:20].max()


@pytest.mark.parametrize("readout", [{"kind": "gaussian-process"}, {"kind": "polynomial", "inputs": 4}])
def test_a_map_that_cannot_tell_foreign_places_is_never_sure(slowmap, make_drive, readout):
    regression = build_map([make_drive(1), make_drive(2)], slowmap.config.with_values({"readout": readout}))
    run = evaluate(regression, make_drive(3)).run
    assert {frame.estimate.status for frame in run.frames} == {Status.DEGRADED}
    assert "has not learnt what places look like that are not in it" in run.frames[0].estimate.reason
    assert Status.OK in {frame.estimate.status for frame in evaluate(slowmap, make_drive(3)).run.frames}


def test_a_blank_picture_is_lost_and_has_no_error(slowmap, make_drive):
    figures = evaluate(slowmap, make_drive(3, blank=(4, 9))).figures
    assert (figures.n, figures.n_errors, figures.unlocalized) == (40, 38, 2)
    assert figures.statuses[Status.LOST] >= 2


def test_baselines_stand_beside_the_map_with_the_same_keys(slowmap, make_drive):
    evaluation = evaluate(slowmap, make_drive(3, blank=(4,)), baselines=True, training=[make_drive(2), make_drive(1)])
    values = evaluation.as_dict()
    assert list(values["baselines"]) == BASELINES
    assert values.keys() >= DESIGN_KEYS
    for name, figures in values["baselines"].items():
        assert figures.keys() >= DESIGN_KEYS
        assert figures["n_errors"] == values["n_errors"] == 39
        assert figures["coverage_90"] is None
        assert name == "ridge regression" or figures["median_m"] < 1
    assert values["verdict"] == evaluation.verdict
    assert "map" in evaluation.verdict
    assert json.loads(json.dumps(values, allow_nan=False)) == values


def test_the_nearest_neighbour_of_a_training_frame_is_itself(slowmap, make_drive):
    training = [make_drive(1), make_drive(2)]
    evaluation = evaluate(slowmap, make_drive(2), baselines=True, training=training, training_error=True)
    assert evaluation.baselines["nearest-1"].max_m < 1e-9


def test_places_have_their_own_figures(place_map, make_drive):
    drives = [make_drive(1, places=True), make_drive(2, places=True)]
    values = evaluate(place_map, make_drive(3, places=True), baselines=True, training=drives).as_dict()
    for figures in (values, *values["baselines"].values()):
        assert all(figures[key] is None for key in figures if key.endswith("_m") or key.startswith("share_over"))
        assert set(figures["places"]) == {
            "median", "mean", "p95", "max", "share_within_1", "share_within_3", "share_within_10"
        }  # fmt: skip
    assert values["unit"] == "place"
    assert values["places"]["share_within_3"] > 0.8


def test_a_map_from_odometry_says_how_it_was_laid_over_the_truth(make_drive, slowmap):
    poses = [info.reference for info in make_drive(1).infos]
    config = slowmap.config.with_values({"positions": "odometry"})
    odometric = build_map([make_drive(1, odometry=poses)], config)
    evaluation = evaluate(odometric, make_drive(3))
    assert "fitted on these estimates themselves" in evaluation.notes[0]
    assert evaluation.figures.median_m < 0.3


def test_figures_follow_from_the_run(slowmap, make_drive):
    evaluation = evaluate(slowmap, make_drive(3))
    assert figures_of_run(evaluation.run, "m") == evaluation.figures
    assert figures_of(evaluation.map.errors).mean_m == evaluation.figures.mean_m


def test_another_drive_on_a_real_path(shared_data):
    slowmap = build_map([open_recording(shared_data / "sussex_train")])
    evaluation = evaluate(slowmap, open_recording(shared_data / "sussex_binary"), baselines=True)
    assert evaluation.figures.n == 96
    assert evaluation.figures.median_m < 0.35
    assert evaluation.figures.share_over_3m == 0
    assert evaluation.baselines["nearest-1"].median_m < 0.35
