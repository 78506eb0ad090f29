import sys

import numpy as np
import pytest

from andante.baselines.embedding import Embedding
from andante.baselines.method import Method, StagedLocalizer
from andante.data import Status
from andante.errors import ConfigError, MissingExtraError, RecordingError

onnx = pytest.importorskip("onnx", reason="the extra onnx is not installed")
pytest.importorskip("onnxruntime", reason="the extra onnx is not installed")
from onnx import TensorProto, helper, numpy_helper  # noqa: E402


@pytest.fixture(scope="module")
def network(tmp_path_factory):
    """Random filters and a rectifier: a backbone as it is before it learns."""
    weights = np.random.default_rng(0).normal(size=(32, 3, 5, 5)).astype(np.float32)
    graph = helper.make_graph(
        [
            helper.make_node("Conv", ["picture", "weights"], ["filtered"], strides=[2, 2]),
            helper.make_node("Relu", ["filtered"], ["maps"]),
        ],
        "backbone",
        [helper.make_tensor_value_info("picture", TensorProto.FLOAT, ("n", 3, 12, 30))],
        [helper.make_tensor_value_info("maps", TensorProto.FLOAT, None)],
        [numpy_helper.from_array(weights, "weights")],
    )
    path = tmp_path_factory.mktemp("network") / "backbone.onnx"
    onnx.save(helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8), path)
    return path


@pytest.fixture(scope="module")
def learned(network, garden):
    return Embedding(network).learn([garden.drive(garden.loop(60))])


def test_it_finds_the_frames_of_another_drive(garden, learned):
    drive = garden.drive(garden.loop(30, 0.3))
    estimates = [learned.localizer.localize(drive.load(info)) for info in drive.infos]
    off = [
        np.hypot(e.x_m - i.reference.x_m, e.y_m - i.reference.y_m) for e, i in zip(estimates, drive.infos, strict=True)
    ]
    assert np.median(off) < 0.5
    assert {e.status for e in estimates} == {Status.OK}
    assert {e.heading_rad for e in estimates} == {None}


def test_the_best_alone_is_a_mapped_position(network, garden):
    drive = garden.drive(garden.loop(20))
    localizer = Embedding(network, neighbours=1).learn([drive]).localizer
    estimate = localizer.localize(drive.load(drive.infos[4]))
    truth = drive.infos[4].reference
    assert (estimate.x_m, estimate.y_m) == pytest.approx((truth.x_m, truth.y_m))


def test_vectors_are_the_networks_of_normalised_cuts(network, garden, learned):
    image, method, localizer = garden.panorama((1, 0, 0.5)), Embedding(network), learned.localizer
    cuts = [(image[:, at : at + 30] / 255.0)[None] for at in (0, 30, 60, 90)]
    scaled = [
        np.concatenate([(cut - mean) / std for mean, std in zip(method.mean, method.std, strict=True)]) for cut in cuts
    ]
    vector = localizer.network(np.stack(scaled).astype(np.float32)).mean(axis=0)
    np.testing.assert_allclose(localizer.prepare(image), vector / np.linalg.norm(vector), rtol=1e-4)


def test_two_steps_are_one_and_a_covered_lens_is_lost(garden, learned, network):
    localizer, image = learned.localizer, garden.panorama((1, 2, 0.3))
    assert isinstance(Embedding(network), Method)
    assert isinstance(localizer, StagedLocalizer)
    assert localizer.name == "embedding"
    assert localizer.localize(image) == localizer.locate(localizer.prepare(image))
    lost = localizer.localize(np.zeros((12, 120), np.uint8))
    assert lost.status == Status.LOST
    assert "shows nothing" in lost.reason


def test_what_it_cost_is_told(network, learned):
    assert learned.bytes == 60 * (32 * 4 + 2 * 8) + network.stat().st_size
    assert learned.notes == ("32 numbers a frame from backbone.onnx, maps",)
    assert learned.preprocessing_s > 0


def test_what_cannot_be_is_refused(network, garden, monkeypatch):
    with pytest.raises(RecordingError, match=r"embedding needs at least one recording"):
        Embedding(network).learn([])
    with pytest.raises(ConfigError, match=r"cuts and neighbours must be at least 1, got 0 and 5"):
        Embedding(network, cuts=0)
    with pytest.raises(ConfigError, match=r"std must be three positive numbers"):
        Embedding(network, std=(1, 0, 1))
    monkeypatch.setitem(sys.modules, "onnxruntime", None)
    with pytest.raises(MissingExtraError, match=r"onnxruntime is not installed; .*andante\[onnx\]"):
        Embedding(network).learn([garden.drive(garden.loop(10))])
