import numpy as np
import pytest

from andante.export.linear_systems import add_solution


@pytest.mark.parametrize(("dim", "condition"), [(1, 1), (2, 10), (8, 10), (8, 1e4)])
def test_solution(dim, condition, run_piece):
    rng = np.random.default_rng(dim)
    for scale in (1e-3, 1.0, 1e6):
        turn = np.linalg.qr(rng.normal(size=(dim, dim)))[0]
        matrix = scale * turn @ np.diag(np.geomspace(1, 1 / condition, dim)) @ turn.T
        sides = rng.normal(size=(dim, 2))
        expected = np.linalg.solve(matrix, sides)
        found = run_piece(
            # The graph needs an input, which does not matter.
            lambda graph, _, matrix=matrix, sides=sides: add_solution(
                graph, graph("Identity", matrix), graph("Identity", sides), dim
            ),
            np.zeros((1, 1), np.uint8),
            (dim, 2),
        )
        assert np.abs(found - expected).max() < 3e-7 * condition * np.abs(expected).max()
