"""How to learn: what is said counts, what is left open is chosen on sessions held out."""

import dataclasses

import numpy as np
import pytest

from andante.errors import LearningError
from andante.mapping import FrontEnd, MapConfig, encode_session, selection
from andante.mapping.codes import Codes
from andante.mapping.frontend import camera_and_size
from andante.mapping.learning import Recipe, learn_slow, place_moments
from andante.mapping.lessons import Lessons, lessons_of
from andante.mapping.readout import LocalReadout
from andante.mapping.selection import choose_recipe

PRIOR = Recipe("places", "linear", reduced_dim=20, slow_features=192, ridge=0.0, edge_ridge=10.0, invariance=1.0)
CONFIG = MapConfig().with_values({"learning": {"pca_components": 40}})
SMALL = {4: (8, 16, 32)}


@pytest.fixture(scope="module")
def sessions(garden) -> list:
    """Eight drives of 25 frames, each in its own light."""
    lights = [(1.0, 0), (0.7, 20), (0.85, -10), (1.1, 5), (0.6, 40), (0.9, 15), (1.2, -30), (0.75, 0)]
    days = [
        garden.drive(garden.loop(25, 0.1 * n, 3 + 0.01 * n), name=f"day {n}", gain=gain, offset=offset)
        for n, (gain, offset) in enumerate(lights)
    ]
    front_end = FrontEnd(*camera_and_size(days[0]), CONFIG.panorama, CONFIG.features)
    return [encode_session(day, front_end, "reference", CONFIG) for day in days]


@pytest.fixture(scope="module")
def lessons(sessions):
    """``lessons(count)`` of the first sessions."""

    def of(count: int, config: MapConfig = CONFIG) -> Lessons:
        chosen = sessions[:count]
        return lessons_of(chosen, Codes.joined([session.codes for session in chosen]), config)

    return of


def with_learning(**values) -> MapConfig:
    return CONFIG.with_values({"learning": values})


def trials_of(lessons: Lessons) -> list:
    return [selection._Trial(lessons.x, lessons.ground, train, test, 0) for train, test in lessons.folds]


@pytest.fixture
def no_trials(monkeypatch):
    def never(*arguments):
        raise AssertionError("nothing is to be tried")

    monkeypatch.setattr(selection._Trial, "errors", never)


@pytest.fixture
def answers(monkeypatch):
    """``answers(function)`` lets trials answer with errors by recipe; returns the candidates of each as asked."""

    def answer(error_of) -> list:
        asked = []

        def errors(self, candidates, readout, whole):
            asked.append(candidates)
            return np.array([error_of(recipe) for recipe in candidates])

        monkeypatch.setattr(selection._Trial, "errors", errors)
        return asked

    return answer


@pytest.mark.parametrize("count", [1, 2, 3])
def test_few_sessions_expect_the_worst(lessons, no_trials, count):
    assert choose_recipe(lessons(count), CONFIG) == PRIOR


@pytest.mark.parametrize("count", [2, 5])
def test_where_nothing_is_open_nothing_is_tried(lessons, no_trials, count):
    config = with_learning(slow_features=11, edge_ridge=0.0, invariance=3.0, ridge=0.25, density_corrected=True)
    expected = Recipe("places", "linear", 20, 11, 0.25, 0.0, 3.0, density_corrected=True)
    assert choose_recipe(lessons(count), config) == expected


def test_the_thesis_is_never_tried(lessons, no_trials):
    thesis = MapConfig.thesis().with_values({"learning": {"invariance": 1.0}})
    recipe = choose_recipe(lessons(5), thesis)
    assert (recipe.order, recipe.expansion, recipe.slow_features) == ("restructured", "quadratic", 8)


@pytest.mark.parametrize(
    "said", [{"slow_features": 13}, {"edge_ridge": 0.5}, {"invariance": 4.0}, {"edge_ridge": 0.0, "slow_features": 5}]
)
@pytest.mark.parametrize("count", [3, 5])
def test_what_is_said_counts(lessons, answers, said, count):
    asked = answers(lambda recipe: 1.0)
    recipe = choose_recipe(lessons(count), with_learning(**said))
    for candidate in [recipe, *(one for candidates in asked for one in candidates)]:
        assert {name: getattr(candidate, name) for name in said} == said


@pytest.mark.parametrize(("count", "sizes"), [(4, {96, 128, 192}), (7, {96, 128, 192}), (8, {64, 96, 128, 192})])
def test_all_that_is_open_is_tried_on_every_fold(lessons, answers, count, sizes):
    asked = answers(lambda recipe: 1.0)
    choose_recipe(lessons(count), CONFIG)
    assert len(asked) == count
    for candidates in asked:
        assert candidates == asked[0]
        assert len(set(candidates)) == len(candidates)
        tried = {(one.slow_features, one.edge_ridge, one.invariance) for one in candidates}
        assert tried == {
            (size, ridge, weight) for size in sizes for ridge in (0.1, 1.0, 10.0) for weight in (1.0, 10.0)
        }


@pytest.mark.parametrize("order", ["temporal", "restructured"])
def test_orders_without_invariance_do_not_try_it(lessons, answers, order):
    asked = answers(lambda recipe: 1.0)
    choose_recipe(lessons(4), with_learning(order=order))
    assert {recipe.invariance for recipe in asked[0]} == {1.0}
    assert len(asked[0]) == 9


def test_of_the_smallest_that_are_good_enough_the_best_wins(lessons, answers):
    """Against the words, for errors drawn at random around one."""
    rng = np.random.default_rng(0)
    for _ in range(50):
        drawn: dict[Recipe, float] = {}
        asked = answers(lambda recipe, drawn=drawn: drawn.setdefault(recipe, float(rng.uniform(1, 1.3))))
        chosen = choose_recipe(lessons(4), CONFIG)
        assert chosen in asked[0]
        good = [recipe for recipe, error in drawn.items() if error <= 1.1 * min(drawn.values())]
        smallest = min(recipe.slow_features for recipe in good)
        assert chosen.slow_features == smallest
        assert drawn[chosen] == min(drawn[recipe] for recipe in good if recipe.slow_features == smallest)


def test_a_small_one_that_is_not_good_enough_loses(lessons, answers):
    answers(lambda recipe: {96: 1.2, 128: 1.09, 192: 1.0}[recipe.slow_features] + 0.001 * recipe.edge_ridge)
    assert choose_recipe(lessons(4), CONFIG) == dataclasses.replace(PRIOR, slow_features=128, edge_ridge=0.1)


def test_what_cannot_be_learnt_is_not_chosen(lessons, answers):
    answers(lambda recipe: np.inf if recipe.slow_features < 192 else 2.0 + recipe.invariance + recipe.edge_ridge)
    assert choose_recipe(lessons(4), CONFIG) == dataclasses.replace(PRIOR, edge_ridge=0.1)
    answers(lambda recipe: np.inf)
    assert choose_recipe(lessons(4), CONFIG) == PRIOR


def test_a_family_that_fails_leaves_the_others(lessons, monkeypatch):
    original = selection.linear_slow

    def fails(moments, most, recipe):
        if recipe.edge_ridge == 1.0:
            raise LearningError("no")
        return original(moments, most, recipe)

    monkeypatch.setattr(selection, "linear_slow", fails)
    candidates = [dataclasses.replace(PRIOR, slow_features=8, edge_ridge=ridge) for ridge in (0.1, 1.0, 10.0)]
    given = lessons(4)
    errors = trials_of(given)[0].errors(candidates, CONFIG.readout, place_moments(given.x, given.ground))
    assert np.isfinite(errors).tolist() == [True, False, True]


@pytest.mark.parametrize("count", [4, 6])
def test_sums_without_a_session_are_as_good_as_learning_without_it(lessons, count):
    given = lessons(count)
    whole = place_moments(given.x, given.ground)
    candidates = [
        dataclasses.replace(PRIOR, slow_features=size, edge_ridge=ridge, invariance=invariance)
        for size in (8, 16, 32)
        for ridge in (0.1, 10.0)
        for invariance in (1.0, 10.0)
    ]
    for trial in trials_of(given):
        taken_out = trial.errors(candidates, CONFIG.readout, whole)
        learnt_anew = trial.errors(candidates, CONFIG.readout, None)
        one_by_one = np.array([trial.errors([candidate], CONFIG.readout, None)[0] for candidate in candidates])
        assert np.isfinite(taken_out).all()
        np.testing.assert_allclose(taken_out, learnt_anew, rtol=1e-6, atol=1e-6)
        np.testing.assert_allclose(taken_out, one_by_one, rtol=1e-6, atol=1e-6)


def test_errors_are_those_of_the_held_out_session_and_capped(lessons):
    given = lessons(4)
    whole = place_moments(given.x, given.ground)
    elsewhere = dataclasses.replace(given.ground, xy=given.ground.xy + 1000.0 * (given.ground.session == 1)[:, None])
    recipe = dataclasses.replace(PRIOR, slow_features=32)
    for number, (train, test) in enumerate(given.folds):
        near = selection._Trial(given.x, given.ground, train, test, 0).errors([recipe], CONFIG.readout, whole)
        far = selection._Trial(given.x, elsewhere, train, test, 0).errors([recipe], CONFIG.readout, None)
        inside = given.ground.subset(train)
        learnt = learn_slow(given.x[train], inside, recipe, 0)
        slow = learnt.model.transform(given.x[train])
        readout = LocalReadout.fit(slow, inside.xy, learnt.metric, CONFIG.readout, 2 * inside.radius)
        located = readout.locate(learnt.model.transform(given.x[test]))
        assert near[0] == pytest.approx(np.linalg.norm(located.xy - given.ground.xy[test], axis=1).mean(), rel=1e-6)
        assert near[0] < 2 * given.ground.radius
        if number == 1:
            assert far[0] == pytest.approx(10 * given.ground.radius)


@pytest.mark.parametrize("order", ["places", "temporal"])
def test_the_choice_is_a_candidate_and_always_the_same(lessons, monkeypatch, order):
    monkeypatch.setattr(selection, "_SLOW_FEATURES", SMALL)
    config, given = with_learning(order=order), lessons(5)
    chosen = choose_recipe(given, config)
    assert chosen.slow_features in SMALL[4]
    assert chosen.edge_ridge in (0.1, 1.0, 10.0)
    assert chosen.order == order
    assert choose_recipe(lessons(5), config) == chosen
