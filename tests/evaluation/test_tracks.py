import json
from dataclasses import replace

import pytest

import andante as an
from andante.errors import InputError, LeakageError, MapError
from andante.evaluation import evaluate, track


def plain(done):
    """What a track says, without what depends on the clock."""
    return [
        (
            frame.info.timestamp_s,
            str(frame.estimate.status),
            frame.estimate.x_m,
            frame.estimate.y_m,
            frame.estimate.heading_rad,
        )
        for frame in done.run.frames
    ]


def test_it_is_public():
    assert an.track is track


@pytest.mark.parametrize("kind", ["particles", "kalman"])
@pytest.mark.parametrize("smooth", [False, True])
def test_a_ride_is_followed(slowmap, make_ride, kind, smooth):
    done = track(slowmap, make_ride(3), kind=kind, smooth=smooth)
    figures = done.figures
    assert (figures.n, len(done.run.frames)) == (80, 80)
    assert figures.mean_m < 1.0
    assert figures.heading_median_deg < 20
    assert figures.heading_median_deg <= figures.heading_p95_deg <= figures.heading_max_deg
    assert figures.recovery_frames is not None
    assert figures.recovery_frames <= figures.recovery_worst_frames
    assert figures.confident_wrong_share == pytest.approx(0.0, abs=0.1)
    assert figures.ms_filter > 0
    values = done.as_dict()
    assert json.loads(json.dumps(values, allow_nan=False)) == values
    assert (values["filter"], values["smoothed"], values["seed"]) == (kind, smooth, 0)


def test_single_images_are_those_of_an_evaluation(slowmap, make_ride):
    ride = make_ride(3, blank=(5,))
    mine, other = track(slowmap, ride).single.figures, evaluate(slowmap, ride).figures
    for key in ("n", "n_errors", "unlocalized", "mean_m", "max_m", "lost_share", "coverage_90", "statuses"):
        assert getattr(mine, key) == getattr(other, key)


def test_a_seed_decides_everything(slowmap, make_ride):
    assert plain(track(slowmap, make_ride(3), seed=5)) == plain(track(slowmap, make_ride(3), seed=5))


def test_without_truth_there_are_no_figures(slowmap, make_ride):
    done = track(slowmap, make_ride(3, truth=False))
    assert (done.figures.n, done.figures.mean_m, done.figures.recovery_frames, done.figures.outages) == (
        0,
        None,
        None,
        0,
    )
    assert done.notes == ()
    assert json.loads(json.dumps(done.as_dict(), allow_nan=False))["single"]["mean_m"] is None


def test_without_odometry_images_are_alone_and_it_is_said(slowmap, make_ride):
    done = track(slowmap, make_ride(3, odometry=False))
    assert done.notes == (
        "recording 'drive 3' has no odometry (odom_x_m, odom_y_m in frames.csv): tracked by images alone",
    )
    assert done.figures.mean_m < 1.0


def test_some_odometry_is_missing(slowmap, make_ride):
    ride = make_ride(3)
    ride.infos = (replace(ride.infos[0], odometry=None), *ride.infos[1:])
    assert "1 of 80 frames of recording 'drive 3' have no odometry" in track(slowmap, ride).notes[0]


def test_training_recordings_are_refused_unless_asked_for(slowmap, make_drive):
    with pytest.raises(LeakageError, match=r"learnt from recording 'drive 1'.*--training-error"):
        track(slowmap, make_drive(1))
    assert "training error" in track(slowmap, make_drive(1), training_error=True).notes[0]


def test_places_have_no_metres(place_map, make_drive):
    with pytest.raises(InputError, match="numbered places"):
        track(place_map, make_drive(3, places=True))


@pytest.mark.parametrize("kind", ["particles", "kalman"])
def test_a_state_goes_on_where_it_was(slowmap, make_ride, tmp_path, kind):
    whole, state = make_ride(3), tmp_path / "robot.state"
    first, second = make_ride(3), make_ride(3)
    first._images, first.infos = whole._images[:50], whole.infos[:50]
    second._images = whole._images[50:]
    second.infos = tuple(replace(info, index=info.index - 50) for info in whole.infos[50:])
    halves = [track(slowmap, part, kind=kind, state=state) for part in (first, second)]
    assert plain(halves[0]) + plain(halves[1]) == plain(track(slowmap, whole, kind=kind))


def test_a_damaged_state(slowmap, make_ride, tmp_path):
    (tmp_path / "robot.state").write_bytes(b"nothing of the kind")
    with pytest.raises(MapError, match=r"robot\.state"):
        track(slowmap, make_ride(3), state=tmp_path / "robot.state")
