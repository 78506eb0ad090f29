import dataclasses
import subprocess
import sys

import numpy as np
import pytest

from andante.baselines.method import Method, StagedLocalizer
from andante.baselines.posenet import PoseNet, Schedule, method
from andante.data import CameraSpec, Pose2D, Status
from andante.errors import ConfigError, LearningError, MissingExtraError, RecordingError
from andante.recordings import MemoryRecording

torch = pytest.importorskip("torch", reason="the extra torch is not installed")

QUICK = Schedule(steps=80, batch_size=12, validate_every=40, threads=1)
TINY = PoseNet(width_px=128, height_px=12, channels=8, schedule=QUICK)


@pytest.fixture(scope="module")
def learned(garden):
    return TINY.learn(garden.two_days())


def test_it_learns_roughly_where_it_is_and_which_way_it_looks(garden, learned):
    drive = garden.two_days()[0]
    estimates = [learned.localizer.localize(drive.load(info)) for info in drive.infos]
    truth = [info.reference for info in drive.infos]
    off = [np.hypot(e.x_m - t.x_m, e.y_m - t.y_m) for e, t in zip(estimates, truth, strict=True)]
    turn = [np.cos(e.heading_rad - t.heading_rad) for e, t in zip(estimates, truth, strict=True)]
    # Guessing the middle of the loop is off by 3.3 m, and by any turn; it is given a few seconds.
    assert np.median(off) < 3.0
    assert np.median(turn) > 0.7
    assert {e.status for e in estimates} == {Status.OK}
    assert estimates[0].hypotheses[0].x_m == estimates[0].x_m


def test_two_steps_are_one(garden, learned):
    localizer, image = learned.localizer, garden.panorama((1, 2, 0.3))
    assert isinstance(TINY, Method)
    assert isinstance(localizer, StagedLocalizer)
    assert localizer.name == TINY.name == "posenet"
    assert localizer.localize(image) == localizer.locate(localizer.prepare(image))
    assert localizer.prepare(image).shape == (12, 112)  # 120 px, rounded down to whole columns of the network


def test_a_covered_lens_is_lost(learned):
    estimate = learned.localizer.localize(np.zeros((12, 120), np.uint8))
    assert estimate.status == Status.LOST
    assert "shows nothing" in estimate.reason


def test_what_it_cost_is_told(learned):
    count = sum(weights.numel() for weights in learned.localizer.network.parameters())
    assert learned.bytes == 4 * count
    assert learned.preprocessing_s > 0
    assert learned.mapping_s > 0
    assert learned.notes[0] == f"{count} parameters, from chance"
    assert learned.notes[1] == "90 frames learnt, 80 steps or 11 epochs: all of them"
    assert learned.notes[2].startswith("median error on 30 frames held out (every 4th): ")


def test_the_same_again_is_the_same(garden):
    brief = dataclasses.replace(TINY, schedule=dataclasses.replace(QUICK, steps=3, validate_every=1))
    image = garden.panorama((1, 2, 0.3))
    first, again = (brief.learn(garden.two_days()).localizer.localize(image) for _ in range(2))
    assert first == again


def test_a_picture_that_does_not_go_around_and_unknown_headings_will_do(garden):
    poses = garden.loop(12)
    pictures = [garden.panorama(pose) for pose in poses]
    reference = [Pose2D(x, y) for x, y, _ in poses.tolist()]
    drive = MemoryRecording(pictures, range(12), CameraSpec(model="perspective"), reference=reference)
    brief = dataclasses.replace(TINY, schedule=dataclasses.replace(QUICK, steps=3, validate_every=1))
    estimate = brief.learn([drive]).localizer.localize(pictures[0])
    assert estimate.status == Status.OK
    assert estimate.heading_rad is None


def test_what_teaches_nothing_is_refused(garden):
    with pytest.raises(ConfigError, match=r"channels of posenet must be a multiple of 8, got 12"):
        PoseNet(channels=12)
    with pytest.raises(RecordingError, match=r"posenet needs at least one recording"):
        TINY.learn([])
    with pytest.raises(LearningError, match=r"posenet needs at least 8 frames, got 7; every 4th is held out"):
        TINY.learn([garden.drive(garden.loop(7))])
    hurried = dataclasses.replace(TINY, schedule=dataclasses.replace(QUICK, max_seconds=1e-9))
    with pytest.raises(LearningError, match=r"no finite position after 0 steps; lower the learning rate"):
        hurried.learn([garden.drive(garden.loop(12))])


def test_places_that_are_all_one_teach_nothing():
    with pytest.raises(LearningError, match=r"all 9 frames have the same position"):
        method._unit_of(np.ones((9, 2)))


def test_without_torch_the_extra_is_named(garden, monkeypatch):
    monkeypatch.setitem(sys.modules, "torch", None)
    with pytest.raises(
        MissingExtraError, match=r"torch is not installed; install it with: pip install 'andante\[torch\]'"
    ):
        TINY.learn([garden.drive(garden.loop(12))])


def test_torch_is_not_imported_before_it_is_needed():
    code = "import sys, andante.baselines, andante.baselines.posenet; sys.exit('torch' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code], check=False).returncode == 0
