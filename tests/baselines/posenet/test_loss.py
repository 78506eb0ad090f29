import math

import pytest

torch = pytest.importorskip("torch", reason="the extra torch is not installed")

from andante.baselines.posenet.loss import GeometricLoss  # noqa: E402


def test_it_is_the_formula_of_the_paper():
    position, truth = torch.tensor([[1.0, 2.0], [0.0, -1.0]]), torch.tensor([[0.5, 2.5], [0.0, 1.0]])
    vectors, heading = torch.tensor([[0.0, 3.0], [-2.0, 0.0]]), torch.tensor([0.0, math.pi])
    sx, sq = 0.3, -1.7
    # One picture is a quarter turn off, its vector (0, 1) instead of (1, 0); the other is right.
    of_position, of_heading = (math.sqrt(0.5) + 2.0) / 2, math.sqrt(2.0) / 2
    expected = of_position * math.exp(-sx) + sx + of_heading * math.exp(-sq) + sq
    assert GeometricLoss(sx, sq)(position, vectors, truth, heading).item() == pytest.approx(expected, abs=1e-6)


def test_the_best_uncertainties_are_the_errors_themselves():
    loss = GeometricLoss(math.log(1.5), math.log(0.25))
    position, vectors = torch.tensor([[0.9, 1.2]]), torch.tensor([[1.0, 0.0]])
    # Unit vectors are a quarter apart where the angle between them is 2 asin(1/8).
    loss(position, vectors, torch.zeros(1, 2), torch.tensor([2 * math.asin(0.125)])).backward()
    assert loss.s_position.grad.item() == pytest.approx(0, abs=1e-6)
    assert loss.s_heading.grad.item() == pytest.approx(0, abs=1e-5)


def test_unknown_headings_are_left_out():
    loss = GeometricLoss()
    position, vectors = torch.zeros(3, 2), torch.tensor([[1.0, 0.0], [0.0, 1.0], [5.0, 5.0]])
    some = loss(position, vectors, position, torch.tensor([0.0, math.nan, math.nan]))
    assert some.item() == pytest.approx(-3.0, abs=1e-6)
    none = loss(position, vectors, position, torch.full((3,), math.nan))
    assert none.item() == 0
    none.backward()
    assert loss.s_heading.grad is None


def test_half_a_turn_off_is_no_place_to_rest():
    """In the L1 norm it would be, along the axes."""
    truth, position = torch.tensor([math.pi]), torch.zeros(1, 2)
    opposite, less = (
        GeometricLoss()(position, torch.tensor([[math.cos(a), math.sin(a)]]), position, truth) for a in (0.0, 0.1)
    )
    assert less < opposite
