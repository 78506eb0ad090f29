import numpy as np
import pytest

from andante.data import Estimate, Status
from andante.evaluation.experiments.off_map import area_below, likenesses, roc
from andante.evaluation.experiments.strangers import (
    blinded,
    covered_lenses,
    dark_noise,
    finger,
    lens_cap,
    smooth_noise,
    white_noise,
)


def test_the_area_by_hand():
    assert area_below(np.array([2.0, 3.0]), np.array([0.0, 1.0])) == 1.0
    assert area_below(np.array([0.0, 1.0]), np.array([2.0, 3.0])) == 0.0
    assert area_below(np.array([1.0, 1.0]), np.array([1.0])) == 0.5
    assert area_below(np.array([1.0, 3.0]), np.array([0.0, 2.0])) == 0.75


def test_the_area_is_that_of_the_curve():
    rng = np.random.default_rng(1)
    mapped, strange = rng.normal(1, 1, 70).round(1), rng.normal(0, 1, 50).round(1)
    false, true = roc(mapped, strange)
    assert (false[0], true[0], false[-1], true[-1]) == (0, 0, 1, 1)
    assert (np.diff(false) >= 0).all()
    assert (np.diff(true) >= 0).all()
    assert area_below(mapped, strange) == pytest.approx(np.trapezoid(true, false))
    slow = np.mean([(m > s) + 0.5 * (m == s) for m in mapped for s in strange])
    assert area_below(mapped, strange) == pytest.approx(slow)


def test_likeness_or_else_the_rank_of_the_status():
    said = [Estimate(Status.OK, ""), Estimate(Status.OFF_MAP, ""), Estimate(Status.LOST, "")]
    assert likenesses(said).tolist() == [3, 0, 1]
    assert likenesses([*said, Estimate(Status.OK, "", likeness=0.7)]).tolist() == [0, 0, 0, 0.7]


@pytest.mark.parametrize("make", [dark_noise, lens_cap, white_noise, smooth_noise])
def test_strangers_are_pictures_and_their_seed_decides(make):
    first, second = (make(np.random.default_rng(4), 48) for _ in range(2))
    assert (first.shape, first.dtype) == ((48, 48), np.uint8)
    np.testing.assert_array_equal(first, second)
    assert (make(np.random.default_rng(5), 48) != first).any()


def test_a_hand_hides_nearly_everything():
    rng = np.random.default_rng(0)
    image = rng.integers(0, 256, (96, 96), dtype=np.uint8)
    seen = finger(rng, 96, image).astype(float)
    assert abs(np.corrcoef(seen.ravel(), image.ravel())[0, 1]) < 0.2


def test_blinded_pictures_are_burnt_out():
    rng = np.random.default_rng(0)
    images = [rng.integers(1, 256, (48, 48), dtype=np.uint8) for _ in range(5)]
    for image in blinded(rng, iter(images)):
        assert (image == 255).mean() >= 0.85


def test_lenses_are_covered_in_turn():
    images = [np.full((48, 48), 100, np.uint8)] * 4
    cap, glow, hand, again = covered_lenses(np.random.default_rng(0), iter(images))
    assert cap.mean() < 30
    assert again.mean() < 30
    assert glow.std() > cap.std()
    assert 20 < hand.mean() < 230
