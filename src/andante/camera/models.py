"""Fisheye models: angle off the optical axis <-> distance from the centre of the picture.

All of them are right past 90 degrees off the axis, where pinhole-based code is silently wrong.

=================  ======================================  =========================
projection         radius in pixels                        scale from
=================  ======================================  =========================
equidistant        f theta                                 focal_px or radius_px
equisolid          2 f sin(theta / 2)                      focal_px or radius_px
stereographic      2 f tan(theta / 2)                      focal_px or radius_px
kannala-brandt     f (theta + k1 theta^3 + ... k4 theta^9) focal_px or radius_px
ocam               theta = angle of (rho, f(rho))          its coefficients
=================  ======================================  =========================

``radius_px`` is the radius of the image circle, reached at half the field of view; ``focal_px`` wins where both are
given.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Protocol

import numpy as np
from numpy.polynomial import Polynomial
from numpy.typing import ArrayLike

from andante.data import CameraSpec, FloatArray
from andante.errors import ConfigError

_TABLE_CELLS = 1024
_NEWTON_STEPS = 8
_LARGEST_PICTURE_PX = 1e6
_IDENTITY = Polynomial([0.0, 1.0])


class FisheyeModel(Protocol):
    """A strictly increasing map between the angle off the optical axis and the image radius."""

    def radius_px(self, theta: ArrayLike) -> FloatArray:
        """Angles off the optical axis in radians, any shape -> image radii in pixels, same shape."""
        ...

    def theta(self, radius_px: ArrayLike) -> FloatArray:
        """Image radii in pixels, any shape -> angles off the optical axis in radians, same shape."""
        ...


@dataclass(frozen=True, slots=True)
class Equidistant:
    """r = f theta: equal angles are equally far apart; what most cheap fisheyes come close to."""

    focal_px: float

    def radius_px(self, theta: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``."""
        return self.focal_px * np.asarray(theta, np.float64)

    def theta(self, radius_px: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``."""
        return np.asarray(radius_px, np.float64) / self.focal_px


@dataclass(frozen=True, slots=True)
class Equisolid:
    """r = 2 f sin(theta / 2): equal solid angles cover equal areas."""

    focal_px: float

    def radius_px(self, theta: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``; theta up to pi."""
        return 2.0 * self.focal_px * np.sin(np.asarray(theta, np.float64) / 2.0)

    def theta(self, radius_px: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``; radii beyond 2 f are held at pi."""
        return 2.0 * np.arcsin(np.minimum(np.asarray(radius_px, np.float64) / (2.0 * self.focal_px), 1.0))


@dataclass(frozen=True, slots=True)
class Stereographic:
    """r = 2 f tan(theta / 2): small shapes keep their angles; grows without bound towards pi."""

    focal_px: float

    def radius_px(self, theta: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``; theta below pi."""
        return 2.0 * self.focal_px * np.tan(np.asarray(theta, np.float64) / 2.0)

    def theta(self, radius_px: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``."""
        return 2.0 * np.arctan(np.asarray(radius_px, np.float64) / (2.0 * self.focal_px))


@dataclass(frozen=True, slots=True)
class KannalaBrandt:
    """r = f (theta + k1 theta^3 + k2 theta^5 + k3 theta^7 + k4 theta^9) for theta up to ``max_theta``.

    Radii beyond that of ``max_theta`` are held there. Source: Kannala and Brandt, PAMI 28 (2006), equation 6.
    Raises ``ConfigError`` where the polynomial does not increase all the way to ``max_theta``.
    """

    focal_px: float
    coefficients: tuple[float, ...]
    max_theta: float

    def __post_init__(self) -> None:
        turns = _first_root(self._polynomial.deriv(), self.max_theta)
        if np.isfinite(turns):
            raise ConfigError(
                f"kannala-brandt coefficients {self.coefficients} stop increasing at {np.degrees(turns):.1f} degrees "
                f"off axis, inside the field of view of {2 * np.degrees(self.max_theta):g} degrees; "
                "check them or reduce field_of_view_deg"
            )

    @property
    def _polynomial(self) -> Polynomial:
        odd = np.zeros(2 + 2 * len(self.coefficients))
        odd[1::2] = 1.0, *self.coefficients
        return Polynomial(self.focal_px * odd)

    def radius_px(self, theta: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``."""
        return np.asarray(self._polynomial(np.asarray(theta, np.float64)))

    def theta(self, radius_px: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``."""
        return _invert_increasing(self._polynomial, self._polynomial.deriv(), radius_px, self.max_theta)


@dataclass(frozen=True, slots=True)
class OCam:
    """The ray of a pixel at distance rho from the centre is (x, y, f(rho)), f = a0 + a1 rho + ... an rho^n.

    The z axis is the optical axis, and the pixel in the centre looks along it, so the sign of a0 says which way z
    points: positive (MATLAB's Computer Vision Toolbox) towards the scene, negative (OCamCalib) away from it; both
    are understood. All coefficients are needed, also a1 = 0, which MATLAB leaves out. Rays past 90 degrees have
    f of the other sign than a0. Angles beyond ``max_theta`` are held at its radius.
    Source: Scaramuzza, Martinelli and Siegwart, IROS 2006.
    Raises ``ConfigError`` where the angle does not increase with rho all the way to ``max_theta``.
    """

    coefficients: tuple[float, ...]
    max_theta: float

    def __post_init__(self) -> None:
        if not self.coefficients or self.coefficients[0] == 0.0:
            raise ConfigError(f"ocam coefficients a0..an need a non-zero a0 (in pixels), got {self.coefficients}")
        reach = self._max_radius_px
        if np.isinf(reach) or np.isfinite(_first_root(self._turning, reach)):
            raise ConfigError(
                f"ocam coefficients {self.coefficients} do not increase to half the field of view of "
                f"{2 * np.degrees(self.max_theta):g} degrees; check them (a1 = 0 included) or reduce field_of_view_deg"
            )

    @property
    def _forward(self) -> Polynomial:
        """The polynomial f with the sign that makes the scene lie at positive z."""
        return Polynomial(np.sign(self.coefficients[0]) * np.asarray(self.coefficients, np.float64))

    @property
    def _turning(self) -> Polynomial:
        """The polynomial f - rho f', positive where the angle of (rho, f(rho)) increases with rho."""
        return self._forward - _IDENTITY * self._forward.deriv()

    @property
    def _max_radius_px(self) -> float:
        """Where the angle first reaches ``max_theta``, infinite where it never does in any picture."""
        reached = np.sin(self.max_theta) * self._forward - np.cos(self.max_theta) * _IDENTITY
        return _first_root(reached, _LARGEST_PICTURE_PX)

    def radius_px(self, theta: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``."""
        forward, turning = self._forward, self._turning
        return _invert_increasing(
            self.theta, lambda rho: turning(rho) / (rho**2 + forward(rho) ** 2), theta, self._max_radius_px
        )

    def theta(self, radius_px: ArrayLike) -> FloatArray:
        """See ``FisheyeModel``."""
        rho = np.asarray(radius_px, np.float64)
        return np.asarray(np.arctan2(rho, self._forward(rho)), np.float64)


def fisheye_model(spec: CameraSpec) -> FisheyeModel:
    """The lens of a fisheye camera.

    ``focal_px`` has no meaning for ocam, whose coefficients are in pixels.
    Raises ``ConfigError`` for a field of view, a scale or coefficients that make no lens, and where the scale of the
    lens is unknown because the image circle has not been found yet.
    """
    half = _half_field_of_view(spec)
    if not np.isfinite(spec.coefficients).all():
        raise ConfigError(f"coefficients must be finite numbers, got {spec.coefficients}")
    if spec.projection == "ocam":
        return OCam(spec.coefficients, half)
    if spec.projection == "kannala-brandt":
        if not 1 <= len(spec.coefficients) <= 4:
            raise ConfigError(f"kannala-brandt takes 1 to 4 coefficients k1..k4, got {len(spec.coefficients)}")
        unit = KannalaBrandt(1.0, spec.coefficients, half)
        return replace(unit, focal_px=_focal_px(spec, unit, half))
    kinds: dict[str, Callable[[float], FisheyeModel]] = {
        "equidistant": Equidistant,
        "equisolid": Equisolid,
        "stereographic": Stereographic,
    }
    if spec.projection not in kinds:
        raise ConfigError(
            f"unknown fisheye projection {spec.projection!r}; allowed are {', '.join(kinds)}, kannala-brandt, ocam"
        )
    if spec.coefficients:
        raise ConfigError(
            f"projection {spec.projection} takes no coefficients, got {spec.coefficients}; "
            "remove them or choose kannala-brandt or ocam"
        )
    kind = kinds[spec.projection]
    return kind(_focal_px(spec, kind(1.0), half))


def _half_field_of_view(spec: CameraSpec) -> float:
    """Largest angle off the optical axis in radians."""
    degrees = spec.field_of_view_deg
    if spec.model != "fisheye":
        raise ConfigError(f"only a camera of model 'fisheye' has a fisheye lens, got a camera of model {spec.model!r}")
    if not 0.0 < degrees <= 360.0:
        raise ConfigError(f"field_of_view_deg must be above 0 and at most 360, got {degrees:g}")
    if degrees == 360.0 and spec.projection in ("stereographic", "ocam"):
        raise ConfigError(
            f"field_of_view_deg must be below 360 for projection {spec.projection}, whose radius has no bound there"
        )
    return float(np.radians(degrees / 2.0))


def _focal_px(spec: CameraSpec, unit: FisheyeModel, half_field_of_view: float) -> float:
    """The declared focal length, or the one that puts half the field of view on the image circle."""
    for name, value in (("focal_px", spec.focal_px), ("radius_px", spec.radius_px)):
        if value is not None and not 0.0 < value < np.inf:
            raise ConfigError(f"{name} must be positive and finite, got {value:g}")
    if spec.focal_px is not None:
        return spec.focal_px
    if spec.radius_px is None:
        raise ConfigError(
            "the camera declares neither radius_px nor focal_px; declare one or find the image circle "
            "in some images first (andante.camera.with_found_circle)"
        )
    return spec.radius_px / float(unit.radius_px(half_field_of_view))


def _first_root(polynomial: Polynomial, upper: float) -> float:
    """Smallest real root in (0, upper], infinite without one."""
    # In units of upper, leading terms too small to matter there can go; as they are, they overflow.
    terms = np.asarray(polynomial.coef, np.float64) * upper ** np.arange(len(polynomial.coef))
    roots = Polynomial(terms).trim(float(1e-16 * np.abs(terms).max())).roots()
    real = roots[np.abs(roots.imag) <= 1e-9 * np.abs(roots)].real
    return upper * float(min(real[(real > 0.0) & (real <= 1.0)], default=np.inf))


def _invert_increasing(
    function: Callable[[FloatArray], FloatArray],
    slope: Callable[[FloatArray], FloatArray],
    value: ArrayLike,
    upper: float,
) -> FloatArray:
    """Where in [0, upper] an increasing function takes ``value``, held at the ends: Newton inside a bracket."""
    grid = np.linspace(0.0, upper, _TABLE_CELLS + 1)
    table = function(grid)
    target = np.clip(np.asarray(value, np.float64), table[0], table[-1])
    cell = np.clip(np.searchsorted(table, target), 1, _TABLE_CELLS)
    low, high = grid[cell - 1], grid[cell]
    x = np.interp(target, table, grid)
    for _ in range(_NEWTON_STEPS):
        residual = function(x) - target
        low, high = np.where(residual <= 0.0, x, low), np.where(residual >= 0.0, x, high)
        step = x - residual / slope(x)
        x = np.where((step >= low) & (step <= high), step, (low + high) / 2.0)
    return np.asarray(x)
