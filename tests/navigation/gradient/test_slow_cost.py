import numpy as np
import pytest

from andante.errors import ConfigError
from andante.navigation import SlowCost

GOAL = np.array([0.5, -1.0, 2.0])
DELTAS = np.array([0.01, 0.04, 0.09])
HERE = np.array([1.5, -3.0, 0.0])


def test_plain_is_euclidean_in_the_first_features():
    assert SlowCost.plain(GOAL).of(HERE) == pytest.approx(np.sqrt(1 + 4))
    assert SlowCost.plain(GOAL, 3).of(HERE) == pytest.approx(3.0)


@pytest.mark.parametrize(("power", "make"), [(1.0, SlowCost.commute), (2.0, SlowCost.biharmonic)])
def test_spectral_costs_count_features_by_their_slowness(power, make):
    cost = make(GOAL, DELTAS)
    np.testing.assert_allclose(cost.weight / cost.weight[0], (DELTAS / DELTAS[0]) ** -power)


def test_a_step_of_the_training_drive_costs_one():
    rng = np.random.default_rng(0)
    walk = rng.normal(size=(20_000, 3)) * np.sqrt(DELTAS)  # differences along edges have variance delta
    for cost in (SlowCost.commute(GOAL, DELTAS), SlowCost.biharmonic(GOAL, DELTAS)):
        squared = [cost.of(GOAL + step) ** 2 for step in walk[:4000]]
        assert np.mean(squared) == pytest.approx(1.0, abs=0.1)


def test_comparable_costs_are_alike_between_random_places():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 5000, 3))
    plain = np.mean([SlowCost.plain(goal).of(here) ** 2 for goal, here in zip(a, b, strict=True)])
    scaled = np.mean(
        [SlowCost.commute(goal, DELTAS).comparable().of(here) ** 2 for goal, here in zip(a, b, strict=True)]
    )
    assert scaled == pytest.approx(plain, rel=0.1)


def test_the_offset_is_as_long_as_the_cost():
    cost = SlowCost.commute(GOAL, DELTAS)
    assert np.linalg.norm(cost.scaled(HERE)) == pytest.approx(cost.of(HERE))


def test_weights_have_to_fit():
    with pytest.raises(ConfigError, match=r"one weight of 0 or more for each slow feature .* \(2,\) and \(3,\)"):
        SlowCost(GOAL, np.ones(2))
    with pytest.raises(ConfigError, match="one weight of 0 or more"):
        SlowCost(GOAL, np.array([1.0, -1.0, 1.0]))
