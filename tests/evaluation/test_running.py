from dataclasses import replace

import numpy as np
import pytest
from threadpoolctl import threadpool_info

from andante.baselines import NearestNeighbours
from andante.data import Estimate, Status
from andante.errors import ImageError, RecordingError
from andante.evaluation import Skipped, run_localizer
from andante.evaluation.running import run_on_features


class Oracle:
    """Says how bright a picture is; cannot read a picture of the given brightness."""

    name = "oracle"

    def __init__(self, refused=()):
        self.refused = refused
        self.blas_threads = set()

    def localize(self, image):
        self.blas_threads.update(pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas")
        if image[0, 0] in self.refused:
            raise ImageError("no such brightness")
        return Estimate(Status.OK, "", float(image[0, 0]), 0.0)


@pytest.fixture
def greys(make_drive):
    drive = make_drive(0)
    drive._images = tuple(np.full((12, 64), index, np.uint8) for index in range(40))
    return drive


def test_all_frames_come_in_order_with_their_own_estimate(greys):
    oracle = Oracle()
    run = run_localizer(oracle, greys)
    assert [frame.info for frame in run.frames] == list(greys.infos)
    assert [frame.estimate.x_m for frame in run.frames] == list(range(40))
    assert all(frame.seconds > 0 for frame in run.frames)
    assert run.wall_s > 0
    assert oracle.blas_threads <= {1}


def test_a_picture_that_cannot_be_used_is_skipped_and_told(greys):
    seen = []
    run = run_localizer(Oracle(refused=(3,)), greys, progress=lambda *step: seen.append(step))
    assert run.skipped == (Skipped("image 3", "no such brightness"),)
    assert len(run.frames) == 39
    assert seen[-1] == ("drive 0", 40, 40)


def test_too_many_of_them_are_an_error(greys):
    with pytest.raises(RecordingError, match="at most 5%"):
        run_localizer(Oracle(refused=(1, 2, 3)), greys)


def test_shared_features_give_the_estimates_of_single_pictures(slowmap, make_drive):
    drive = make_drive(3, blank=(5,))
    features = np.random.default_rng(0).normal(size=(9, slowmap.front_end.dim)).astype(np.float32)
    nearest = NearestNeighbours.fit(slowmap.front_end, "m", features, np.arange(18.0).reshape(9, 2), 2)
    together = run_on_features([slowmap, nearest], slowmap.front_end, drive)
    for localizer, run in zip([slowmap, nearest], together, strict=True):
        alone = run_localizer(localizer, drive)
        assert [f.info for f in run.frames] == [f.info for f in alone.frames]
        for mine, other in zip(run.frames, alone.frames, strict=True):
            # Arrays have no single truth value; everything else is compared exactly.
            assert replace(mine.estimate, covariance=None) == replace(other.estimate, covariance=None)
        assert run.frames[5].estimate.status is Status.LOST
        assert "shows nothing" in run.frames[5].estimate.reason


def test_time_counts_the_shared_pass_for_everyone(slowmap, make_drive):
    first, second = run_on_features([slowmap, slowmap], slowmap.front_end, make_drive(3))
    encoding = min(sum(frame.seconds for frame in run.frames) for run in (first, second))
    assert min(first.wall_s, second.wall_s) > 0.2 * encoding
