"""Images and fixes as mixtures, and how much of them is news."""

import math

import numpy as np
import pytest

from andante.data import Estimate, Fix, Hypothesis, Status
from andante.localization.config import JudgeConfig, SightingConfig
from andante.localization.filters import Gauss
from andante.localization.motion import Step
from andante.localization.sighting import sighting_of_fix, sighting_of_image
from andante.localization.witness import Novelty, opinion_of

CONFIG = SightingConfig()


def image(*hypotheses, status=Status.OK, radius_m=0.2146, heading=None, variance=None):
    covariance = np.full((3, 3), np.nan)
    covariance[2, 2] = np.nan if variance is None else variance
    first = hypotheses[0]
    if not status.has_pose:
        return Estimate(status, "", hypotheses=hypotheses)
    return Estimate(status, "", first.x_m, first.y_m, heading, covariance, radius_m, hypotheses=hypotheses)


def gauss(x=0.0, y=0.0, heading=0.0, position=0.05**2, turn=0.01):
    return Gauss(np.array([x, y, heading]), np.diag([position, position, turn]))


def test_the_likelihood_is_that_of_its_definition():
    rng = np.random.default_rng(0)
    sighting = sighting_of_image(
        image(Hypothesis(0, 0, 0.7, 1.0), Hypothesis(1, 2, 0.3, None), heading=1.0, variance=0.04), CONFIG
    )
    pose = rng.normal(size=(50, 3))
    likelihood = sighting.likelihood(pose, sharpness=0.5, floor=0.1)
    for (x, y, heading), value in zip(pose, likelihood, strict=True):
        total = 0.0
        for (px, py), weight, turn in zip(sighting.xy, sighting.weight, sighting.heading, strict=True):
            squared = ((x - px) ** 2 + (y - py) ** 2) / 0.1**2
            if math.isfinite(turn):
                squared += (2 - 2 * math.cos(heading - turn)) / 0.04
            total += weight * (0.97 * math.exp(-squared / 4) + 0.03 * math.exp(-squared / 64))
        assert value == pytest.approx(0.1 + 0.9 * min(total / 0.7, 1))


def test_floors_follow_the_status_and_faults_are_believed_little():
    floors = [sighting_of_image(image(Hypothesis(0, 0, 1.0), status=status), CONFIG).floor for status in Status]
    assert floors == sorted(floors)
    faulty = sighting_of_image(image(Hypothesis(0, 0, 1.0)), CONFIG, faulty=True)
    assert faulty.floor == CONFIG.floor_lost


def test_only_a_pose_is_trusted():
    assert sighting_of_image(image(Hypothesis(0, 0, 1.0)), CONFIG).trusted
    lost = sighting_of_image(image(Hypothesis(0, 0, 1.0), status=Status.LOST), CONFIG)
    assert not lost.trusted
    assert lost.sigma_m == CONFIG.blind_sigma_m
    assert opinion_of(lost, gauss(9.0), JudgeConfig())[0] == "silent"


def test_deviations_are_those_of_the_radius_within_bounds():
    def sigma(radius):
        return sighting_of_image(image(Hypothesis(0, 0, 1.0), radius_m=radius), CONFIG).sigma_m

    assert sigma(0.2146) == pytest.approx(0.1)
    assert sigma(0.001) == CONFIG.min_sigma_m
    assert sigma(9.0) == CONFIG.max_sigma_m


@pytest.mark.parametrize("hypotheses", [(), (Hypothesis(np.nan, 0, 1.0),), (Hypothesis(0, 0, 0.0),)])
def test_images_that_name_no_place(hypotheses):
    assert sighting_of_image(Estimate(Status.LOST, "", hypotheses=hypotheses), CONFIG) is None


@pytest.mark.parametrize(
    "fix", [None, Fix(np.nan, 0, 1), Fix(0, np.inf, 1), Fix(0, 0, 0), Fix(0, 0, -1), Fix(0, 0, np.nan)]
)
def test_fixes_that_are_none(fix):
    assert sighting_of_fix(fix) is None


def test_draws_are_from_the_mixture():
    sighting = sighting_of_image(image(Hypothesis(0, 0, 0.75), Hypothesis(5, 0, 0.25)), CONFIG)
    xy, heading = sighting.draw(20_000, np.random.default_rng(0))
    assert np.mean(xy[:, 0] > 2.5) == pytest.approx(0.25, abs=0.02)
    assert xy[xy[:, 0] < 2.5].std(axis=0) == pytest.approx([0.1, 0.1], rel=0.03)
    assert np.isnan(heading).all()


def weighted(news, predicted):
    return news.weighted(sighting_of_image(image(Hypothesis(0, 0, 1.0)), CONFIG), predicted, CONFIG, contradicts=False)


def test_many_images_along_a_way_count_as_few():
    def total(steps):
        news, out = Novelty(0.0, 0.0), 0.0
        for _ in range(steps):
            news = news.moved(Step(1.0 / steps), 0.0)
            one = weighted(news, gauss())
            out, news = out + one.sharpness * one.decision, Novelty(0.0, 0.0)
        return out

    assert total(1000) == pytest.approx(1.0 / CONFIG.correlation_m, rel=0.01)
    assert total(10) == pytest.approx(total(1000), rel=0.1)


def test_at_rest_an_image_is_news_only_where_the_prediction_is_wide():
    assert weighted(Novelty(0.0, 0.0), gauss()).decision == 0
    assert weighted(Novelty(0.0, 0.0), gauss(position=1.0)).decision == pytest.approx(0.99)
    first = weighted(Novelty(), None)
    assert (first.sharpness, first.decision) == (1, 1)


def test_a_heading_is_news_at_rest_where_none_is_known():
    sighting = sighting_of_image(image(Hypothesis(0, 0, 1.0), heading=1.0, variance=0.01), CONFIG)

    def decision(turn):
        news = Novelty(0.0, 0.0).weighted(sighting, gauss(turn=turn), CONFIG, contradicts=False)
        return news.decision

    assert decision(3.0) == pytest.approx(1.0, abs=0.01)
    assert decision(0.005) == 0


def test_the_wider_the_prediction_the_lower_the_floor():
    news = Novelty(0.1, 0.0)
    floors = [weighted(news, gauss(position=position)).floor for position in (0.001, 0.1, 1.0)]
    assert floors == sorted(floors, reverse=True)
    assert floors[0] <= CONFIG.floor_ok


def test_opinions():
    config = JudgeConfig()

    def opinion(sighting, predicted):
        return opinion_of(sighting_of_image(sighting, CONFIG), predicted, config)

    assert opinion(image(Hypothesis(0, 0, 1.0)), None)[0] == "agrees"
    assert opinion(image(Hypothesis(0.2, 0, 1.0)), gauss())[0] == "agrees"
    said, why = opinion(image(Hypothesis(3, 4, 1.0)), gauss())
    assert said == "contradicts"
    assert why == "the image is from 5.0 m away from where odometry leads"
    either = image(Hypothesis(3, 4, 0.6), Hypothesis(0, 0, 0.4))
    assert opinion(either, gauss())[0] == "silent"
    turned = image(Hypothesis(0, 0, 1.0), heading=2.0, variance=0.01)
    assert opinion(turned, gauss())[0] == "contradicts"
    assert opinion(turned, gauss(turn=3.0))[0] == "agrees"
    fix = sighting_of_fix(Fix(9, 0, 0.1))
    assert opinion_of(fix, gauss(), config)[1].startswith("the fix is from 9.0 m")
