"""Graphs that run: whole exported maps, and pieces of them."""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import onnxruntime
import pytest

from andante.export import ExportedMap, export_onnx
from andante.export.graph import Graph
from andante.mapping import MapConfig, SlowMap, build_map


def session_of(model: bytes) -> onnxruntime.InferenceSession:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    return onnxruntime.InferenceSession(model, options, providers=["CPUExecutionProvider"])


@dataclass(frozen=True)
class Running:
    """An exported map in onnxruntime."""

    exported: ExportedMap
    path: Path
    session: onnxruntime.InferenceSession

    def __call__(self, image: np.ndarray) -> dict[str, np.ndarray]:
        return dict(zip(self.exported.outputs, self.session.run(None, {"image": image}), strict=True))

    @property
    def metadata(self) -> dict[str, str]:
        return self.session.get_modelmeta().custom_metadata_map


@pytest.fixture(scope="session")
def running(tmp_path_factory) -> Callable[..., Running]:
    """``running(slowmap, image_shape=...)`` is the exported map, ready for images."""

    def start(slowmap: SlowMap, **options) -> Running:
        path = tmp_path_factory.mktemp("onnx") / "map.onnx"
        exported = export_onnx(slowmap, path, **options)
        return Running(exported, path, session_of(path.read_bytes()))

    return start


@pytest.fixture(scope="session")
def run_piece() -> Callable[..., np.ndarray]:
    """``run_piece(add, image)``: what ``add(graph, name)`` makes of the (height, width) uint8 image, of any shape."""

    def run(add: Callable[[Graph, str], str], image: np.ndarray, shape: tuple[int, ...]) -> np.ndarray:
        graph = Graph()
        graph.output("result", add(graph, graph.image("image", image.shape)), shape)
        return session_of(graph.model("piece", "0", {}).SerializeToString()).run(None, {"image": image})[0]

    return run


@pytest.fixture(scope="session")
def drives(garden):
    """``drives(fisheye)``: two drives to learn from, long enough for quadratic models, and one in another light."""

    @functools.cache
    def make(fisheye: bool):
        monday = garden.drive(garden.loop(110), fisheye=fisheye)
        tuesday = garden.drive(garden.loop(110, 0.4, 3.05), name="tuesday", fisheye=fisheye, gain=0.7, offset=20)
        friday = garden.drive(garden.loop(37, 0.2, 3.02), name="friday", fisheye=fisheye, gain=1.15, offset=-25)
        return monday, tuesday, friday

    return make


@pytest.fixture(scope="session")
def map_of(drives):
    """``map_of(fisheye=..., readout=..., expansion=...)``: a map of the first two drives."""

    def build(
        *, fisheye: bool = False, readout: str | dict = "local", expansion: str = "linear", **sections
    ) -> SlowMap:
        kind = readout if isinstance(readout, dict) else {"kind": readout}
        values = {
            "learning": {"expansion": expansion, "reduced_dim": 8, "slow_features": 16},
            "readout": kind,
            "off_path": {"enabled": False},
            **sections,
        }
        return build_map(drives(fisheye)[:2], MapConfig().with_values(values))

    return build


@pytest.fixture(scope="session")
def small_map(map_of) -> SlowMap:
    return map_of()
