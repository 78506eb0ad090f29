"""Laying a map's frame over the truth: rigid, stated, and on the map's own drives where it can."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.data import Estimate, FrameInfo, Pose2D, Status
from andante.evaluation.alignment import Alignment, alignment_of, fit_rigid
from andante.evaluation.running import LocalizedFrame, Run
from andante.mapping import Source


@given(st.floats(-3, 3), st.floats(-50, 50), st.floats(-50, 50), st.integers(0, 99))
def test_a_rigid_motion_is_found(turn, x, y, seed):
    mapped = np.random.default_rng(seed).normal(size=(20, 2)) * 5
    cos, sin = np.cos(turn), np.sin(turn)
    truth = mapped @ np.array([[cos, sin], [-sin, cos]]) + [x, y]
    found = fit_rigid(mapped, truth, "test")
    assert found.residual_m < 1e-9
    for one, other in zip(mapped, truth, strict=True):
        pose = found.into_map(Pose2D(float(other[0]), float(other[1]), turn))
        assert (pose.x_m, pose.y_m) == pytest.approx(tuple(one), abs=1e-8)
        assert pose.heading_rad == pytest.approx(0, abs=1e-8)


def test_scale_is_not_taken_away():
    mapped = np.array([[0.0, 0], [10, 0], [10, 10], [0, 10]])
    found = fit_rigid(mapped, 1.1 * mapped, "test")
    assert found.rotation_rad == pytest.approx(0)
    assert found.residual_m == pytest.approx(np.hypot(0.5, 0.5))


def run_of(estimates, references) -> Run:
    frames = []
    for index, (estimate, reference) in enumerate(zip(estimates, references, strict=True)):
        pose = None if reference is None else Pose2D(*reference)
        found = Estimate(Status.LOST, "") if estimate is None else Estimate(Status.OK, "", *estimate)
        frames.append(LocalizedFrame(FrameInfo(index, "", float(index), reference=pose), found, 0.0))
    return Run(tuple(frames))


class WithoutMemory:
    memory = None


def test_on_the_estimates_where_the_drives_are_not_at_hand():
    estimates = [(0.0, 0.0), (1.0, 0.0), (0.0, 2.0), None, (3.0, 3.0)]
    references = [(5.0, 0.0), (6.0, 0.0), (5.0, 2.0), (0.0, 0.0), None]
    run = run_of(estimates, references)
    found = alignment_of(WithoutMemory(), run)
    assert found.source == "these estimates themselves"
    assert found.translation_m == pytest.approx((5, 0))
    moved = found.truth_in_map(run)
    assert moved.frames[1].info.reference.x_m == pytest.approx(1)
    assert moved.frames[4].info.reference is None
    assert alignment_of(WithoutMemory(), run_of(estimates[:2], references[:2])) is None


def test_it_says_what_was_done():
    told = str(Alignment(np.pi / 2, (1.0, -2.0), 0.05, "the mapped drives"))
    assert "turn of 90.00 degrees and a shift of (1.000, -2.000) m without scale, fitted on the mapped drives" in told


class Session:
    """What a map remembers of a drive; its recording has been found again, or one in its place."""

    def __init__(self, content: str) -> None:
        self.xy = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 2.0]])
        self.number = np.arange(4)
        self.source = Source("monday", content, 4, "odometry", folder="monday")


class Found:
    def __init__(self, shift: float) -> None:
        xy = Session("").xy + shift
        self.infos = [FrameInfo(i, "", float(i), reference=Pose2D(float(x), float(y))) for i, (x, y) in enumerate(xy)]

    def content_hash(self) -> str:
        return "as mapped"


@pytest.mark.parametrize(("content", "source"), [("as mapped", "the mapped drives monday"), ("other", "estimates")])
def test_only_a_recording_that_is_as_it_was_mapped_tells_the_truth(monkeypatch, content, source):
    monkeypatch.setattr("andante.evaluation.alignment.open_recording", lambda folder: Found(5.0))
    slowmap = WithoutMemory()
    slowmap.memory = (Session(content),)
    found = alignment_of(slowmap, run_of([(0.0, 0.0), (1.0, 0.0), (0.0, 2.0)], [(1.0, 0.0), (2.0, 0.0), (1.0, 2.0)]))
    assert source in found.source
    assert found.translation_m == pytest.approx((5, 5) if content == "as mapped" else (1, 0))
