import numpy as np
import pytest

from andante.baselines import RidgeRegression
from andante.baselines.ridge import _RIDGES, _leave_one_out, _left_singular


def solved(features, xy, ridge):
    """Ridge regression with a free constant, by its normal equations."""
    mean, offset = features.mean(axis=0), xy.mean(axis=0)
    x = features - mean
    weights = np.linalg.solve(x.T @ x + ridge * np.eye(x.shape[1]), x.T @ (xy - offset))
    return mean, weights, offset


@pytest.fixture(params=[(12, 30), (40, 7)], ids=["wide", "tall"])
def data(request):
    rng = np.random.default_rng(1)
    n, dim = request.param
    features = rng.normal(size=(n, dim)).astype(np.float32)
    xy = features[:, :2] @ rng.normal(size=(2, 2)) + rng.normal(0, 0.3, (n, 2)) + [10, -4]
    return features, xy


def test_it_solves_the_normal_equations(data):
    features, xy = data
    fitted = RidgeRegression.fit(None, "m", features, xy)
    mean, weights, offset = solved(features.astype(np.float64), xy, fitted.ridge)
    np.testing.assert_allclose(fitted.weights, weights, atol=1e-8)
    query = np.full(features.shape[1], 0.5, np.float32)
    np.testing.assert_allclose(fitted.position(query), (query - mean) @ weights + offset, atol=1e-6)


@pytest.mark.parametrize("ridge", [0.1, 10.0])
def test_the_closed_form_leaves_frames_out(data, ridge):
    features, xy = data[0].astype(np.float64), data[1]
    # The closed form keeps the centre of all frames fixed but counts its leverage; learning anew moves it, which is
    # the same for a constant that is learnt along, without a ridge of its own.
    with_constant = np.column_stack([features - features.mean(axis=0), np.ones(len(xy))])
    penalty = ridge * np.diag([1.0] * features.shape[1] + [0.0])
    errors = []
    for out in range(len(xy)):
        kept = np.arange(len(xy)) != out
        x = with_constant[kept]
        weights = np.linalg.solve(x.T @ x + penalty, x.T @ xy[kept])
        errors.append(xy[out] - with_constant[out] @ weights)
    targets = xy - xy.mean(axis=0)
    left, squared = _left_singular(features - features.mean(axis=0))
    closed = _leave_one_out(left, squared / (squared + ridge), left.T @ targets, targets)
    assert closed == pytest.approx(float(np.square(errors).mean()), rel=1e-8)


def test_noise_asks_for_a_larger_ridge_than_a_clean_line():
    rng = np.random.default_rng(2)
    features = rng.normal(size=(60, 20)).astype(np.float32)
    clean, noise = np.column_stack([features[:, 0], features[:, 1]]), rng.normal(size=(60, 2))
    small, large = (RidgeRegression.fit(None, "m", features, xy).ridge for xy in (clean, noise))
    assert small < 1e-2 < large
    scale = np.square(features - features.mean(axis=0)).sum() / 60
    assert small == pytest.approx(_RIDGES[0] * scale, rel=1e-5)
