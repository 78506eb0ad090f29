"""The file: what it says of itself, and what happens where it cannot be made."""

import builtins
import dataclasses
import json

import numpy as np
import onnx
import pytest

from andante.errors import ConfigError, ImageError, MapError, MissingExtraError
from andante.export import export_onnx
from andante.export.graph import OPSET


def test_checked_model_of_standard_operations(small_map, running):
    exported = running(small_map)
    model = onnx.load(exported.path)
    onnx.checker.check_model(model, full_check=True)
    assert [(one.domain, one.version) for one in model.opset_import] == [("", OPSET)]
    assert {node.domain for node in model.graph.node} == {""}
    assert exported.exported.bytes == exported.path.stat().st_size
    declared = {
        one.name: tuple(side.dim_value for side in one.type.tensor_type.shape.dim) for one in model.graph.output
    }
    assert declared == exported.exported.outputs
    assert exported.exported.outputs == {
        "slow": (16,), "xy": (2,), "covariance": (2, 2), "radius": (1,), "heading_rad": (1,),
        "heading_deviation_rad": (1,), "likeness": (1,), "agreement": (1,), "status": (1,),
    }  # fmt: skip


def test_arithmetic_is_in_single_precision(small_map, running):
    model = onnx.shape_inference.infer_shapes(onnx.load(running(small_map).path))
    kinds = {one.type.tensor_type.elem_type for one in model.graph.value_info}
    assert onnx.TensorProto.DOUBLE not in kinds
    assert all(one.data_type != onnx.TensorProto.DOUBLE for one in model.graph.initializer)


def test_metadata(small_map, running):
    metadata = running(small_map).metadata
    assert (metadata["unit"], metadata["name"]) == ("m", small_map.name)
    assert json.loads(metadata["statuses"]) == ["ok", "degraded", "lost", "off_map"]
    assert json.loads(metadata["image_px"]) == [120, 12]
    assert json.loads(metadata["radius_holds"]) == 0.9
    assert json.loads(metadata["tells_heading"]) is True
    assert [one["content_hash"] for one in json.loads(metadata["provenance"])] == [
        source.content_hash for source in small_map.sources
    ]
    assert len(metadata["provenance_hash"]) == 64


def test_same_map_same_bytes(small_map, tmp_path):
    for name in ("a.onnx", "b.onnx"):
        export_onnx(small_map, tmp_path / name)
    assert (tmp_path / "a.onnx").read_bytes() == (tmp_path / "b.onnx").read_bytes()


def test_provenance_hash_tells_maps_apart(small_map, running):
    first, *others = small_map.sources
    other = dataclasses.replace(small_map, sources=(dataclasses.replace(first, content_hash="0" * 64), *others))
    assert running(other).metadata["provenance_hash"] != running(small_map).metadata["provenance_hash"]


def test_smaller_than_the_map_with_its_memory(small_map, running, tmp_path):
    assert running(small_map).exported.bytes < small_map.save(tmp_path / "m.andante")


def test_without_onnx(small_map, tmp_path, monkeypatch):
    real = builtins.__import__

    def refuse(name, *rest, **more):
        if name.split(".")[0] == "onnx":
            raise ImportError(name)
        return real(name, *rest, **more)

    monkeypatch.setattr(builtins, "__import__", refuse)
    with pytest.raises(
        MissingExtraError, match=r"onnx is not installed; install it with: pip install 'andante\[onnx\]'"
    ):
        export_onnx(small_map, tmp_path / "m.onnx")


def test_a_place_that_cannot_be_written(small_map, tmp_path):
    with pytest.raises(MapError, match=r"ONNX file .*m\.onnx cannot be written: No such file or directory; choose"):
        export_onnx(small_map, tmp_path / "no" / "m.onnx")


def test_a_size_that_does_not_fit(small_map, tmp_path):
    with pytest.raises(ImageError, match="120x100 px does not fit the camera, whose images are 120x12 px"):
        export_onnx(small_map, tmp_path / "m.onnx", image_shape=(100, 120))
    assert not list(tmp_path.iterdir())


def test_a_readout_of_another_house(small_map, tmp_path):
    class Oracle:
        def locate(self, slow):
            return np.zeros(2)

    with pytest.raises(ConfigError, match="readout Oracle cannot be exported; local, polynomial and gaussian-process"):
        export_onnx(dataclasses.replace(small_map, readout=Oracle()), tmp_path / "m.onnx")
