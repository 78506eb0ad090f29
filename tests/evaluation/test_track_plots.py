import numpy as np
import pytest

from andante.data import Estimate, Status
from andante.evaluation import Run
from andante.evaluation.comparison import Scored
from andante.evaluation.figures import figures_of_run
from andante.evaluation.status_plots import calibration, timeline
from andante.evaluation.track_plots import ellipse_axes, way


def with_covariance(matrix, radius_m=None):
    covariance = np.full((3, 3), np.nan)
    covariance[:2, :2] = matrix
    return Estimate(Status.OK, "", 0.0, 0.0, covariance=covariance, radius_m=radius_m)


def test_a_round_covariance_is_a_circle_of_the_radius():
    assert ellipse_axes(with_covariance(0.3 * np.eye(2), 0.7))[:2] == pytest.approx((0.7, 0.7))


def test_without_a_radius_it_holds_nine_tenths_of_a_gaussian():
    matrix = np.array([[0.5, 0.2], [0.2, 0.3]])
    long, short, angle = ellipse_axes(with_covariance(matrix))
    drawn = np.random.default_rng(0).multivariate_normal([0, 0], matrix, 20000)
    cos, sin = np.cos(angle), np.sin(angle)
    along, across = drawn @ [cos, sin], drawn @ [-sin, cos]
    assert ((along / long) ** 2 + (across / short) ** 2 <= 1).mean() == pytest.approx(0.9, abs=0.01)
    assert long > short


@pytest.mark.parametrize("matrix", [np.full((2, 2), np.nan), np.zeros((2, 2))])
def test_nothing_to_draw(matrix):
    assert ellipse_axes(with_covariance(matrix)) is None
    assert ellipse_axes(Estimate(Status.OK, "", 0.0, 0.0)) is None


def test_a_track_without_any_pose_has_no_way(make_drive):
    from andante.evaluation import LocalizedFrame

    run = Run(tuple(LocalizedFrame(info, Estimate(Status.LOST, ""), 0.0) for info in make_drive(0).infos))
    scored = Scored("lost", run, np.full(40, np.nan), figures_of_run(run, "m"))
    assert way(scored, np.empty((0, 2))) is None
    assert calibration(scored) is None
    assert "<svg" in timeline(scored, "m")
