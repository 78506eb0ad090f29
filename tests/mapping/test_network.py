"""The network of a map: which pictures it needs, how it is stored, and that nothing else is read."""

import dataclasses
import json
import struct

import numpy as np
import pytest
from safetensors.numpy import load, save

from andante.data import CameraSpec
from andante.errors import ConfigError, MapError
from andante.mapping import FrontEnd, MapConfig, SlowMap, build_map
from andante.mapping.config import FeatureConfig, NetworkConfig, PanoramaConfig
from andante.mapping.network import layers_of, least_shape, require_room, same_network
from andante.sfa import PANORAMA_LAYERS, Layer, grids_of

SMALL = {
    "features": {"kind": "pixels"},
    "network": {
        "layers": [
            {"output_dim": 6, "field": (12, 6), "stride": (6, 3), "reduced_dim": 8},
            {"output_dim": 8, "field": (4, 3), "stride": (2, 1), "reduced_dim": 10},
            {"output_dim": 6, "reduced_dim": 12},
        ],
        "depth": 2,
    },
}
READOUTS = ("local", "polynomial", "gaussian-process")


@pytest.fixture(scope="module")
def config() -> MapConfig:
    return MapConfig().with_values(SMALL)


@pytest.fixture(scope="module")
def maps(days, config) -> dict[str, SlowMap]:
    readouts = {kind: {"readout": {"kind": kind, "inputs": 4}} for kind in READOUTS}
    return {kind: build_map(days, config.with_values(values)) for kind, values in readouts.items()}


@pytest.fixture(scope="module")
def stored(maps, tmp_path_factory) -> tuple[dict, dict[str, np.ndarray]]:
    """Header and arrays of a map file."""
    path = tmp_path_factory.mktemp("network") / "m.andante"
    maps["local"].save(path)
    data = path.read_bytes()
    (length,) = struct.unpack("<Q", data[:8])
    return json.loads(json.loads(data[8 : 8 + length])["__metadata__"]["andante"]), load(data)


def pixels(camera: CameraSpec, shape: tuple[int, int]) -> FrontEnd:
    return FrontEnd(camera, shape, PanoramaConfig(), FeatureConfig(kind="pixels"))


@pytest.mark.parametrize("kind", READOUTS)
def test_a_loaded_map_is_the_saved_one(kind, maps, garden, tmp_path):
    built = maps[kind]
    built.save(tmp_path / "m.andante")
    loaded = SlowMap.load(tmp_path / "m.andante", with_memory=True)
    assert same_network(loaded.front_end.network, built.front_end.network)
    assert loaded.describe() == built.describe()
    for pose in garden.loop(9, 0.5):
        picture = garden.panorama(pose)
        np.testing.assert_array_equal(loaded.front_end.features(picture), built.front_end.features(picture))
        assert loaded.localize(picture).as_dict() == built.localize(picture).as_dict()
    loaded.save(tmp_path / "again.andante")
    assert (tmp_path / "again.andante").read_bytes() == (tmp_path / "m.andante").read_bytes()


def test_what_is_in_the_file(stored, maps):
    header, arrays = stored
    assert arrays["network.1.slow.weights"].shape == (10 + 55, 8)
    sections = {name: array for name, array in arrays.items() if name.startswith("network.")}
    assert len(sections) == 2 * 2 * 5
    assert {str(array.dtype) for name, array in sections.items() if "weights" in name or "mean" in name} == {"float32"}
    assert header["config"]["network"]["wrap"] is True
    assert header["asked"]["network"]["wrap"] is None
    assert (header["config"]["panorama"]["width_px"], header["asked"]["panorama"]["width_px"]) == (600, None)
    assert maps["local"].describe()["features"] == "pixels"
    assert not maps["local"].heading_invariant


def test_maps_without_a_network_have_no_such_section(slowmap, tmp_path):
    slowmap.save(tmp_path / "m.andante")
    assert not [name for name in load((tmp_path / "m.andante").read_bytes()) if name.startswith("network")]


def changed(name: str, change) -> dict:
    return {"arrays": {name: change}}


TAMPERED = [
    (
        changed("network.0.reduce.weights", lambda a: a[:-1]),
        r"network\.0\.reduce\.weights is float32 of shape \(71, 8\)",
    ),
    (changed("network.0.slow.mean", lambda a: a.astype(np.float64)), r"network\.0\.slow\.mean is float64 of shape"),
    (changed("network.1.slow.rank", lambda a: np.repeat(a, 2)), r"network\.1\.slow\.rank is int64 of shape \(2,\)"),
    (changed("network.1.slow.weights", lambda a: np.full_like(a, np.nan)), "holds values that are not finite"),
    (changed("network.1.slow.weights", lambda a: None), r"network\.1\.slow\.weights is missing or too much"),
    (
        {"more": {"network.2.slow.weights": np.zeros((2, 2), np.float32)}},
        r"network\.2\.slow\.weights is missing or too",
    ),
    (changed("network.0.slow.weights", lambda a: np.full_like(a, 3e38)), "holds numbers beyond 1e"),
    ({"network": {"deviation_floor": 1e200}}, r"config\.network\.deviation_floor is wrong"),
    ({"network": {"depth": 1}}, r"network\.1\.reduce\.deltas is missing or too much"),
    ({"network": {"depth": 0}}, r"config\.network\.depth is wrong"),
    ({"network": {"wrap": False}}, "expected float32"),
    ({"network": {"layers": []}}, r"config\.network\.layers is wrong"),
    ({"network": {"layers": [{"output_dim": 10**9, "reduced_dim": 2}]}}, "reduced signals have only 5 terms"),
    ({"panorama": {"width_px": 60}}, "expected float32"),
    ({"panorama": {"width_px": 8}}, "layer 1 has receptive fields of 12x6 on a map of 8x12"),
]


@pytest.mark.parametrize(("fault", "message"), TAMPERED)
def test_tampered_networks_are_refused(stored, tmp_path, fault, message):
    header, arrays = json.loads(json.dumps(stored[0])), dict(stored[1])
    for section in ("network", "panorama"):
        header["config"][section] |= fault.get(section, {})
    arrays |= {name: change(arrays[name]) for name, change in fault.get("arrays", {}).items()} | fault.get("more", {})
    contiguous = {name: np.ascontiguousarray(array) for name, array in arrays.items() if array is not None}
    path = tmp_path / "bad.andante"
    path.write_bytes(save(contiguous, metadata={"andante": json.dumps(header)}))
    with pytest.raises(MapError, match=message) as caught:
        SlowMap.load(path)
    assert "\n" not in str(caught.value)


def test_a_file_whose_network_is_gone(stored, tmp_path):
    rest = {name: array for name, array in stored[1].items() if not name.startswith("network.")}
    path = tmp_path / "bad.andante"
    path.write_bytes(save(rest, metadata={"andante": json.dumps(stored[0])}))
    with pytest.raises(MapError, match="features of kind pixels, but no network that makes them; make it again"):
        SlowMap.load(path)


def test_layers_come_from_the_table_unless_declared(config):
    plain = NetworkConfig(depth=9, residual=0.0)
    assert layers_of(plain) == PANORAMA_LAYERS
    assert [layer.residual for layer in layers_of(NetworkConfig(residual=0.5))] == [0.5] * NetworkConfig().depth
    first, second = layers_of(config.network)
    assert first == Layer(6, (12, 6), (6, 3), 8, residual=config.network.residual)
    assert second.output_dim == 8


@pytest.mark.parametrize("wrap", [True, False])
@pytest.mark.parametrize(
    "layers",
    [
        PANORAMA_LAYERS,
        PANORAMA_LAYERS[:1],
        (Layer(3, (3, 2), (5, 4), 4), Layer(2, (2, 3), (3, 1), 4), Layer(2, (4, 1), (1, 1), 4)),
        (Layer(3, (4, 4), (1, 1), 4), Layer(2, reduced_dim=2)),
    ],
)
def test_the_least_picture_has_room_and_a_smaller_one_has_not(layers, wrap):
    height, width = least_shape(layers, wrap=wrap)
    assert all(grid.positions >= 1 for grid in grids_of(layers, (height, width), wrap=wrap))
    for smaller in ((height - 1, width), (height, width - 1)):
        with pytest.raises(ConfigError):
            grids_of(layers, smaller, wrap=wrap)


def test_pictures_that_are_too_small_are_refused_with_a_way_out():
    perspective = pixels(CameraSpec(model="perspective"), (32, 64))
    with pytest.raises(ConfigError, match=r"at least 96x60 px, this camera gives 64x32; take features of kind flat"):
        require_room(NetworkConfig(depth=3), perspective)
    require_room(NetworkConfig(), perspective)
    require_room(NetworkConfig(depth=3), pixels(CameraSpec(model="perspective"), (60, 96)))
    require_room(NetworkConfig(), pixels(CameraSpec(model="panorama"), (60, 600)))


def test_panoramas_for_pixels_are_as_large_as_those_of_the_thesis():
    fisheye = CameraSpec(centre_px=(59.5, 59.5), radius_px=58.0)
    assert pixels(fisheye, (120, 120)).panorama_shape == (60, 600)
    chosen = FrontEnd(fisheye, (120, 120), PanoramaConfig(height_px=40), FeatureConfig(kind="pixels"))
    assert (chosen.panorama_shape, chosen.geometry.max_deg) == ((40, 600), 35.0)


def test_there_are_no_features_before_the_network():
    front = pixels(CameraSpec(model="panorama"), (60, 600))
    assert front.lacks_network
    with pytest.raises(ConfigError, match="not learnt yet: build_map learns it"):
        front.features(np.random.default_rng(0).integers(0, 255, (60, 600)).astype(np.uint8))


def test_networks_are_the_same_by_what_they_do(maps):
    network = maps["local"].front_end.network
    assert same_network(None, None)
    assert not same_network(network, None)
    assert same_network(network, maps["polynomial"].front_end.network)
    assert not same_network(network, dataclasses.replace(network, deviation_floor=3.0))
    assert not same_network(network, network.first(1))


def test_a_network_that_would_fill_the_memory_is_refused():
    layers = [
        {"output_dim": 1, "field": [8, 8], "stride": [1, 1], "reduced_dim": 64},
        {"output_dim": 1, "reduced_dim": 2},
    ]
    config = MapConfig.checked({"network": {"layers": layers}})
    panorama = MapConfig.checked({"panorama": {"width_px": 4096, "height_px": 2048}}).panorama
    front_end = FrontEnd(CameraSpec(model="panorama"), (2048, 4096), panorama, FeatureConfig(kind="flat"))
    with pytest.raises(ConfigError, match=r"layer 1 of the network would take \d+ numbers a picture, at most"):
        require_room(config.network, front_end)
