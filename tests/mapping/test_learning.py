"""Which frames are joined, and how many slow features come out."""

import numpy as np
import pytest

from andante.errors import LearningError
from andante.mapping.config import LearningConfig
from andante.mapping.learning import Ground, learn_slow, learning_edges, typical_radius
from andante.sfa import Moments


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


def test_temporal_edges_do_not_cross_a_held_out_block(ground):
    inside = ground.subset(~((ground.number >= 10) & (ground.number < 20)))
    edges = learning_edges(inside, LearningConfig(order="temporal"), seed=0)
    assert len(edges) == 80 - 2 - 11
    steps = inside.number[edges.second] - inside.number[edges.first]
    assert (steps == 1).all()
    assert (inside.session[edges.first] == inside.session[edges.second]).all()


def test_place_edges_join_sessions(ground):
    edges = learning_edges(ground, LearningConfig(), seed=0)
    assert (ground.session[edges.first] != ground.session[edges.second]).any()
    distance = np.linalg.norm(ground.xy[edges.first] - ground.xy[edges.second], axis=1)
    assert distance.max() <= ground.radius


def test_restructured_order_depends_on_the_seed_alone(ground):
    config = LearningConfig(order="restructured")
    one, again, other = (learning_edges(ground, config, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(one.first, again.first)
    assert not (len(one) == len(other) and (one.first == other.first).all())


def test_one_session_cannot_be_restructured_and_keeps_its_order(ground):
    alone = ground.subset(ground.session == 0)
    assert len(learning_edges(alone, LearningConfig(order="restructured"), 0)) == 39


def test_no_edges_is_an_error_that_says_what_to_do(ground):
    apart = Ground(ground.xy * 100, ground.session, ground.number, 0.001)
    with pytest.raises(LearningError, match=r"no two of the 80 frames belong together .* raise learning\.place_radius"):
        learning_edges(apart, LearningConfig(), 0)


def test_typical_radius():
    xy = np.column_stack([[0, 1, 2, 3, 50, 51, 52], np.zeros(7)]).astype(float)
    session = np.array([0, 0, 0, 0, 1, 1, 1])
    assert typical_radius(xy, session, 0.35) == 2.5
    assert typical_radius(xy / 100, session, 0.35) == 0.35
    assert typical_radius(xy[:1], session[:1], 0.35) == 0.35


def test_the_metric_brings_outputs_to_unit_noise_along_edges(ground, features):
    config = LearningConfig(slow_features=6, edge_ridge=0.0)
    edges = learning_edges(ground, config, 0)
    learnt = learn_slow(features, edges, config)
    scaled = learnt.model.transform(features) * learnt.metric
    noise = Moments.of(scaled, edges).edge_covariance
    np.testing.assert_allclose(np.diag(noise), 1, rtol=1e-6)


def test_the_metric_counts_the_noise_of_the_ridge(ground, features):
    edges = learning_edges(ground, LearningConfig(), 0)
    plain, ridged = (learn_slow(features, edges, LearningConfig(slow_features=6, edge_ridge=q)) for q in (0.0, 10.0))
    assert (ridged.metric < plain.metric).all()


@pytest.mark.parametrize(("frames", "repeated", "expected"), [(80, 0, 12), (12, 0, 11), (12, 2, 9), (10, 0, 9)])
def test_as_many_features_as_the_frames_have(ground, features, frames, repeated, expected):
    x = features[:frames].copy()
    x[frames - repeated :] = x[0]
    inside = ground.subset(np.arange(80) < frames)
    config = LearningConfig()
    assert learn_slow(x, learning_edges(inside, config, 0), config).model.output_dim == expected


@pytest.mark.parametrize(("expansion", "needed"), [("linear", 10), ("quadratic", 28)])
def test_too_few_frames(ground, features, expansion, needed):
    config = LearningConfig(expansion=expansion, slow_features=8)
    inside = ground.subset(np.arange(80) < needed - 1)
    with pytest.raises(LearningError, match=f"{needed - 1} usable frames are too few to learn from, at least {needed}"):
        learn_slow(features[: needed - 1], learning_edges(inside, config, 0), config)


def test_identical_pictures_teach_nothing(ground, features):
    alike = np.repeat(features[:1], 80, axis=0)
    with pytest.raises(LearningError, match="none of the 12 signals varies over the 80 samples"):
        learn_slow(alike, learning_edges(ground, LearningConfig(), 0), LearningConfig())
