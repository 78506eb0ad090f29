"""The estimator: episodes, chunks, and scikit-learn's conventions."""

import pickle
import subprocess
import sys
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from andante.data import Edges
from andante.errors import ArrayError, ConfigError, LearningError, NotFittedError
from andante.sfa import LinearSFA


def series(seed, n=200, dim=4):
    rng = np.random.default_rng(seed)
    t = np.arange(n)[:, None]
    sources = np.sin(t * 0.03 * 2.0 ** np.arange(dim)) + 0.05 * rng.normal(size=(n, dim))
    return sources @ rng.normal(size=(dim, dim))


def assert_same_features(a, b):
    np.testing.assert_allclose(a.deltas_, b.deltas_, rtol=1e-9)
    np.testing.assert_allclose(a.weights_, b.weights_, rtol=1e-6, atol=1e-7)
    np.testing.assert_allclose(a.mean_, b.mean_, atol=1e-12)


def test_default_edges_are_time():
    x = series(0)
    edges = Edges.between(np.arange(199), np.arange(1, 200))
    assert_same_features(LinearSFA(3).fit(x), LinearSFA(3).fit(x, edges=edges))


def test_no_difference_crosses_episodes():
    episodes = [series(1), series(1)[50:] + 100, series(1)[:1]]
    ends = np.cumsum([len(episode) for episode in episodes])
    inside = np.setdiff1d(np.arange(ends[-1] - 1), ends - 1)
    edges = Edges.between(inside, inside + 1)
    assert_same_features(LinearSFA().fit(episodes), LinearSFA().fit(np.concatenate(episodes), edges=edges))
    assert_same_features(LinearSFA().fit(episodes), LinearSFA().fit(episodes, edges=edges))
    assert LinearSFA(2).fit_transform(episodes).shape == (ends[-1], 2)


@settings(max_examples=25, deadline=None)
@given(cuts=st.lists(st.integers(1, 199), max_size=8))
def test_any_chunking_is_one_fit(cuts):
    x = series(2)
    chunked = LinearSFA(3)
    for chunk in np.split(x, sorted(set(cuts))):
        chunked.partial_fit(chunk)
    assert_same_features(chunked, LinearSFA(3).fit(x))


def test_partial_fit_starts_episodes_where_told_and_behind_fit():
    a, b = series(3), series(3) + 5
    together = LinearSFA().fit([a, b])
    assert_same_features(LinearSFA().partial_fit(a).partial_fit(b, new_episode=True), together)
    assert_same_features(LinearSFA().fit(a).partial_fit(b), together)
    assert_same_features(LinearSFA().fit(b).fit(a), LinearSFA().fit(a))


def test_partial_fit_goes_on_after_transform_and_waits_for_enough_data():
    x, slow = series(4), LinearSFA(4)
    slow.partial_fit(x[:3])
    with pytest.raises(NotFittedError, match=r"cannot learn 4 slow features: 3 samples"):
        slow.transform(x)
    slow.partial_fit(x[3:20]).transform(x)
    assert_same_features(slow.partial_fit(x[20:]), LinearSFA(4).fit(x))


def test_a_chunk_is_not_kept_by_reference():
    x, slow = series(5), LinearSFA(2)
    buffer = x[:100].copy()
    slow.partial_fit(buffer)
    buffer[:] = 0
    assert_same_features(slow.partial_fit(x[100:]), LinearSFA(2).fit(x))


def test_transform_never_learns():
    x, slow = series(6), LinearSFA(2)
    with pytest.raises(NotFittedError, match="this LinearSFA has not learnt yet: call fit first"):
        slow.transform(x)
    before = pickle.dumps(slow.fit(x))
    slow.transform(x[:50] * 3)
    assert pickle.dumps(slow) == before


def test_a_failed_fit_leaves_no_old_model_behind():
    slow = LinearSFA(2).fit(series(7))
    with pytest.raises(LearningError, match="none of the 4 signals varies"):
        slow.fit(np.ones((10, 4)))
    assert not hasattr(slow, "weights_")


def test_attributes_and_names():
    slow = LinearSFA(2, ridge=1e-3).fit(series(8))
    assert (slow.n_features_in_, slow.rank_, slow.weights_.shape, slow.deltas_.shape) == (4, 4, (4, 2), (2,))
    assert slow.get_feature_names_out().tolist() == ["linearsfa0", "linearsfa1"]
    assert repr(slow) == "LinearSFA(n_components=2, ridge=0.001, rank_tolerance=1e-10)"
    with pytest.raises(ConfigError, match="LinearSFA has no setting 'rigde'; it has n_components, ridge"):
        slow.set_params(rigde=1)


def test_faults_are_named():
    slow = LinearSFA(2).fit(series(9))
    for wrong, message in [
        (np.zeros((3, 5)), "X has 5 features, but LinearSFA is expecting 4 features"),
        (np.zeros(4), "Reshape your data"),
        (np.full((3, 4), np.inf), r"NaN or infinity in 3 of 3 rows, first in row 0"),
        (np.array([["a", "b", "c", "d"]]), "samples have to be numbers"),
    ]:
        with pytest.raises(ArrayError, match=message):
            slow.transform(wrong)
    with pytest.raises(ArrayError, match="X has 3 features, but a fit on several episodes is expecting 4"):
        LinearSFA().fit([np.zeros((3, 4)), np.zeros((3, 3))])
    with pytest.raises(ArrayError, match="n_samples=1"):
        LinearSFA().fit(np.zeros((1, 4)))
    with pytest.raises(ArrayError, match="X has 3 features"):
        slow.partial_fit(np.zeros((3, 3)))


def test_import_leaves_scikit_learn_alone():
    script = "import sys, andante.sfa; sys.exit('sklearn' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", script], check=False).returncode == 0


@pytest.mark.parametrize("settings", [{}, {"n_components": 1, "ridge": 0.01}], ids=str)
def test_scikit_learn_accepts_the_estimator(settings):
    checks = pytest.importorskip("sklearn.utils.estimator_checks")
    with warnings.catch_warnings():
        # Not inheriting BaseEstimator is on purpose: importing scikit-learn takes seconds.
        warnings.filterwarnings("ignore", message=".*does not inherit from.*BaseEstimator", category=UserWarning)
        checks.check_estimator(LinearSFA(**settings), on_skip=None)


def test_works_in_a_pipeline_and_not_fitted_is_theirs_too():
    pytest.importorskip("sklearn")
    from sklearn.base import clone
    from sklearn.exceptions import NotFittedError as TheirNotFittedError
    from sklearn.pipeline import make_pipeline
    from sklearn.preprocessing import StandardScaler

    x = series(10)
    pipeline = clone(make_pipeline(StandardScaler(), LinearSFA(2)))
    np.testing.assert_allclose(pipeline.fit_transform(x).var(axis=0), 1)
    with pytest.raises(TheirNotFittedError, match="call fit first") as caught:
        LinearSFA().transform(x)
    assert isinstance(caught.value, NotFittedError)
