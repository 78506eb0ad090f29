"""Hierarchical networks: what they learn, whatever the batches, and what they refuse (thesis 3.4, 5.1.1)."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from andante.data import Edges
from andante.errors import ArrayError, ConfigError, LearningError, NotFittedError
from andante.sfa import (
    PCA,
    HierarchicalModel,
    HierarchicalSFA,
    Layer,
    Moments,
    QuadraticSFA,
    SlowModel,
    field_moments,
    solve_slow,
)
from andante.sfa.expansion import expand_quadratic
from andante.sfa.residual import with_residual
from andante.sfa.shared_node import expanded_rows, normalise_fields

ORACLE = json.loads((Path(__file__).parent / "data" / "hierarchy_oracle.json").read_text())
LAYERS = (
    Layer(5, field=(4, 4), stride=(2, 2), reduced_dim=6),
    Layer(6, field=(3, 2), stride=(3, 2), reduced_dim=7),
    Layer(4, reduced_dim=8),
)
ONE_LAYER = (Layer(4, field=(5, 4), stride=(3, 2), reduced_dim=6, clip=None),)


def waves(n=300, height=10, width=20):
    """The pictures of the oracle: travelling waves of grey."""
    t, y, x = np.arange(n)[:, None, None], np.arange(height)[:, None], np.arange(width)
    return 120 + sum(
        30 / np.sqrt(k) * np.sin(k + 0.23 * k * x * np.cos(k) + 0.19 * k * y * np.sin(k) + 0.004 * k**1.7 * t)
        for k in range(1, 10)
    )


def noisy(n=200, height=10, width=20, seed=0):
    """Pictures of 8 bits with variance in all directions."""
    noise = np.random.default_rng(seed).normal(0, 12, (n, height, width))
    return np.clip(waves(n, height, width) + noise, 0, 255).astype(np.uint8)


def patches(pictures, layer):
    """(n, P, d) receptive fields, one after the other."""
    (fw, fh), (sx, sy) = layer.field, layer.stride
    rows = range(0, pictures.shape[1] - fh + 1, sy)
    columns = range(0, pictures.shape[2] - fw + 1, sx)
    fields = [pictures[:, y : y + fh, x : x + fw].reshape(len(pictures), -1) for y in rows for x in columns]
    return np.stack(fields, axis=1).astype(float)


def streamed(pictures, size):
    return lambda: (pictures[i : i + size] for i in range(0, len(pictures), size))


@pytest.fixture
def small_blocks(monkeypatch):
    """Blocks of a few pictures, so that a short series fills many."""
    monkeypatch.setattr(field_moments, "_BLOCK_FIELDS", 100)


def same_arrays(one, other):
    ours, theirs = one.to_arrays(), other.to_arrays()
    assert ours.keys() == theirs.keys()
    for name, array in ours.items():
        np.testing.assert_array_equal(array, theirs[name])


def test_deltas_and_outputs_agree_with_mdp():
    pictures = waves(*ORACLE["pictures"])
    assert pictures.sum() == pytest.approx(ORACLE["checksum"], rel=1e-12)
    layers = [
        Layer(
            layer["output_dim"],
            layer["field"] and tuple(layer["field"]),
            tuple(layer["stride"]),
            layer["reduced_dim"],
            clip=layer["clip"],
        )
        for layer in ORACLE["layers"]
    ]
    network = HierarchicalSFA(layers, deviation_floor=ORACLE["deviation_floor"], double=True).fit(pictures)
    # MDP brings outputs to unit variance with n - 1, which moves the outputs that are clipped.
    np.testing.assert_allclose(network.deltas_, ORACLE["deltas"], rtol=1e-5)
    outputs, theirs = network.transform(pictures)[ORACLE["rows"]], np.array(ORACLE["outputs"])
    signs = np.sign((outputs * theirs).sum(axis=0))
    np.testing.assert_allclose(outputs * signs, theirs, atol=2e-5)


def test_one_layer_is_plain_quadratic_sfa_on_patches():
    pictures, layer = noisy(), ONE_LAYER[0]
    network = HierarchicalSFA(ONE_LAYER, deviation_floor=None, double=True).fit(pictures)
    fields = patches(pictures, layer)
    episodes = [fields[:, position] for position in range(fields.shape[1])]
    plain = QuadraticSFA(4, reduced_dim=6).fit(episodes)
    np.testing.assert_allclose(network.model_.nodes[0].deltas, plain.deltas_, rtol=1e-9)
    by_position = np.stack([plain.transform(episode) for episode in episodes], axis=2)
    outputs = network.transform(pictures).reshape(len(pictures), 4, -1)
    np.testing.assert_allclose(outputs, by_position, atol=1e-7)
    assert network.deltas_.shape == (4 * fields.shape[1],)


@pytest.mark.parametrize("residual", [0.0, 0.5])
def test_outputs_of_a_node_have_unit_variance_and_are_decorrelated(residual):
    pictures = noisy()
    unclipped = [replace(layer, clip=None, residual=residual) for layer in LAYERS]
    network = HierarchicalSFA(unclipped, double=True).fit(pictures).model_
    for count in (1, 2, 3):
        maps = network.first(count).run(pictures[:, None], np.float64)
        samples = maps.transpose(0, 2, 3, 1).reshape(-1, maps.shape[1])
        np.testing.assert_allclose(samples.T @ samples / len(samples), np.eye(maps.shape[1]), atol=1e-9)
        np.testing.assert_allclose(samples.mean(axis=0), 0, atol=1e-9)
        deltas = (np.diff(maps, axis=0) ** 2).mean(axis=(0, 2, 3))
        np.testing.assert_allclose(network.nodes[count - 1].deltas, deltas, rtol=1e-8)
        assert (np.diff(deltas[: maps.shape[1] - int(residual * maps.shape[1])]) >= 0).all()


@pytest.mark.parametrize("size", [1, 7, 200])
def test_the_size_of_batches_changes_nothing(size, small_blocks):
    pictures = noisy()
    same_arrays(
        HierarchicalSFA(LAYERS).fit(pictures).model_, HierarchicalSFA(LAYERS).fit(streamed(pictures, size)).model_
    )


def test_blocks_change_nothing_but_rounding(monkeypatch):
    pictures = noisy()
    edges = Edges(
        np.array([0, 3, 199, 20, 20, 150, 41]), np.array([150, 4, 2, 20, 21, 90, 40]), np.array([1, 2, 0.5, 3, 1, 1, 1])
    )
    edges = Edges.joined([edges, Edges.between(np.arange(199), np.arange(1, 200))])
    one = HierarchicalSFA(LAYERS, double=True).fit(pictures, edges=edges)
    monkeypatch.setattr(field_moments, "_BLOCK_FIELDS", 100)
    monkeypatch.setattr(field_moments, "_STRETCH_BLOCKS", 3)
    many = HierarchicalSFA(LAYERS, double=True).fit(pictures, edges=edges)
    np.testing.assert_allclose(many.deltas_, one.deltas_, rtol=1e-9)
    np.testing.assert_allclose(many.transform(pictures), one.transform(pictures), atol=1e-7)


def test_edges_are_those_of_moments(small_blocks):
    """Weighted edges of any length, at every position of the grid."""
    pictures, layer = noisy(60), ONE_LAYER[0]
    rng = np.random.default_rng(3)
    edges = Edges(rng.integers(0, 60, 300), rng.integers(0, 60, 300), rng.uniform(0, 2, 300))
    fields = patches(pictures, layer)
    expected = Moments.empty(20)
    for position in range(fields.shape[1]):
        expected = expected.merge(Moments.of(fields[:, position], edges))
    network = HierarchicalSFA(ONE_LAYER, deviation_floor=None, double=True).fit(pictures, edges=edges)
    reduce = network.model_.nodes[0].reduce
    np.testing.assert_allclose(reduce.mean, expected.mean, rtol=1e-12)
    slow = expected.projected(reduce.weights)
    np.testing.assert_allclose(slow.covariance, np.eye(6), atol=1e-9)
    np.testing.assert_allclose(slow.edge_covariance, np.diag(reduce.deltas), atol=1e-9)


def test_time_never_crosses_recordings():
    one, other = noisy(80, seed=1), noisy(70, seed=2)[::-1]
    edges = Edges.between(np.delete(np.arange(149), 79), np.delete(np.arange(1, 150), 79))
    explicit = HierarchicalSFA(LAYERS).fit(np.concatenate([one, other]), edges=edges)
    same_arrays(HierarchicalSFA(LAYERS).fit([one, other]).model_, explicit.model_)
    same_arrays(HierarchicalSFA(LAYERS).fit([streamed(one, 30), other]).model_, explicit.model_)


def test_single_pictures_batches_and_precisions_agree():
    pictures = noisy()
    network = HierarchicalSFA(LAYERS, wrap=True).fit(pictures)
    outputs = network.transform(pictures)
    assert outputs.shape == (200, 4)
    assert outputs.dtype == np.float64
    assert isinstance(network.model_, SlowModel)
    np.testing.assert_allclose(network.transform(pictures[17]), outputs[17], atol=1e-4)
    np.testing.assert_array_equal(network.model_.transform(pictures.reshape(200, -1)), outputs)
    np.testing.assert_allclose(network.model_.transform(pictures, dtype=np.float64), outputs, atol=1e-3)
    double = HierarchicalSFA(LAYERS, wrap=True, double=True).fit(pictures)
    np.testing.assert_allclose(double.deltas_, network.deltas_, rtol=1e-3)
    np.testing.assert_allclose(outputs.var(axis=0), 1, atol=1e-3)


def test_outputs_are_clipped():
    layers = [Layer(3, reduced_dim=5, clip=1.5)]
    outputs = HierarchicalSFA(layers, deviation_floor=None).fit(noisy()).transform(noisy(seed=5))
    assert np.abs(outputs).max() == 1.5


def test_noise_takes_effect_as_if_it_had_been_drawn():
    layer = Layer(4, field=(5, 4), stride=(3, 2), reduced_dim=6, noise=0.5, clip=None)
    pictures = noisy(400)
    node = HierarchicalSFA([layer], deviation_floor=None, double=True).fit(pictures).model_.nodes[0]
    fields = patches(pictures, layer)
    rng = np.random.default_rng(0)
    drawn = Moments.empty(27)
    for position in range(fields.shape[1]):
        terms = expand_quadratic(node.reduce.transform(fields[:, position]))
        drawn.add_series(terms + rng.normal(0, np.sqrt(0.5), terms.shape))
    # The outputs solve the problem with the noise: they are decorrelated there, and so are their differences.
    for matrix in (drawn.covariance, drawn.edge_covariance):
        inside = node.slow.weights.T @ matrix @ node.slow.weights
        np.testing.assert_allclose(inside, np.diag(inside.diagonal()), atol=0.05 * inside.max())


def test_a_residual_carries_on_what_slow_features_leave_unsaid():
    """With as many components as signals are left, slow features and residual together tell all of the signals."""
    x = np.random.default_rng(0).normal(size=(500, 6)) @ np.random.default_rng(1).normal(size=(6, 6))
    moments = Moments.empty(6)
    moments.add_series(x)
    slow = solve_slow(moments, 2)
    assert with_residual(slow, moments, 0, 6) is slow
    some = with_residual(slow, moments, 1, 6)
    error = x - slow.transform(x) @ np.linalg.lstsq(slow.transform(x), x - x.mean(axis=0), rcond=None)[0]
    strongest = PCA.of(Moments.of(error), 1).transform(error)
    assert abs(np.corrcoef(strongest[:, 0], some.transform(x)[:, 2])[0, 1]) > 1 - 1e-9
    outputs = with_residual(slow, moments, 4, 6).transform(x)
    np.testing.assert_allclose(outputs.T @ outputs / 500, np.eye(6), atol=1e-9)
    with pytest.raises(LearningError, match="cannot carry on 5 components: 2 slow features tell nearly all of 6"):
        with_residual(slow, moments, 5, 6)


def test_a_turned_panorama_turns_the_first_layer():
    pictures = noisy()
    network = HierarchicalSFA(LAYERS[:1], wrap=True).fit(pictures).model_
    turned = network.run(np.roll(pictures[:5], 6, axis=2)[:, None])
    np.testing.assert_allclose(turned, np.roll(network.run(pictures[:5, None]), 3, axis=3), atol=1e-5)


def test_simulated_turns_make_outputs_independent_of_the_heading():
    pictures = waves(200)
    pictures[:, :, -10:] = pictures[:, :, 9::-1]  # closes around
    upright, turned = (HierarchicalSFA(LAYERS, wrap=True, turns=turns).fit(pictures) for turns in (1, 5))
    spread = []
    for network in (upright, turned):
        headings = np.stack([network.transform(np.roll(pictures, shift, axis=2)) for shift in range(0, 20, 3)])
        spread.append((headings.std(axis=0).mean(axis=0) / headings.std(axis=(0, 1)))[0])
    assert spread[1] < 0.5 * spread[0]


def test_learning_shows_progress_and_resumes_after_a_layer():
    pictures, stages, networks = noisy(), [], []
    whole = HierarchicalSFA(LAYERS).fit(
        pictures, progress=lambda *stage: stages.append(stage), on_layer=networks.append
    )
    assert [len(network.layers) for network in networks] == [1, 2, 3]
    assert stages[0] == ("layer 1 reduces", 200, 200)
    assert {stage for stage, _, _ in stages} >= {"layer 1 hands on", "layer 2 expands", "layer 3 expands"}
    stored = HierarchicalModel.from_arrays(networks[1].to_arrays())
    stages.clear()
    resumed = HierarchicalSFA(LAYERS).fit(pictures, resume=stored, progress=lambda *stage: stages.append(stage))
    same_arrays(resumed.model_, whole.model_)
    assert "layer 1 reduces" not in {stage for stage, _, _ in stages}
    same_arrays(HierarchicalSFA(LAYERS).fit(pictures, resume=whole.model_).model_, whole.model_)


def test_arrays_for_a_file_bring_the_model_back():
    model = HierarchicalSFA(LAYERS, deviation_floor=None, wrap=True).fit(noisy()).model_
    back = HierarchicalModel.from_arrays(model.to_arrays())
    assert (back.layers, back.shape, back.wrap, back.deviation_floor) == (LAYERS, (10, 20), True, None)
    np.testing.assert_array_equal(back.transform(noisy(9)), model.transform(noisy(9)))
    arrays = model.to_arrays()
    with pytest.raises(ArrayError, match="HierarchicalModel lacks the stored arrays wrap"):
        HierarchicalModel.from_arrays({name: array for name, array in arrays.items() if name != "wrap"})
    with pytest.raises(ArrayError, match=r"needs layers \(L, 9\).* got shapes \(3, 7\)"):
        HierarchicalModel.from_arrays({**arrays, "layers": arrays["layers"][:, :7]})
    with pytest.raises(ConfigError, match="finite numbers"):
        HierarchicalModel.from_arrays({**arrays, "layers": np.where(arrays["layers"] == 6, np.nan, arrays["layers"])})


def test_terms_in_rows_are_those_in_columns():
    x = np.random.default_rng(0).normal(size=(7, 30))
    np.testing.assert_array_equal(expanded_rows(x), expand_quadratic(x.T).T)


def test_plain_fields_are_not_blown_up():
    fields = np.random.default_rng(0).normal(100, 30, (50, 4)).astype(np.float32)
    fields[:, 0] = 7
    fields[:, 1] = 50 + 0.1 * fields[:, 1]
    normalised = normalise_fields(fields.copy(), 20.0)
    np.testing.assert_allclose(normalised.mean(axis=0), 0, atol=1e-5)
    assert normalised[:, 0].std() == 0
    assert normalised[:, 1].std() < 0.2
    np.testing.assert_allclose(normalise_fields(fields.copy(), 0.0)[:, 1:].std(axis=0), 1, rtol=1e-4)
    assert (normalise_fields(fields.copy(), 0.0)[:, 0] == 0).all()


@pytest.mark.parametrize(
    ("pictures", "message"),
    [
        (np.zeros((5, 10), np.uint8), r"pictures come as \(n, height, width\)"),
        (np.zeros((5, 10, 20), np.int64), "have to be uint8 or floating, got int64"),
        (np.full((5, 10, 20), np.nan), "NaN or infinity"),
        (np.zeros((1, 10, 20)), "there is 1 picture"),
        (lambda: iter([]), "the stream of batches is empty"),
        ([np.zeros((5, 10, 20)), np.zeros((5, 10, 22))], "one size: got 22x10 after 20x10"),
        ([np.zeros((5, 10, 20)), np.zeros((5, 10, 20), np.uint8)], "one type: got uint8 after float32"),
    ],
)
def test_pictures_that_cannot_be_used(pictures, message):
    with pytest.raises(ArrayError, match=message):
        HierarchicalSFA(LAYERS).fit(pictures)


def test_faults_of_learning_name_the_layer_and_the_remedy():
    with pytest.raises(LearningError, match="layer 1 of the network: cannot learn slow features: none of the 16"):
        HierarchicalSFA(LAYERS).fit(np.zeros((9, 10, 20), np.uint8))
    with pytest.raises(LearningError, match="layer 1 of the network: there are no edges"):
        HierarchicalSFA(LAYERS).fit(noisy(), edges=Edges.joined([]))
    with pytest.raises(ArrayError, match=r"edges join pictures 0\.\.200, but there are pictures 0\.\.199"):
        HierarchicalSFA(LAYERS).fit(noisy(), edges=Edges.between([0], [200]))
    with pytest.raises(ArrayError, match="weights have to be 1 finite numbers"):
        HierarchicalSFA(LAYERS).fit(noisy(), edges=Edges.between([0], [1], weight=-1))
    with pytest.raises(ConfigError, match="deviation_floor=-1"):
        HierarchicalSFA(LAYERS, deviation_floor=-1).fit(noisy())
    with pytest.raises(ConfigError, match="turns=0"):
        HierarchicalSFA(LAYERS, turns=0).fit(noisy())


def test_faults_of_using_a_network():
    with pytest.raises(NotFittedError, match="has not learnt yet: call fit first"):
        HierarchicalSFA().transform(np.zeros((60, 600)))
    network = HierarchicalSFA(LAYERS).fit(noisy())
    with pytest.raises(ArrayError, match=r"takes pictures \(10, 20\), one or a stack of them, got shape \(20, 10\)"):
        network.transform(np.zeros((20, 10)))
    with pytest.raises(ConfigError, match="cannot resume: the network so far has 1 layers for 20x10 pictures"):
        HierarchicalSFA(LAYERS, wrap=True).fit(noisy(), resume=network.model_.first(1))
    nodes = network.model_.nodes
    with pytest.raises(ArrayError, match="a network of 3 layers needs as many nodes, got 2"):
        HierarchicalModel(LAYERS, nodes[:2], (10, 20))
    with pytest.raises(ArrayError, match="layer 1 is declared as 16 -> 6 -> 5 signals, but its node is 30 -> 7 -> 6"):
        HierarchicalModel(LAYERS, (nodes[1], *nodes[1:]), (10, 20))
