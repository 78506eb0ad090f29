"""Which frames belong together, and how many slow features come out."""

import dataclasses

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.data import Edges
from andante.errors import LearningError
from andante.mapping.learning import (
    Ground,
    Recipe,
    learn_slow,
    linear_slow,
    most_features,
    place_moments,
    training_moments,
    typical_radius,
)
from andante.sequences import restructured_edges
from andante.sfa import Moments

PLACES = Recipe("places", "linear", reduced_dim=20, slow_features=192, ridge=0.0, edge_ridge=10.0, invariance=1.0)
TEMPORAL = dataclasses.replace(PLACES, order="temporal")
RESTRUCTURED = dataclasses.replace(PLACES, order="restructured")


@pytest.fixture(scope="module")
def ground() -> Ground:
    along = np.tile(np.linspace(0, 6, 40), 2)
    xy = np.column_stack([along, np.repeat([0.0, 0.1], 40)])
    return Ground(xy, np.repeat([0, 1], 40), np.arange(80), 0.5)


@pytest.fixture(scope="module")
def features(ground) -> np.ndarray:
    rng = np.random.default_rng(2)
    slow = np.sin(ground.xy[:, :1] * rng.uniform(0.2, 2, 12) + rng.uniform(0, 6, 12))
    return (slow + 0.1 * rng.normal(size=slow.shape)).astype(np.float32)


def same_moments(one: Moments, other: Moments) -> None:
    np.testing.assert_allclose(one.edge_covariance, other.edge_covariance, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(one.covariance, other.covariance, rtol=1e-9, atol=1e-12)


def test_temporal_order_does_not_cross_a_held_out_block(ground, features):
    outside = ~((ground.number >= 10) & (ground.number < 20))
    inside, x = ground.subset(outside), features[outside]
    pairs = [
        (i, i + 1)
        for i in range(len(inside) - 1)
        if inside.number[i + 1] == inside.number[i] + 1 and inside.session[i + 1] == inside.session[i]
    ]
    assert len(pairs) == 80 - 2 - 11
    moments = training_moments(x, inside, TEMPORAL, seed=0)
    assert moments.n_edges == len(pairs)
    same_moments(moments, Moments.of(x, Edges(*np.array(pairs).T, np.ones(len(pairs)))))


def test_places_order_is_the_mean_path_and_the_scatter_inside_of_places(ground, features):
    """Against the definition, cell by cell; both sessions count for one and the same place."""
    x = features.astype(np.float64)
    cells: dict[tuple[int, int], list[int]] = {}
    for frame, (east, north) in enumerate(ground.xy / (ground.radius / 2.5)):
        cells.setdefault((int(np.floor(east)), int(np.floor(north))), []).append(frame)
    assert any(len(set(ground.session[frames])) == 2 for frames in cells.values())
    mean = {cell: x[frames].mean(axis=0) for cell, frames in cells.items()}
    between, total, within = np.zeros((12, 12)), 0.0, np.zeros((12, 12))
    for one in cells:
        for other in cells:
            apart = (one[0] - other[0]) ** 2 + (one[1] - other[1]) ** 2
            if one < other and apart <= 2:
                between += np.exp(-apart / 2) * np.outer(mean[one] - mean[other], mean[one] - mean[other])
                total += np.exp(-apart / 2)
        for frame in cells[one]:
            within += np.outer(x[frame] - mean[one], x[frame] - mean[one]) / 80
    for invariance in (0.0, 1.0, 7.0):
        moments = training_moments(features, ground, dataclasses.replace(PLACES, invariance=invariance), seed=0)
        np.testing.assert_allclose(moments.edge_covariance, between / total + invariance * within, rtol=1e-9, atol=1e-12)
        np.testing.assert_allclose(moments.covariance, np.cov(x.T, bias=True), rtol=1e-6)


def test_places_order_joins_sessions_and_counts_places_alike_where_asked(ground, features):
    """What tells the sessions apart is noise inside of places, and nothing else."""
    shifted = features + 5.0 * ground.session[:, None].astype(np.float32)
    plain, moved = (place_moments(x, ground).moments(1.0).edge_covariance for x in (features, shifted))
    assert (np.diag(moved) > np.diag(plain) + 1.0).all()
    dwelt = np.concatenate([np.arange(80), np.repeat(3, 400)])
    for corrected in (False, True):
        recipe = dataclasses.replace(PLACES, density_corrected=corrected)
        offset = [
            np.abs(training_moments(features[rows], ground.subset(rows), recipe, 0).mean - features[3]).max()
            for rows in (np.arange(80), dwelt)
        ]
        assert (offset[1] > 0.9 * offset[0]) == corrected  # the mean is not drawn to where the robot dwelt


@given(st.floats(0.01, 1e3), st.lists(st.tuples(st.floats(-1e3, 1e3), st.floats(-1e3, 1e3)), min_size=2, max_size=20))
def test_frames_of_one_place_are_within_its_radius(radius, points):
    xy = np.array(points)
    cells = Ground(xy, np.zeros(len(xy), np.int64), np.arange(len(xy)), radius).cells
    together = (cells[:, None] == cells[None]).all(axis=2)
    apart = np.linalg.norm(xy[:, None] - xy[None], axis=2)
    assert apart[together].max() <= radius


def test_neither_invariance_nor_seed_touch_an_order_that_knows_none(ground, features):
    one = training_moments(features, ground, TEMPORAL, 0)
    same_moments(one, training_moments(features, ground, dataclasses.replace(TEMPORAL, invariance=9.0), 5))


def test_restructured_order_depends_on_the_seed_alone(ground, features):
    one, again, other = (training_moments(features, ground, RESTRUCTURED, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.edge_scatter, again.edge_scatter)
    assert not np.array_equal(one.edge_scatter, other.edge_scatter)
    edges = restructured_edges(ground.xy, ground.session, ground.radius, np.random.default_rng(1))
    assert (ground.session[edges.first] != ground.session[edges.second]).any()
    same_moments(one, Moments.of(features, edges))


def test_one_session_cannot_be_restructured_and_keeps_its_order(ground, features):
    alone = ground.session == 0
    moments = [training_moments(features[alone], ground.subset(alone), recipe, 0) for recipe in (RESTRUCTURED, TEMPORAL)]
    assert moments[0].n_edges == 39
    same_moments(*moments)


@pytest.mark.parametrize("recipe", [PLACES, TEMPORAL])
def test_no_edges_is_an_error_that_says_what_to_do(ground, features, recipe):
    apart = Ground(ground.xy * 100 + ground.session[:, None], ground.session, 2 * ground.number, 0.001)
    with pytest.raises(LearningError, match=r"no two of the 80 frames belong together.*record more frames or") as caught:
        training_moments(features, apart, recipe, 0)
    assert "raise learning.place_radius_m" in str(caught.value) or recipe is PLACES


def test_typical_radius():
    xy = np.column_stack([[0, 1, 2, 3, 50, 51, 52], np.zeros(7)]).astype(float)
    session = np.array([0, 0, 0, 0, 1, 1, 1])
    assert typical_radius(xy, session, 0.35) == 2.5
    assert typical_radius(xy / 100, session, 0.35) == 0.35
    assert typical_radius(xy[:1], session[:1], 0.35) == 0.35


@pytest.mark.parametrize("recipe", [PLACES, TEMPORAL, RESTRUCTURED])
def test_the_metric_brings_outputs_to_unit_noise_along_edges(ground, features, recipe):
    recipe = dataclasses.replace(recipe, slow_features=6, edge_ridge=0.0)
    learnt = learn_slow(features, ground, recipe, 0)
    scaled = learnt.model.transform(features) * learnt.metric
    noise = training_moments(scaled, ground, recipe, 0).edge_covariance
    np.testing.assert_allclose(np.diag(noise), 1, rtol=1e-6)


def test_the_metric_counts_the_noise_of_the_ridge(ground, features):
    recipes = [dataclasses.replace(PLACES, slow_features=6, edge_ridge=ridge) for ridge in (0.0, 10.0)]
    plain, ridged = (learn_slow(features, ground, recipe, 0) for recipe in recipes)
    assert (ridged.metric < plain.metric).all()


@pytest.mark.parametrize("expansion", ["linear", "quadratic"])
def test_the_slowest_features_are_those_of_a_smaller_model(ground, features, expansion):
    recipe = dataclasses.replace(PLACES, expansion=expansion, slow_features=8, reduced_dim=4, edge_ridge=0.1)
    largest = learn_slow(features, ground, recipe, 0)
    smaller = learn_slow(features, ground, dataclasses.replace(recipe, slow_features=3), 0)
    first = largest.slowest(3)
    np.testing.assert_allclose(first.metric, smaller.metric, rtol=1e-6)
    expected, found = smaller.model.transform(features), first.model.transform(features)
    assert found.shape == (80, 3)
    np.testing.assert_allclose(found * np.sign((found * expected).sum(axis=0)), expected, atol=1e-6)
    np.testing.assert_array_equal(largest.slowest(99).model.transform(features), largest.model.transform(features))


def test_moments_alone_give_the_same_linear_features(ground, features):
    learnt, recipe = learn_slow(features, ground, PLACES, 0), PLACES
    again = linear_slow(training_moments(features, ground, recipe, 0), most_features(features), recipe)
    np.testing.assert_array_equal(learnt.model.weights, again.model.weights)
    np.testing.assert_array_equal(learnt.metric, again.metric)


@pytest.mark.parametrize(("frames", "repeated", "expected"), [(80, 0, 12), (12, 0, 11), (12, 2, 9), (10, 0, 9)])
@pytest.mark.parametrize("rounding", [0.0, 1e-7])
def test_as_many_features_as_the_frames_have(ground, features, frames, repeated, expected, rounding):
    """Repeated pictures add none, be they the same up to rounding alone."""
    x = features[:frames].copy()
    x[frames - repeated :] = x[0] * (1 + rounding * np.arange(repeated)[:, None])
    inside = ground.subset(np.arange(80) < frames)
    assert learn_slow(x, inside, PLACES, 0).model.output_dim == most_features(x) == expected


@pytest.mark.parametrize(("expansion", "needed"), [("linear", 10), ("quadratic", 28)])
def test_too_few_frames(ground, features, expansion, needed):
    recipe = dataclasses.replace(PLACES, expansion=expansion, slow_features=8)
    inside = ground.subset(np.arange(80) < needed - 1)
    with pytest.raises(LearningError, match=f"{needed - 1} usable frames are too few to learn from, at least {needed}"):
        learn_slow(features[: needed - 1], inside, recipe, 0)


@pytest.mark.parametrize("recipe", [PLACES, TEMPORAL, RESTRUCTURED])
def test_identical_pictures_teach_nothing(ground, features, recipe):
    alike = np.repeat(features[:1], 80, axis=0)
    with pytest.raises(LearningError, match="none of the 12 signals varies over the 80 samples"):
        learn_slow(alike, ground, recipe, 0)
