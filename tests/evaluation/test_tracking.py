from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from andante.data import Estimate, Status
from andante.errors import ImageError, RecordingError
from andante.evaluation import Skipped, run_tracker
from andante.localization import Evidence, make_tracker


class Counter:
    """Sees how bright a picture is and tells how many frames it was given; cannot read some brightnesses."""

    name = "counter"

    def __init__(self, refused=()):
        self.refused, self.told, self.threads = refused, [], set()

    def see(self, image):
        self.threads.update(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")
        if image[0, 0] in self.refused:
            raise ImageError("no such brightness")
        return Evidence(Estimate(Status.OK, "", float(image[0, 0]), 0.0))

    def fuse(self, evidence, info, fix=None):
        self.told.append((info.index, evidence is None))
        return Estimate(Status.OK, "", float(len(self.told)), 0.0)


@pytest.fixture
def greys(make_drive):
    drive = make_drive(0)
    drive._images = tuple(np.full((12, 64), index, np.uint8) for index in range(40))
    return drive


def test_every_frame_is_fused_in_order_with_what_was_seen_of_it(greys):
    tracker = Counter()
    run = run_tracker(tracker, greys)
    assert tracker.told == [(index, False) for index in range(40)]
    assert [frame.info for frame in run.track.frames] == list(greys.infos)
    assert [frame.estimate.x_m for frame in run.track.frames] == list(range(1, 41))
    assert [frame.estimate.x_m for frame in run.single.frames] == list(range(40))
    assert len(run.filter_s) == 40
    assert all(spent > 0 for spent in run.filter_s)
    assert run.track.wall_s == run.single.wall_s > sum(run.filter_s)
    assert tracker.threads <= {1}


def test_a_picture_that_cannot_be_read_is_a_frame_without_evidence(greys):
    tracker, seen = Counter(refused=(3,)), []
    run = run_tracker(tracker, greys, progress=lambda *step: seen.append(step))
    assert tracker.told == [(index, index == 3) for index in range(40)]
    assert len(run.track.frames) == 40
    assert len(run.single.frames) == 39
    assert run.track.skipped == (Skipped("image 3", "no such brightness"),)
    assert seen[-1] == ("drive 0", 40, 40)


def test_too_many_of_them_are_an_error(greys):
    with pytest.raises(RecordingError, match="at most 5%"):
        run_tracker(Counter(refused=(1, 2, 3)), greys)


@pytest.mark.parametrize("kind", ["particles", "kalman"])
def test_it_is_update_frame_by_frame(slowmap, make_ride, kind):
    ride = make_ride(3, blank=(5,))
    run = run_tracker(make_tracker(slowmap, kind, seed=4), ride)
    tracker = make_tracker(slowmap, kind, seed=4)
    for mine, frame in zip(run.track.frames, ride.frames(), strict=True):
        # Arrays have no single truth value; everything else is compared exactly.
        assert replace(mine.estimate, covariance=None) == replace(tracker.update(frame), covariance=None)


@pytest.mark.parametrize("lag", [1, 7, 500])
def test_smoothing_keeps_frames_and_their_order(slowmap, make_ride, lag):
    ride = make_ride(3)
    run = run_tracker(make_tracker(slowmap), ride, lag=lag)
    assert [frame.info for frame in run.track.frames] == list(ride.infos)
