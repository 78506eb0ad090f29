import numpy as np
import pytest

from andante.data import Edges
from andante.errors import ArrayError, ConfigError
from andante.sfa import KernelModel, KernelSFA
from andante.sfa.kernel import farthest_points, shares


@pytest.fixture(scope="module")
def ring():
    """A walk around a circle, seen through cubic signals."""
    angle = np.cumsum(np.random.default_rng(0).normal(0.0, 0.25, 3000))
    return angle, np.column_stack([np.cos(angle), np.sin(angle), np.cos(angle) ** 3, np.sin(2 * angle)])


@pytest.fixture(scope="module")
def model(ring):
    return KernelSFA(4, reduced_dim=3, prototypes=60).fit(ring[1]).model_


def test_shares_are_those_of_the_formula_and_sum_to_one():
    rng = np.random.default_rng(1)
    z, prototypes = rng.normal(size=(50, 3)), rng.normal(size=(7, 3))
    weight = np.exp(-((z[:, None] - prototypes[None]) ** 2).sum(axis=2) / (2 * 0.8**2))
    np.testing.assert_allclose(shares(z, prototypes, 0.8), weight / weight.sum(axis=1, keepdims=True), atol=1e-12)


def test_what_looks_like_nothing_still_belongs_to_the_nearest():
    far = shares(np.full((1, 2), 1e4), np.array([[0.0, 0.0], [1.0, 1.0]]), 0.1)
    np.testing.assert_allclose(far, [[0.0, 1.0]])


def test_farthest_points_are_spread_and_end_where_all_are_the_same():
    line = np.concatenate([np.zeros(500), np.linspace(0, 1, 11)])[:, None]
    chosen = line[farthest_points(line, 3), 0]
    np.testing.assert_allclose(sorted(chosen), [0.0, 0.5, 1.0])
    assert len(farthest_points(line, 100)) == 11


def test_outputs_have_unit_variance_and_the_deltas_that_the_model_says(ring, model):
    y = model.transform(ring[1])
    np.testing.assert_allclose(y.std(axis=0), 1.0, atol=1e-6)
    np.testing.assert_allclose((np.diff(y, axis=0) ** 2).mean(axis=0), model.deltas, rtol=1e-6)


def test_it_finds_the_eigenfunctions_of_the_ring(ring, model):
    # The slowest functions of a walk on a circle are its first harmonics, here in a plane of their own.
    angle, x = ring
    y = model.transform(x)[:, :2]
    harmonics = np.column_stack([np.cos(angle), np.sin(angle)])
    fitted = harmonics @ np.linalg.lstsq(harmonics, y, rcond=None)[0]
    assert ((y - fitted) ** 2).mean() < 0.05


def test_where_the_robot_dwelt_does_not_distort_a_corrected_map():
    # Half of the time at one end of a line: uncorrected, the slowest feature is flat there and zero far from the
    # middle.
    place = np.abs((np.arange(4000) * 0.01) % 2 - 1)
    x = np.concatenate([place, np.full(4000, 1.0)])[:, None] + np.random.default_rng(2).normal(0, 1e-3, (8000, 1))
    x = np.column_stack([x, x**2])
    middle = np.array([[0.5, 0.25]])
    plain, even = (
        KernelSFA(1, reduced_dim=2, prototypes=40, density_corrected=corrected).fit(x).transform(middle)[0, 0]
        for corrected in (False, True)
    )
    assert abs(even) < 0.3 < abs(plain)


def test_a_model_survives_its_arrays(ring, model):
    again = KernelModel.from_arrays(model.to_arrays())
    np.testing.assert_array_equal(again.transform(ring[1]), model.transform(ring[1]))
    assert (again.input_dim, again.output_dim) == (4, 4)
    arrays = model.to_arrays()
    del arrays["width"]
    with pytest.raises(ArrayError, match="KernelModel lacks the stored arrays width"):
        KernelModel.from_arrays(arrays)


def test_edges_decide_what_is_slow(ring):
    x = ring[1]
    edges = Edges.between(np.arange(len(x) - 1), np.arange(1, len(x)))
    with_edges = KernelSFA(2, reduced_dim=3, prototypes=60).fit(x, edges=edges)
    np.testing.assert_allclose(with_edges.deltas_, KernelSFA(2, reduced_dim=3, prototypes=60).fit(x).deltas_, rtol=1e-9)


def test_bad_settings_and_parts_that_do_not_fit(ring, model):
    with pytest.raises(ConfigError, match=r"width=0, .* a kernel needs a positive width"):
        KernelSFA(1, reduced_dim=2, width=0).fit(ring[1])
    with pytest.raises(ArrayError, match=r"needs prototypes \(m, r\) for 3 reduced signals"):
        KernelModel(model.reduce, model.prototypes[:, :2], model.width, model.slow)
