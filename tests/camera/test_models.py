"""Every lens is its own inverse past 90 degrees, takes its known values and refuses what is no lens."""

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from andante.camera import Equidistant, Equisolid, KannalaBrandt, OCam, Stereographic, fisheye_model
from andante.data import CameraSpec
from andante.errors import ConfigError

# f(rho) = 200 - rho^2 / 800 - ..., which turns negative (past 90 degrees) at about 390 px.
OCAM = (200.0, 0.0, -1.2e-3, 1e-7, -5e-10)
KANNALA_BRANDT = (0.02, -0.004, 0.0006, -0.00002)

SPECS = {
    "equidistant": CameraSpec(projection="equidistant", field_of_view_deg=360.0, radius_px=400.0),
    "equisolid": CameraSpec(projection="equisolid", field_of_view_deg=350.0, radius_px=400.0),
    "stereographic": CameraSpec(projection="stereographic", field_of_view_deg=320.0, radius_px=400.0),
    "kannala-brandt": CameraSpec(
        projection="kannala-brandt", field_of_view_deg=260.0, radius_px=400.0, coefficients=KANNALA_BRANDT
    ),
    "ocam": CameraSpec(projection="ocam", field_of_view_deg=230.0, coefficients=OCAM),
    "ocam, z away from the scene": CameraSpec(
        projection="ocam", field_of_view_deg=230.0, coefficients=tuple(-a for a in OCAM)
    ),
}


@pytest.mark.parametrize("spec", SPECS.values(), ids=SPECS.keys())
def test_angle_and_radius_are_inverse_and_increasing_over_the_whole_field_of_view(spec: CameraSpec) -> None:
    model = fisheye_model(spec)
    theta = np.linspace(0.0, np.radians(spec.field_of_view_deg / 2), 4001).reshape(-1, 1)
    radius = model.radius_px(theta)
    assert radius.shape == theta.shape
    assert radius[0, 0] == pytest.approx(0.0, abs=1e-9)
    assert (np.diff(radius[:, 0]) > 0).all()
    np.testing.assert_allclose(model.theta(radius), theta, atol=1e-7)
    np.testing.assert_allclose(model.radius_px(model.theta(radius)), radius, atol=1e-7)
    if spec.radius_px is not None:
        assert radius[-1, 0] == pytest.approx(spec.radius_px)


@given(
    coefficients=st.tuples(*(st.floats(0.0, 0.05) for _ in range(4))),
    half_deg=st.floats(5.0, 180.0),
    share=st.floats(0.0, 1.0),
)
@example(coefficients=(0.0, 0.0, 0.0, 2e-311), half_deg=5.0, share=0.0)  # overflowed the search for turning points
def test_kannala_brandt_with_any_rising_polynomial_is_inverse(
    coefficients: tuple[float, ...], half_deg: float, share: float
) -> None:
    model = KannalaBrandt(100.0, coefficients, float(np.radians(half_deg)))
    theta = share * np.radians(half_deg)
    assert float(model.theta(model.radius_px(theta))) == pytest.approx(theta, abs=1e-9)


@given(a0=st.floats(50.0, 500.0), a2=st.floats(-5e-3, -1e-4), half_deg=st.floats(5.0, 130.0), share=st.floats(0.0, 1.0))
def test_ocam_with_any_falling_parabola_is_inverse(a0: float, a2: float, half_deg: float, share: float) -> None:
    model = OCam((a0, 0.0, a2), float(np.radians(half_deg)))
    theta = share * np.radians(half_deg)
    assert float(model.theta(model.radius_px(theta))) == pytest.approx(theta, abs=1e-9)


def test_known_values() -> None:
    assert float(Equidistant(100.0).radius_px(np.pi)) == pytest.approx(100 * np.pi)
    assert float(Equisolid(100.0).radius_px(np.pi)) == pytest.approx(200.0)
    assert float(Equisolid(100.0).theta(250.0)) == pytest.approx(np.pi)
    assert float(Stereographic(100.0).radius_px(np.pi / 2)) == pytest.approx(200.0)
    assert float(Stereographic(100.0).radius_px(np.radians(120.0))) == pytest.approx(200.0 * np.sqrt(3.0))
    assert float(KannalaBrandt(100.0, (0.1,), 3.0).radius_px(2.0)) == pytest.approx(100.0 * (2.0 + 0.8))


def test_ocam_looks_along_x_y_f_of_rho() -> None:
    model = OCam(OCAM, np.radians(115.0))
    rho = np.array([0.0, 100.0, 390.0, 500.0])
    f = np.polyval(OCAM[::-1], rho)
    assert f[-1] < 0 < f[1]
    np.testing.assert_allclose(model.theta(rho), np.arccos(f / np.hypot(rho, f)))
    assert float(model.theta(500.0)) > np.pi / 2


def test_a_parabolic_mirror_as_ocam_is_the_stereographic_projection() -> None:
    # f = a0 - rho^2 / (4 a0) is tan(theta / 2) = rho / (2 a0).
    model = OCam((150.0, 0.0, -1.0 / 600.0), np.radians(140.0))
    theta = np.radians([10.0, 89.0, 90.0, 91.0, 139.0])
    np.testing.assert_allclose(model.radius_px(theta), Stereographic(150.0).radius_px(theta), rtol=1e-9)


def test_a_declared_focal_length_wins_over_the_radius() -> None:
    model = fisheye_model(CameraSpec(focal_px=120.0, radius_px=400.0))
    assert float(model.radius_px(1.0)) == pytest.approx(120.0)


@pytest.mark.parametrize(
    ("spec", "message"),
    [
        (CameraSpec(radius_px=9.0, field_of_view_deg=0.0), "field_of_view_deg must be above 0 and at most 360, got 0"),
        (CameraSpec(radius_px=9.0, field_of_view_deg=361.0), "at most 360, got 361"),
        (CameraSpec(radius_px=9.0, field_of_view_deg=float("nan")), "got nan"),
        (CameraSpec(radius_px=9.0, field_of_view_deg=360.0, projection="stereographic"), "below 360"),
        (CameraSpec(field_of_view_deg=360.0, projection="ocam", coefficients=OCAM), "below 360"),
        (CameraSpec(), "neither radius_px nor focal_px.*with_found_circle"),
        (CameraSpec(radius_px=-1.0), "radius_px must be positive and finite, got -1"),
        (CameraSpec(focal_px=0.0), "focal_px must be positive and finite, got 0"),
        (CameraSpec(radius_px=9.0, coefficients=(0.1,)), "equidistant takes no coefficients"),
        (CameraSpec(radius_px=9.0, projection="fish"), "unknown fisheye projection 'fish'"),  # type: ignore[arg-type]
        (CameraSpec(model="panorama"), "got a camera of model 'panorama'"),
        (CameraSpec(radius_px=9.0, projection="kannala-brandt"), "1 to 4 coefficients k1..k4, got 0"),
        (
            CameraSpec(radius_px=9.0, projection="kannala-brandt", coefficients=(-0.2,)),
            "stop increasing at 74.0 degrees off axis, inside the field of view of 180",
        ),
        (
            CameraSpec(radius_px=9.0, projection="kannala-brandt", coefficients=(float("nan"),)),
            "must be finite numbers",
        ),
        (CameraSpec(projection="ocam"), "non-zero a0"),
        (CameraSpec(projection="ocam", coefficients=(0.0, 1.0)), "non-zero a0"),
        # A pinhole, f constant, never reaches 90 degrees.
        (CameraSpec(projection="ocam", coefficients=(200.0,)), "do not increase to half the field of view of 180"),
        # f rises again before 90 degrees, so that two radii share an angle.
        (CameraSpec(projection="ocam", coefficients=(200.0, 0.0, 4e-3, 0.0, -1e-9)), "do not increase"),
    ],
)
def test_what_is_no_lens_is_refused(spec: CameraSpec, message: str) -> None:
    with pytest.raises(ConfigError, match=message):
        fisheye_model(spec)
