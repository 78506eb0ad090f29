import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.errors import RecordingError
from andante.evaluation.experiments.gaze_rivals import Covered, LandmarkRival, truly_followed
from andante.evaluation.experiments.landmark_world import Seen
from andante.evaluation.experiments.trials import Bench
from andante.landmarks.boxes import Box
from andante.mapping.gaze import build_gaze_map
from andante.mapping.gaze_config import GazeConfig
from andante.mapping.gaze_lesson import read_drive

PICTURE = np.zeros((2, 2), np.uint8)


@given(
    start=st.floats(-7, 7),
    share=st.floats(0, 1),
    azimuth=st.floats(-3.1, 3.1),
    width=st.floats(0.02, 1.5),
)
def test_what_is_visible_of_a_box_is_its_longest_piece_outside(start, share, azimuth, width):
    box = Box(azimuth, 0.2, width, 0.3)
    at = box.right_rad + width * (np.arange(2000) + 0.5) / 2000
    free = np.mod(at - start, 2 * np.pi) >= 2 * np.pi * share
    edges = np.diff(np.concatenate([[0], free.astype(int), [0]]))
    pieces = list(zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True))
    low, high = max(pieces, key=lambda piece: piece[1] - piece[0], default=(0, 0))
    seen = Covered(PICTURE, start, share).visible(box)
    if abs((high - low) / 2000 - 0.5) < 0.002 or share < 1e-3:
        return  # half of it, more or less, or finer than it is looked at here
    assert (seen is None) == ((high - low) / 2000 < 0.5)
    if seen is not None:
        assert seen.width_rad == pytest.approx(width * (high - low) / 2000, abs=width / 900)
        middle = box.right_rad + width * (low + high) / 4000
        assert abs(np.angle(np.exp(1j * (seen.azimuth_rad - middle)))) < width / 900
        assert (seen.low_rad, seen.high_rad) == pytest.approx((box.low_rad, box.high_rad))


def test_nothing_hidden_leaves_a_box_as_it_is():
    assert Covered(PICTURE).visible(Box(3.1, 0.2, 0.4, 0.3)).width_rad == pytest.approx(0.4)


def test_the_simulator_knows_distances_that_the_sweep_estimates(pictures, years):
    name, bench = years.sessions[0].name, Bench(years, pictures)
    config = GazeConfig(regions=24)
    gaze = build_gaze_map([bench.recording(name)], config)
    drive = read_drive(bench.recording(name), gaze.front_end, gaze.readout.encoder, config)
    truly = truly_followed(bench, name, drive)
    assert truly.distance_m.shape == drive.distance_m.shape
    both = np.isfinite(truly.distance_m) & np.isfinite(drive.distance_m)
    assert both.mean() > 0.3
    assert 0.7 < np.median(drive.distance_m[both] / truly.distance_m[both]) < 1.4
    again = truly_followed(bench, name, drive)
    np.testing.assert_array_equal(again.distance_m, truly.distance_m)
    with pytest.raises(RecordingError, match=r"has 70 frames, got 69"):
        truly_followed(bench, name, drive.subset(np.arange(69)))


def test_boxes_are_wrong_in_another_way_in_every_session(pictures, years, monkeypatch):
    draws, bench, names = [], Bench(years, pictures), [session.name for session in years.sessions[:3]]
    detections = Seen.detections

    def drawn(self, chosen, seed):
        draws.append(seed)
        return detections(self, chosen, seed)

    monkeypatch.setattr(Seen, "detections", drawn)
    rival = LandmarkRival.learn(bench, names[:2], 5)
    rival.answers(bench, names[2], [Covered(frame.image) for frame in bench.recording(names[2]).frames()])
    assert len(draws) == len(set(draws)) == 3


def test_landmarks_are_lost_where_all_is_hidden(pictures, years):
    bench, first, second = Bench(years, pictures), *(session.name for session in years.sessions[:2])
    rival = LandmarkRival.learn(bench, [first], 5)
    frames = [frame.image for frame in bench.recording(second).frames()]
    seen = rival.answers(bench, second, [Covered(image) for image in frames])
    assert np.mean([one.status.has_pose for one in seen]) > 0.9
    hidden = rival.answers(bench, second, [Covered(image, 0.0, 1.0) for image in frames])
    assert not any(one.status.has_pose for one in hidden)
