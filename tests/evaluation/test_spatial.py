import sys

import numpy as np
import pytest
from sklearn.decomposition import FastICA

from andante.data import CameraSpec, Pose2D
from andante.errors import ArrayError, LearningError, MissingExtraError, RecordingError
from andante.evaluation import SpatialMaps, axis_correlations, slow_feature_maps, sparse_code, spatial_maps
from andante.recordings import MemoryRecording


def grid(columns=6, rows=4, step=0.5):
    x, y = np.meshgrid(np.arange(columns) * step - 1, np.arange(rows) * step)
    return np.column_stack([x.ravel(), y.ravel()])


def test_values_land_on_their_places():
    xy = grid()
    values = np.column_stack([xy[:, 0], xy[:, 1], np.arange(len(xy))])
    order = np.random.default_rng(0).permutation(len(xy))
    maps = spatial_maps(xy[order], values[order])
    assert maps.values.shape == (3, 4, 6)
    np.testing.assert_allclose(maps.values[0], np.tile(maps.x_m, (4, 1)))
    np.testing.assert_allclose(maps.values[1], np.tile(maps.y_m[:, None], (1, 6)))
    places, found = maps.places
    np.testing.assert_allclose(places, found[:, :2])


def test_places_where_nobody_was_are_blank_and_several_headings_average():
    xy = np.concatenate([grid()[1:], grid()[5:6]])
    values = np.ones((len(xy), 1))
    values[-1] = 3.0
    maps = spatial_maps(xy, values)
    assert np.isnan(maps.values[0, 0, 0])
    assert np.isnan(maps.values).sum() == 1
    assert maps.values[0, 0, 5] == 2.0
    assert len(maps.places[0]) == 23


def test_positions_that_form_no_grid_are_refused():
    xy = np.random.default_rng(0).normal(size=(40, 2))
    with pytest.raises(RecordingError, match=r"40 positions on 40 x 40 lines form no grid; .*--trajectory grid"):
        spatial_maps(xy, np.zeros((40, 1)))
    with pytest.raises(RecordingError, match="form no grid"):
        spatial_maps(np.column_stack([np.arange(5.0), np.zeros(5)]), np.zeros((5, 1)))
    with pytest.raises(ArrayError, match=r"positions \(n, 2\) and values \(n, k\)"):
        spatial_maps(grid(), np.zeros((3, 1)))


@pytest.mark.parametrize("turn", [0.0, 0.4, 2.0])
def test_turned_axes_are_found(turn):
    xy = grid(9, 9)
    first = xy @ [np.cos(turn), np.sin(turn)]
    second = xy @ [-np.sin(turn), np.cos(turn)]
    found = axis_correlations(xy, -first, second)
    assert found[:2] == pytest.approx((1.0, 1.0), abs=1e-3)
    assert np.cos(found[2] - turn) ** 2 == pytest.approx(1.0, abs=1e-3)


def test_features_that_say_nothing_correlate_with_nothing():
    noise = np.random.default_rng(0).normal(size=(2, 400))
    assert max(axis_correlations(grid(20, 20), *noise)[:2]) < 0.2
    assert axis_correlations(grid(), np.ones(24), np.ones(24))[:2] == (0.0, 0.0)


def test_slow_features_of_a_recording_on_a_grid(slowmap, make_drive):
    images = [make_drive(1).load(info) for info in make_drive(1).infos[:24]]
    poses = [Pose2D(*place) for place in grid().tolist()]
    recording = MemoryRecording(images, np.arange(24.0), CameraSpec(model="panorama"), reference=poses)
    seen = []
    maps = slow_feature_maps(slowmap, recording, 3, progress=lambda *step: seen.append(step))
    assert isinstance(maps, SpatialMaps)
    np.testing.assert_allclose(maps.values[:, 1, 2], slowmap.slow_features(images[8])[:3])
    assert seen[-1] == (recording.name, 24, 24)
    with pytest.raises(RecordingError, match="has frames without reference poses"):
        slow_feature_maps(slowmap, make_drive(1, truth=0.5), 3)


def test_sparse_units_find_sources_that_fire_rarely():
    rng = np.random.default_rng(0)
    sources = rng.exponential(size=(3000, 3)) ** 2
    mixed = (sources - sources.mean(axis=0)) @ rng.normal(size=(3, 3))
    units = sparse_code(mixed, 3).transform(mixed)
    likeness = np.corrcoef(units.T, sources.T)[:3, 3:]
    assert (likeness.max(axis=1) > 0.95).all()
    assert sorted(likeness.argmax(axis=1)) == [0, 1, 2]


def test_sparse_code_says_what_it_needs(monkeypatch):
    with pytest.raises(LearningError, match="4 sparse units need at least as many slow features"):
        sparse_code(np.zeros((10, 3)), 4)
    hasty = lambda units, **more: FastICA(units, **{**more, "max_iter": 1})  # noqa: E731
    with monkeypatch.context() as patched:
        patched.setattr("sklearn.decomposition.FastICA", hasty)
        with pytest.raises(LearningError, match="does not settle; use fewer units or more frames"):
            sparse_code(np.random.default_rng(0).normal(size=(30, 20)), 20)
    monkeypatch.setitem(sys.modules, "sklearn.decomposition", None)
    with pytest.raises(MissingExtraError, match=r"scikit-learn is not installed; .*'andante\[sklearn\]'"):
        sparse_code(np.zeros((10, 3)), 2)
