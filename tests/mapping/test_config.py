"""The configuration: every wrong key and value is named, with what is allowed."""

import json
import tomllib

import pytest

from andante.errors import ConfigError
from andante.mapping import MapConfig


@pytest.mark.parametrize(
    ("values", "key", "allowed"),
    [
        (
            {"sede": 1},
            "sede",
            "calibration, drift, features, learning, memory, network, off_path, panorama, positions, readout, seed",
        ),
        ({"panorama": {"width": 1}}, "panorama.width", "height_px, max_deg, min_deg, width_px"),
        ({"features": {"type": 1}}, "features.type", "deviation_floor, gradient_floor, kind"),
        ({"learning": {"slow": 1}}, "learning.slow", "density_corrected, edge_ridge, expansion, invariance, order"),
        (
            {"readout": {"k": 1}},
            "readout.k",
            "caution, consensus_m, degree, inputs, kind, max_references, neighbours, sharpness",
        ),
        ({"calibration": {"alpha": 1}}, "calibration.alpha", "block_m, coverage, folds"),
        ({"memory": {"frames": 1}}, "memory.frames", "keep, max_frames"),
        (
            {"network": {"turns": 2}},
            "network.turns",
            "depth, deviation_floor, layers, neighbours, residual, ridge, wrap",
        ),
        (
            {"network": {"layers": [{"output_dim": 3, "outputs": 4}]}},
            r"network\.layers\.0\.outputs",
            "clip, field, noise, output_dim, reduced_dim, stride",
        ),
    ],
)
def test_unknown_keys_are_named_with_what_is_allowed(values, key, allowed):
    with pytest.raises(ConfigError, match=rf"^configuration: unknown key '{key}'; allowed here: {allowed}"):
        MapConfig.checked(values)


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"seed": -1}, "seed = -1 is not allowed: input should be greater than or equal to 0"),
        ({"positions": "gps"}, "positions = 'gps' is not allowed: input should be 'auto', 'reference'"),
        ({"learning": {"slow_features": 0}}, "learning.slow_features = 0 is not allowed"),
        ({"learning": {"slow_features": 2.5}}, "learning.slow_features = 2.5 is not allowed"),
        ({"learning": 5}, "learning = 5 is not allowed"),
        ({"learning": {"ridge": float("nan")}}, "learning.ridge = nan is not allowed: input should be a finite number"),
        ({"learning": {"edge_ridge": float("inf")}}, "learning.edge_ridge = inf is not allowed"),
        ({"learning": {"invariance": -1}}, "learning.invariance = -1 is not allowed: input should be greater than or"),
        (
            {"memory": {"max_frames": 99}},
            "memory.max_frames = 99 is not allowed: input should be greater than or equal",
        ),
        ({"network": {"layers": []}}, r"network\.layers = \[\] is not allowed: tuple should have at least 1 item"),
        ({"network": {"layers": [{}]}}, r"network\.layers\.0\.output_dim = {} is not allowed: field required"),
        ({"network": {"residual": 1.0}}, r"network\.residual = 1.0 is not allowed: input should be less than 1"),
        ({"memory": {"keep": "perhaps"}}, "memory.keep = 'perhaps' is not allowed"),
        ({"calibration": {"coverage": 1.0}}, "calibration.coverage = 1.0 is not allowed: input should be less than 1"),
        ({"readout": {"degree": 5}}, "readout.degree = 5 is not allowed"),
        ({"panorama": {"width_px": 10**9}}, "panorama.width_px = 1000000000 is not allowed"),
        ({"features": {"window_share": [0.1]}}, "features.window_share.1 = .* is not allowed: field required"),
        ({"seed": "x" * 10_000}, "seed = 'x{79} is not allowed"),
    ],
)
def test_wrong_values_are_named(values, message):
    with pytest.raises(ConfigError, match=f"^configuration: {message}") as caught:
        MapConfig.checked(values)
    assert len(str(caught.value)) < 400
    assert "\n" not in str(caught.value)


def test_values_win_over_what_was_there_and_leave_the_rest():
    base = MapConfig().with_values({"learning": {"slow_features": 20}, "seed": 3})
    changed = base.with_values({"learning": {"ridge": 0.5}, "readout": {"kind": "polynomial"}})
    assert (changed.learning.slow_features, changed.learning.ridge, changed.seed) == (20, 0.5, 3)
    assert (changed.readout.kind, changed.readout.degree) == ("polynomial", 2)
    assert base.readout.kind == "local"


@pytest.mark.parametrize("values", [{"seed": {"a": 1}}, {"wrong": {"a": 1}}, {"learning": {"wrong": 1}}])
def test_wrong_values_on_top_are_refused_as_well(values):
    with pytest.raises(ConfigError):
        MapConfig().with_values(values)


def test_a_config_is_frozen():
    with pytest.raises(ValueError, match="frozen"):
        MapConfig().learning.slow_features = 3


@pytest.mark.parametrize("config", [MapConfig(), MapConfig.thesis(), MapConfig.thesis_pixels()])
def test_plain_values_and_back(config):
    assert MapConfig.checked(json.loads(json.dumps(config.model_dump(mode="json")))) == config


def test_toml(tmp_path):
    path = tmp_path / "map.toml"
    text = 'seed = 4\n[learning]\norder = "temporal"\n[features]\nwindow_share = [0.1, 0.2]\n'
    path.write_text(text, encoding="utf-8")
    config = MapConfig.from_toml(path)
    assert (config.seed, config.learning.order, config.features.window_share) == (4, "temporal", (0.1, 0.2))
    assert config == MapConfig.checked(tomllib.loads(text))


@pytest.mark.parametrize(
    ("content", "message"),
    [
        (b"seed = ", "is no valid TOML"),
        (b"seed = \xff", "is no valid TOML"),
        (b"seed = " + b"9" * 5000, "is no valid TOML"),
        (b"a = " + b"[" * 100_000, "is no valid TOML"),
        (b"[learning]\nslowness = 1", r"map\.toml: unknown key 'learning\.slowness'"),
        (b"[learning]\nridge = nan", r"map\.toml: learning\.ridge = nan is not allowed"),
    ],
)
def test_faulty_toml(tmp_path, content, message):
    path = tmp_path / "map.toml"
    path.write_bytes(content)
    with pytest.raises(ConfigError, match=message) as caught:
        MapConfig.from_toml(path)
    assert "\n" not in str(caught.value)


def test_a_missing_file_is_named(tmp_path):
    with pytest.raises(ConfigError, match=r"nowhere\.toml cannot be read: No such file or directory; check the path"):
        MapConfig.from_toml(tmp_path / "nowhere.toml")
    with pytest.raises(ConfigError, match="cannot be read"):
        MapConfig.from_toml(tmp_path)


def test_the_thesis_settings():
    config = MapConfig.thesis()
    assert (config.panorama.width_px, config.panorama.height_px) == (600, 60)
    assert (config.features.n_frequencies, config.features.normalise, config.features.orientations) == (15, False, 0)
    assert (config.learning.expansion, config.learning.reduced_dim, config.learning.slow_features) == (
        "quadratic",
        20,
        8,
    )
    assert config.readout.kind == "polynomial"


def test_the_thesis_settings_for_raw_images():
    config = MapConfig.thesis_pixels()
    geometry = config.panorama.geometry("pixels")
    assert (geometry.width_px, geometry.height_px, geometry.min_deg, geometry.max_deg) == (600, 60, 5.0, 50.0)
    assert [layer.output_dim for layer in config.network.layers] == [12, 14, 16, 8]
    assert (config.network.depth, config.network.residual, config.network.wrap) == (4, 0.0, False)
    assert (config.learning.expansion, config.learning.slow_features, config.readout.kind) == (
        "linear",
        8,
        "polynomial",
    )


def test_panoramas_are_larger_for_a_network_unless_declared():
    plain = MapConfig().panorama
    assert (plain.geometry("fourier").width_px, plain.geometry("pixels").width_px) == (300, 600)
    wide = MapConfig.checked({"panorama": {"width_px": 400}}).panorama
    assert [wide.geometry(kind).width_px for kind in ("auto", "pixels")] == [400, 400]
    assert wide.geometry("pixels").height_px == 60
