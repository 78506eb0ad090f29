import math
from contextlib import suppress
from dataclasses import fields

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from andante.data import CameraSpec
from andante.errors import RecordingError
from andante.recordings.manifest import Manifest, _Camera, format_manifest, parse_manifest

HEAD = 'schema = 1\nname = "monday"\n'


def parse(text):
    return parse_manifest(text, "recording.toml")


def test_reads_everything():
    manifest = parse(
        HEAD + 'source = "real"\n[camera]\nmodel = "fisheye"\nprojection = "kannala-brandt"\nfield_of_view_deg = 190\n'
        "centre_px = [239.5, 240]\nradius_px = 240\ncoefficients = [1, 0.5, 0, 0]\nforward_deg = -90\nmirrored = true\n"
        '[conditions]\nseason = "winter"\nday = 2024-02-03\nsun = { up = true, hours = [1, 2.5] }\n'
    )
    assert manifest.camera == CameraSpec(
        projection="kannala-brandt",
        field_of_view_deg=190.0,
        centre_px=(239.5, 240.0),
        radius_px=240.0,
        coefficients=(1.0, 0.5, 0.0, 0.0),
        forward_deg=-90.0,
        mirrored=True,
    )
    assert manifest.conditions == {"season": "winter", "day": "2024-02-03", "sun": {"up": True, "hours": [1, 2.5]}}
    assert (manifest.name, manifest.source) == ("monday", "real")


def test_defaults_are_those_of_the_camera_spec():
    assert parse(HEAD + "[camera]\n").camera == CameraSpec()
    assert list(_Camera.model_fields) == [field.name for field in fields(CameraSpec)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("schema = \n", r"recording\.toml: not valid TOML: .*line 1"),
        ("x = " + "[" * 5000, "not valid TOML"),
        ("x = " + "9" * 5000, "not valid TOML"),
        ('name = "a"\n[camera]', "'schema' is missing; add it"),
        ("schema = 1\n[camera]", "'name' is missing; add it"),
        (HEAD, "'camera' is missing; add it"),
        ("schema = 2\nfuture = 1", r"schema 2 is newer than this version of andante reads \(1\); update andante"),
        ('schema = 0\nname = "a"\n[camera]', "'schema': Input should be 1, got '0'"),
        ('schema = "one"\nname = "a"\n[camera]', "'schema': Input should be 1, got 'one'"),
        (
            HEAD + "colour = 1\n[camera]",
            "unknown key 'colour'; allowed are schema, name, source, camera, conditions",
        ),
        (HEAD + "[camera]\nfov = 1", r"unknown key 'camera\.fov'; allowed are model, projection, field_of_view_deg"),
        (HEAD + '[camera]\nmodel = "pinhole"', r"'camera\.model': Input should be 'fisheye', 'panorama' or 'persp"),
        (HEAD + "[camera]\nfield_of_view_deg = 400", r"'camera\.field_of_view_deg': .*equal to 360, got '400'"),
        (HEAD + "[camera]\nhorizontal_field_of_view_deg = 0", "should be greater than 0, got '0'"),
        (HEAD + "[camera]\nradius_px = -1", r"'camera\.radius_px': .* greater than 0"),
        (HEAD + "[camera]\nfocal_px = inf", r"'camera\.focal_px': Input should be a finite number"),
        (HEAD + "[camera]\nforward_deg = 361", "less than or equal to 360"),
        (HEAD + '[camera]\nforward_deg = "90"', r"'camera\.forward_deg': Input should be a valid number, got '90'"),
        (HEAD + "[camera]\ncentre_px = [1]", r"'camera\.centre_px\.1' is missing"),
        (HEAD + "[camera]\ncoefficients = [1, nan]", r"'camera\.coefficients\.1': Input should be a finite number"),
        (HEAD + "[camera]\nmirrored = 1", r"'camera\.mirrored': Input should be a valid boolean"),
        (HEAD + "camera = 3", r"'camera': Input should be a valid dictionary"),
        (HEAD + "[camera]\n[conditions]\nsun = nan", r"\[conditions\] hold what JSON cannot say"),
        (HEAD + 'source = "dreamt"\n[camera]', "'source': Input should be 'rendered' or 'real', got 'dreamt'"),
    ],
)
def test_faults_say_what_is_allowed(text, message):
    with pytest.raises(RecordingError, match=message) as raised:
        parse(text)
    assert "\n" not in str(raised.value)


texts = st.text(st.characters(exclude_categories=["Cs"]))
finite = st.floats(allow_nan=False, allow_infinity=False)
plain = st.recursive(
    st.booleans() | st.integers(-(2**62), 2**62) | finite | texts,
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(texts, inner, max_size=3),
    max_leaves=8,
)
pixels = st.none() | st.floats(1e-3, 1e6)
cameras = st.builds(
    CameraSpec,
    model=st.sampled_from(["fisheye", "panorama", "perspective"]),
    projection=st.sampled_from(["equidistant", "equisolid", "stereographic", "kannala-brandt", "ocam"]),
    field_of_view_deg=st.floats(1e-3, 360),
    facing=st.sampled_from(["up", "down-mirror"]),
    centre_px=st.none() | st.tuples(finite, finite),
    radius_px=pixels,
    focal_px=pixels,
    coefficients=st.lists(finite, max_size=5).map(tuple),
    forward_deg=st.floats(-360, 360),
    mirrored=st.booleans(),
    horizontal_field_of_view_deg=st.floats(1e-3, 360),
)


@given(
    st.builds(
        Manifest,
        name=texts.filter(bool),
        camera=cameras,
        conditions=st.dictionaries(texts, plain, max_size=4),
        source=st.sampled_from([None, "rendered", "real"]),
    )
)
def test_written_manifests_read_back_exactly(manifest):
    assert parse(format_manifest(manifest)) == manifest


def test_numbers_of_numpy_are_written_as_numbers():
    conditions = {"sun": np.float64(1.5), "n": np.int64(3), "up": np.bool_(True), "x": np.float32(0.5)}
    text = format_manifest(Manifest("a", CameraSpec(), conditions))
    assert parse(text).conditions == {"sun": 1.5, "n": 3, "up": True, "x": 0.5}


def test_conditions_that_cannot_be_written():
    with pytest.raises(RecordingError, match="a condition of type object cannot be written; allowed are text, numbers"):
        format_manifest(Manifest("a", CameraSpec(), {"x": object()}))


@given(texts | texts.map(lambda text: HEAD + "[camera]\n" + text))
def test_any_text_gives_a_manifest_or_a_recording_error(text):
    with suppress(RecordingError):
        assert math.isfinite(parse(text).camera.field_of_view_deg)
