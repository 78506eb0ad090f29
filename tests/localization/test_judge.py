"""Statuses, their hysteresis and their reasons."""

from dataclasses import replace

import pytest

from andante.data import Status
from andante.localization import judge as room
from andante.localization.config import JudgeConfig
from andante.localization.judge import Belief, Judge
from andante.localization.motion import Step

CONFIG = JudgeConfig()
SHARP = Belief(radius_m=0.1, core_radius_m=0.1, share=1.0, moved_m=0.0)
AGREES = room.Testimony("agrees", Status.OK, "", sure=True)
AGAINST = room.Testimony("contradicts", Status.OK, "the image is from 5.0 m away from where odometry leads", sure=True)
SILENT = room.Testimony("silent", None, "there is no picture")


class Court:
    def __init__(self):
        self.judge = Judge()

    def hear(self, testimony, belief=SHARP, way_m=0.14):
        self.judge = self.judge.moved(Step(way_m, duration_s=0.2), 0.1).heard(testimony, belief, CONFIG)
        return self.judge.status(belief, testimony, CONFIG)

    def trusting(self):
        for _ in range(10):
            assert self.hear(AGREES)[0].has_pose
        return self


def test_ok_takes_several_images_along_the_way():
    court = Court()
    statuses = [court.hear(AGREES) for _ in range(5)]
    assert [status for status, _ in statuses] == [Status.DEGRADED] * 3 + [Status.OK] * 2
    assert statuses[1][1] == "2 of 4 images along the way agree with odometry so far"


def test_at_rest_no_points_are_earned_and_none_are_lost():
    court = Court()
    for _ in range(50):
        assert court.hear(AGREES, way_m=0.0)[0] == Status.DEGRADED
    court.trusting()
    for _ in range(50):
        assert court.hear(AGREES, way_m=0.0)[0] == Status.OK


def test_one_contradiction_ends_ok_at_once_and_agreement_brings_it_back():
    court = Court().trusting()
    status, reason = court.hear(AGAINST)
    assert status == Status.DEGRADED
    assert "5.0 m away" in reason
    assert court.hear(AGREES)[0] == Status.OK


def test_many_contradictions_lose_the_pose():
    court = Court().trusting()
    statuses = [court.hear(AGAINST) for _ in range(5)]
    assert [status for status, _ in statuses] == [Status.DEGRADED] * 4 + [Status.LOST]
    assert "the last 5 images contradict odometry" in statuses[4][1]
    at_rest = Court().trusting()
    assert [at_rest.hear(AGAINST, way_m=0.0)[0].has_pose for _ in range(7)] == [True] * 5 + [False] * 2


def test_silence_ends_ok_after_a_while_and_a_wide_belief_loses_the_pose():
    court = Court().trusting()
    statuses = [court.hear(SILENT)[0] for _ in range(8)]
    assert statuses[3] == Status.OK
    assert statuses[-1] == Status.DEGRADED
    status, reason = court.hear(SILENT, replace(SHARP, radius_m=4.0, core_radius_m=4.0))
    assert status == Status.LOST
    assert reason.startswith("somewhere within 4.0 m: no image that is sure confirmed it for 1.3 m")
    # Images whose own radius is wide are no reason to be lost.
    wide = Belief(4.0, 4.0, 1.0, 0.0, image_radius_m=4.0)
    assert court.hear(AGREES, wide)[0] == Status.DEGRADED


def test_going_over_to_another_place_begins_anew():
    court = Court().trusting()
    assert court.hear(AGREES, replace(SHARP, moved_m=5.0))[0] == Status.DEGRADED
    assert court.hear(AGREES)[0] == Status.DEGRADED


def test_rivals_with_hysteresis():
    court = Court().trusting()
    assert court.hear(AGREES, replace(SHARP, share=0.9))[0] == Status.OK
    status, reason = court.hear(AGREES, replace(SHARP, share=0.6, rivals="40% for (5.0, 1.0)"))
    assert status == Status.DEGRADED
    assert reason == "it may be elsewhere: 40% for (5.0, 1.0)"
    assert court.hear(AGREES, replace(SHARP, share=0.9))[0] == Status.DEGRADED
    assert court.hear(AGREES, replace(SHARP, share=0.95))[0] == Status.OK


def test_a_radius_too_large_with_hysteresis():
    court = Court().trusting()
    assert court.hear(AGREES, replace(SHARP, radius_m=0.9))[0] == Status.OK
    assert court.hear(AGREES, replace(SHARP, radius_m=1.0)) == (Status.DEGRADED, "within 1.0 m, ok is 0.8 m")
    assert court.hear(AGREES, replace(SHARP, radius_m=0.9))[0] == Status.DEGRADED
    assert court.hear(AGREES, replace(SHARP, radius_m=0.7))[0] == Status.OK


def test_off_the_map():
    off = room.Testimony("silent", Status.OFF_MAP, "no mapped place looks like this")
    court = Court().trusting()
    status, reason = court.hear(off)
    assert status == Status.DEGRADED
    assert "no mapped place" in reason
    fresh = Court()
    assert [fresh.hear(off, None)[0] for _ in range(4)] == [Status.LOST, Status.LOST, Status.OFF_MAP, Status.OFF_MAP]


@pytest.mark.parametrize("note", ["odometry jumped 9.0 m"])
def test_notes_are_told(note):
    assert note in Court().trusting().hear(replace(AGREES, notes=(note,)))[1]
    assert note in Court().hear(replace(SILENT, notes=(note,)), None)[1]
