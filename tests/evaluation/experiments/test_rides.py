import numpy as np
import pytest

from andante.data import Estimate, Pose2D, Status, Trajectory
from andante.errors import RecordingError
from andante.evaluation.experiments.rides import Ride, around, composed, covered, followed, overexposed


def test_steps_do_not_depend_on_the_frame_of_odometry(lap):
    truth = lap.with_odometry([info.reference for info in lap.infos])
    np.testing.assert_allclose(lap.steps(), truth.steps(), atol=1e-12)
    # On a circle all steps are the same, the one that closes it too.
    np.testing.assert_allclose(lap.steps(), np.tile(lap.steps()[0], (40, 1)), atol=1e-12)


def test_composed_steps_are_the_odometry_again(lap):
    again = lap.with_odometry(composed(lap.steps(), lap.infos[0].odometry))
    before, after = (Trajectory.of(one.infos, "odometry") for one in (lap, again))
    np.testing.assert_allclose(after.xy_m, before.xy_m, atol=1e-9)
    np.testing.assert_allclose(np.exp(1j * after.heading_rad), np.exp(1j * before.heading_rad), atol=1e-9)


@pytest.mark.parametrize(("start", "frames"), [(0, 40), (33, 90), (39, 1)])
def test_around_goes_on_lap_after_lap(lap, start, frames):
    ride = around(lap, start, frames)
    order = (start + np.arange(frames)) % 40
    assert [info.reference for info in ride.infos] == [lap.infos[at].reference for at in order]
    assert [one.estimate.x_m for one in ride.evidence] == order.tolist()
    assert [info.index for info in ride.infos] == list(range(frames))
    assert ride.infos[0].odometry == Pose2D(0.0, 0.0, 0.0)
    np.testing.assert_allclose(np.diff([info.timestamp_s for info in ride.infos]), 0.2)
    # Odometry and truth differ by one rotation and translation only.
    believed, truth = (Trajectory.of(ride.infos, source).xy_m for source in ("odometry", "reference"))
    apart = [np.linalg.norm(one[:, None] - one, axis=2) for one in (believed, truth)]
    np.testing.assert_allclose(*apart, atol=1e-9)


def test_a_ride_needs_evidence_for_every_frame(lap):
    with pytest.raises(RecordingError, match="3 frames has evidence of 2"):
        Ride(lap.infos[:3], lap.evidence[:2])


def test_followed_is_told_in_order(lap):
    class Tracker:
        def fuse(self, evidence, info):
            return Estimate(Status.OK, f"{info.index} {evidence is None}")

    ride = Ride(lap.infos[:2], (None, lap.evidence[1]))
    assert [one.reason for one in followed(Tracker(), ride)] == ["0 True", "1 False"]


def test_what_is_before_a_lens():
    image = np.tile(np.arange(256, dtype=np.uint8), (8, 1))
    burnt = overexposed(image)
    assert (burnt[:, 60:] == 255).all()
    assert burnt[0, 0] == 0
    assert len(np.unique(burnt)) > 4
    assert not covered(image).any()
    assert overexposed(covered(image)).max() == 0
