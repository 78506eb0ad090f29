import pytest

from andante.evaluation.experiments.plans import STATIC
from andante.evaluation.experiments.single import random_split, run_dynamic_object, run_slow_light, run_static
from andante.evaluation.experiments.trials import Bench

NAMES = ["andante", "thesis choices (Fourier)", "nearest-1", "nearest-5"]


def test_the_split_is_random_complete_and_the_same_again():
    kept, rest = random_split(23, 279)
    assert (len(kept), len(rest)) == (195, 84)
    assert sorted(kept + rest) == list(range(279))
    assert list(kept) == sorted(kept)
    assert (kept, rest) == random_split(23, 279)
    assert kept != random_split(24, 279)[0]


@pytest.fixture
def bench(cache, singles):
    return Bench(singles, cache)


def test_static(bench, tiny):
    outcome = run_static(bench, 5, tiny)
    seen, honest = outcome.figures["cases"]
    assert list(seen["localizers"]) == [NAMES[1]]
    assert seen["localizers"][NAMES[1]]["thesis_mean_m"] == 0.08
    assert list(honest["localizers"]) == NAMES
    for one in (seen, honest):
        assert all(figures["frames"] == 21 for figures in one["localizers"].values())
    # Slow features that have seen the test images are better than those that have not.
    assert seen["localizers"][NAMES[1]]["mean_m"] < honest["localizers"][NAMES[1]]["mean_m"]
    assert [len(table.rows) for table in outcome.tables] == [1, 4]


def test_slow_light(bench, tiny):
    outcome = run_slow_light(bench, 5, tiny)
    grown, seen, unseen = (case["localizers"] for case in outcome.figures["cases"])
    assert (grown[NAMES[1]]["thesis_mean_m"], seen[NAMES[1]]["thesis_mean_m"]) == (1.41, 0.17)
    assert seen["nearest-1"]["max_m"] == pytest.approx(0, abs=1e-3)  # it has every test image by heart
    assert unseen["nearest-1"]["max_m"] > 0.05
    assert all(len(table.rows) == 4 for table in outcome.tables)


def test_dynamic_object(bench, tiny):
    outcome = run_dynamic_object(bench, 5, tiny)
    with_cow, without = (case["localizers"] for case in outcome.figures["cases"])
    assert with_cow[NAMES[1]]["thesis_mean_m"] == 0.12
    assert without["andante"]["thesis_mean_m"] is None
    assert with_cow["nearest-1"]["mean_m"] != without["nearest-1"]["mean_m"]
    assert len(outcome.plots) == 1


def test_a_plan_of_the_needed_sessions_is_enough(cache, singles, tiny):
    some = singles.model_copy(update={"sessions": (singles.session(STATIC),)})
    assert run_static(Bench(some, cache), 5, tiny).figures == run_static(Bench(singles, cache), 5, tiny).figures
