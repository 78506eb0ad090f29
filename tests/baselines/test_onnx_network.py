import numpy as np
import pytest

from andante.baselines.onnx_network import OnnxNetwork
from andante.errors import ConfigError

onnx = pytest.importorskip("onnx", reason="the extra onnx is not installed")
pytest.importorskip("onnxruntime", reason="the extra onnx is not installed")
from onnx import TensorProto, helper  # noqa: E402

FLOAT = TensorProto.FLOAT


def saved(path, nodes, outputs, *, shape=("n", 3, 8, 16), kind=FLOAT, inputs=("picture",)):
    """An ONNX file of some nodes; ``outputs`` are names."""
    graph = helper.make_graph(
        nodes,
        "network",
        [helper.make_tensor_value_info(name, kind, shape) for name in inputs],
        [onnx.ValueInfoProto(name=name) for name in outputs],
    )
    model = helper.make_model(graph, opset_imports=[helper.make_opsetid("", 17)], ir_version=8)
    onnx.save(model, path)
    return path


@pytest.fixture
def backbone(tmp_path):
    """Maps of minus and of absolute grey levels; only the latter are an output."""
    nodes = [helper.make_node("Neg", ["picture"], ["minus"]), helper.make_node("Abs", ["minus"], ["maps"])]
    return saved(tmp_path / "backbone.onnx", nodes, ["maps"])


def test_maps_are_averaged(backbone):
    pictures = np.random.default_rng(0).normal(size=(5, 3, 8, 16)).astype(np.float32)
    network = OnnxNetwork(backbone)
    assert (network.channels, network.input_px, network.output) == (3, (8, 16), "maps")
    np.testing.assert_allclose(network(pictures), np.abs(pictures).mean(axis=(2, 3)), rtol=1e-5)


def test_a_tensor_within_the_graph_can_be_taken(backbone):
    pictures = np.random.default_rng(0).normal(size=(2, 3, 8, 16)).astype(np.float32)
    np.testing.assert_allclose(OnnxNetwork(backbone, "minus")(pictures), -pictures.mean(axis=(2, 3)), atol=1e-6)
    with pytest.raises(ConfigError, match=r"backbone.onnx has no tensor 'head'; its outputs are maps"):
        OnnxNetwork(backbone, "head")


@pytest.mark.parametrize(("axes", "expected"), [([2, 3], (2, 3)), ([3], (2, 8))])
def test_vectors_are_kept_and_tokens_averaged(tmp_path, axes, expected):
    path = saved(
        tmp_path / "a.onnx", [helper.make_node("ReduceMean", ["picture"], ["out"], axes=axes, keepdims=0)], ["out"]
    )
    assert OnnxNetwork(path)(np.zeros((2, 3, 8, 16), np.float32)).shape == expected


def test_a_fixed_batch_and_an_open_size_are_served(tmp_path, backbone):
    node = [helper.make_node("Neg", ["picture"], ["maps"])]
    single = OnnxNetwork(saved(tmp_path / "b.onnx", node, ["maps"], shape=(1, 3, 8, 16)))
    assert single(np.zeros((4, 3, 8, 16), np.float32)).shape == (4, 3)
    open_size = saved(tmp_path / "c.onnx", node, ["maps"], shape=("n", 1, "h", "w"))
    assert OnnxNetwork(open_size, input_px=(24, 32)).input_px == (24, 32)
    with pytest.raises(ConfigError, match=r"c.onnx leaves the size of its pictures open; give input_px"):
        OnnxNetwork(open_size)
    with pytest.raises(ConfigError, match=r"takes pictures of \(8, 16\), not input_px \(24, 32\)"):
        OnnxNetwork(backbone, input_px=(24, 32))


def test_files_that_are_no_networks_are_named(tmp_path):
    with pytest.raises(ConfigError, match=r"there is no network at .*none.onnx; give the path of an ONNX file"):
        OnnxNetwork(tmp_path / "none.onnx")
    (tmp_path / "text.onnx").write_text("not a network")
    with pytest.raises(
        ConfigError, match=r"text.onnx is not an ONNX model that onnxruntime can run: .*export it again"
    ):
        OnnxNetwork(tmp_path / "text.onnx")


@pytest.mark.parametrize("shape", [("n", 8, 16, 3), ("n", 3, 8), ("n", 4, 8, 16), (2, 3, 8, 16)])
def test_inputs_that_are_no_pictures_are_refused(tmp_path, shape):
    path = saved(tmp_path / "d.onnx", [helper.make_node("Neg", ["picture"], ["out"])], ["out"], shape=shape)
    with pytest.raises(ConfigError, match=r"the input of .*d.onnx is tensor\(float\) of shape .*channels first"):
        OnnxNetwork(path)


def test_one_input_of_floats_it_must_be(tmp_path):
    two = [helper.make_node("Add", ["picture", "mask"], ["out"])]
    with pytest.raises(ConfigError, match=r"has 2 inputs \(picture, mask\); an embedding takes one, the picture"):
        OnnxNetwork(saved(tmp_path / "e.onnx", two, ["out"], inputs=("picture", "mask")))
    whole = saved(tmp_path / "f.onnx", [helper.make_node("Neg", ["picture"], ["out"])], ["out"], kind=TensorProto.INT64)
    with pytest.raises(ConfigError, match=r"is tensor\(int64\) of shape"):
        OnnxNetwork(whole)


def test_an_output_that_is_no_embedding_is_refused(tmp_path):
    flat = [helper.make_node("ReduceMean", ["picture"], ["out"], keepdims=0)]
    network = OnnxNetwork(saved(tmp_path / "g.onnx", flat, ["out"]))
    with pytest.raises(ConfigError, match=r"output 'out' of .*g.onnx is float32 of shape \(\); .*name another tensor"):
        network(np.zeros((1, 3, 8, 16), np.float32))
