"""Slow features move slowly, and what does not is a fault."""

from itertools import pairwise

import numpy as np
import pytest

from andante.localization.config import FaultConfig
from andante.localization.faults import Pulse, listen
from andante.localization.motion import Step

CONFIG = FaultConfig()


class Ear:
    """Listens to one image after the other."""

    def __init__(self):
        self.pulse, self.good, self.last = Pulse(), None, None

    def hear(self, slow, way_m=0.14, *, known=True):
        heard = listen(self.pulse.moved(Step(way_m, known=known)), slow, self.good, self.last, CONFIG)
        self.pulse, self.good, self.last = heard.pulse, slow if heard.good else self.good, slow
        return heard


@pytest.fixture
def images(world):
    return [one.slow for one in world.images(world.loop(400))]


def test_what_moves_slowly_is_no_fault(images):
    ear = Ear()
    assert sum(bool(ear.hear(slow).fault) for slow in images) <= 4


def test_one_jump_is_a_fault_and_the_next_image_is_good_again(images):
    ear = Ear()
    for slow in images[:60]:
        ear.hear(slow)
    heard = ear.hear(images[250])
    assert "what the camera sees jumped" in heard.fault
    assert not heard.good
    assert not ear.hear(images[61]).fault


def test_jumps_that_agree_among_each_other_are_none_any_more(images):
    ear = Ear()
    for slow in images[:60]:
        ear.hear(slow)
    heard = [ear.hear(slow) for slow in images[250:256]]
    assert [bool(one.fault) for one in heard] == [True, True, False, False, False, False]
    assert heard[2].carried


def test_jumps_here_and_there_are_faults_for_as_long_as_the_way_is_short(images):
    ear = Ear()
    for slow in images[:60]:
        ear.hear(slow)
    assert all(ear.hear(images[n], 0.02).fault for n in (100, 160, 220, 280, 340))


def test_after_a_long_or_unknown_way_nothing_is_impossible(images):
    ear = Ear()
    for slow in images[:60]:
        ear.hear(slow)
    assert not ear.hear(images[250], way_m=5.0).fault
    ear.hear(images[251])
    assert not ear.hear(images[60], known=False).fault


def test_a_picture_that_stands_still_while_the_robot_moves(images):
    ear = Ear()
    for slow in images[:60]:
        ear.hear(slow)
    assert "stands still" in ear.hear(images[59]).fault
    assert not ear.hear(images[59], way_m=0.0).fault


def test_a_foreign_length_begins_anew(images):
    ear = Ear()
    for slow in images[:60]:
        ear.hear(slow)
    assert not ear.hear(np.ones(7)).fault


def test_the_running_median_is_about_the_median(images):
    ear, steps = Ear(), []
    for before, slow in pairwise(images):
        steps.append(np.log(np.linalg.norm(slow - before) / 0.14 ** (2 / 3)))
        ear.hear(slow)
    assert ear.pulse.middle == pytest.approx(np.median(steps), abs=0.1)
