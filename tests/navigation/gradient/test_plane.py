import numpy as np
import pytest

from andante.navigation.plane import EstimationMatrix, plane_gradient, unit


def test_the_gradient_of_a_plane():
    xy = np.random.default_rng(0).uniform(-2, 2, (30, 2))
    rows = np.column_stack([xy, 3.0 + xy @ [0.4, -1.2]])
    np.testing.assert_allclose(plane_gradient(rows), [0.4, -1.2], atol=1e-12)


def test_three_points_decide():
    rows = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 1.5], [0.0, 1.0, 0.0]])
    np.testing.assert_allclose(plane_gradient(rows), [0.5, -1.0], atol=1e-12)


def test_noise_averages_out():
    rng = np.random.default_rng(1)
    xy = rng.uniform(-2, 2, (3000, 2))
    rows = np.column_stack([xy, xy @ [0.3, 0.2] + rng.normal(0, 0.05, len(xy))])
    np.testing.assert_allclose(plane_gradient(rows), [0.3, 0.2], atol=0.01)


def test_an_upright_plane_has_no_direction():
    rows = np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [1.0, 0.0, 1.0]])
    np.testing.assert_array_equal(unit(plane_gradient(rows)), [0.0, 0.0])


def test_unit_vectors():
    np.testing.assert_allclose(unit(np.array([3.0, -4.0])), [0.6, -0.8])
    for nothing in ([0.0, 0.0], [np.inf, 1.0], [np.nan, 0.0]):
        np.testing.assert_array_equal(unit(np.array(nothing)), [0.0, 0.0])


@pytest.mark.parametrize(("window_m", "kept"), [(None, 21), (0.5, 6), (1.0, 11)])
def test_the_window_is_a_length_of_way(window_m, kept):
    matrix = EstimationMatrix(window_m)
    for step in range(21):
        matrix.append(0.0999 * step, 0.0, float(step))
    assert len(matrix) == kept
    np.testing.assert_allclose(matrix.rows[-1], [1.998, 0.0, 20.0])
