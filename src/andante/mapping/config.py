"""How a map is built, as frozen nested values: every field has a default, unknown keys are errors."""

from __future__ import annotations

import tomllib
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, Literal, get_args, get_origin

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from andante.camera import PanoramaGeometry
from andante.errors import ConfigError
from andante.sfa import PANORAMA_LAYERS

FeatureKind = Literal["auto", "fourier", "flat", "pixels"]
Positions = Literal["auto", "reference", "odometry", "place"]
Order = Literal["places", "restructured", "temporal"]
ReadoutKind = Literal["local", "polynomial", "gaussian-process"]
MAX_DEGREE = 4
"""Of a polynomial readout: beyond it there are more terms than a drive has frames."""
Share = Annotated[float, Field(gt=0, le=1)]
Count = Annotated[int, Field(ge=1)]


class _Frozen(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class PanoramaConfig(_Frozen):
    """Size and elevation range of the panorama; a source that is smaller is never enlarged.

    What is ``None`` depends on the features: 300 x 24 px, for pixels 600 x 60 as in thesis 5.1, at 3 to 35 degrees.
    (The thesis looks from 5 to 50; the sky up there leads a network astray when the weather changes.)
    """

    width_px: Annotated[int, Field(ge=8, le=4096)] | None = None
    height_px: Annotated[int, Field(ge=2, le=2048)] | None = None
    min_deg: Annotated[float, Field(ge=-90, lt=90)] | None = None
    max_deg: Annotated[float, Field(gt=-90, le=90)] | None = None

    def geometry(self, kind: FeatureKind) -> PanoramaGeometry:
        """With nothing left open, for features of a kind."""
        width, height = (600, 60) if kind == "pixels" else (300, 24)
        return replace(PanoramaGeometry(width, height, 3.0, 35.0), **self.model_dump(exclude_none=True))


_THESIS_PANORAMA = PanoramaConfig(width_px=600, height_px=60, min_deg=5.0, max_deg=50.0)


class FeatureConfig(_Frozen):
    """What of the panorama is handed to learning; see ``andante.features``.

    ``auto`` is fourier for cameras that look all around, and flat for perspective ones, whose Fourier magnitudes
    mix up what is to the left and to the right. ``flat`` are the patch-normalised pixels as one vector; ``pixels`` is
    what a hierarchical network makes of them, which is learnt with the map (``NetworkConfig``).
    """

    kind: FeatureKind = "auto"
    n_frequencies: Count = 40
    normalise: bool = True
    window_share: tuple[Share, Share] = (0.043, 0.2)
    deviation_floor: Annotated[float, Field(gt=0, le=1e4)] = 20.0
    orientations: Annotated[int, Field(ge=0, le=16)] = 2
    gradient_floor: Annotated[float, Field(gt=0)] = 5.0
    orientation_weight: Annotated[float, Field(gt=0)] = 1.4
    unit: bool = True


class LayerConfig(_Frozen):
    """One layer of a network; see ``andante.sfa.Layer``."""

    output_dim: Count
    field: tuple[Count, Count] | None = None
    stride: tuple[Count, Count] = (1, 1)
    reduced_dim: Count = 20
    noise: Annotated[float, Field(ge=0)] = 0.0
    clip: Annotated[float, Field(gt=0)] | None = 4.0


class NetworkConfig(_Frozen):
    """The hierarchical network behind features of kind pixels (thesis 5.1.1), learnt with the map.

    The first ``depth`` of ``layers`` (by default those of table 5.1) are learnt, and what the last of them puts out at
    all its positions are the features. Two layers tell most (2,100 numbers a panorama of 600 x 60), three are compact
    (256), the eight outputs of all four are slow features themselves. ``residual`` is the share of a node's outputs
    that carry on what the slow ones leave unsaid, ``deviation_floor`` that of the patch normalisation. With ``wrap``
    receptive fields cross the seam of the panorama; ``None`` means that they do where the camera looks all around.

    Learning is along edges in the order of ``learning.order``; with places, each picture is joined with the next one
    and with about ``neighbours`` of other drives.
    """

    layers: Annotated[tuple[LayerConfig, ...], Field(min_length=1, max_length=8)] = tuple(
        LayerConfig(output_dim=one.output_dim, field=one.field, stride=one.stride, reduced_dim=one.reduced_dim)
        for one in PANORAMA_LAYERS
    )
    depth: Count = 2
    residual: Annotated[float, Field(ge=0, lt=1)] = 0.5
    wrap: bool | None = None
    deviation_floor: Annotated[float, Field(ge=0, le=1e4)] = 10.0
    ridge: Annotated[float, Field(ge=0)] = 0.03
    neighbours: Annotated[int, Field(ge=0, le=32)] = 1


class LearningConfig(_Frozen):
    """Which frames are alike, and what is learnt from it.

    ``place_radius_m`` defaults to 2.5 typical steps of the robot, at least 0.35 m. ``pca_components`` of 0 leaves
    the compression out. ``expansion`` quadratic is the thesis' network: linear SFA to ``reduced_dim``,
    expansion, SFA.

    ``invariance`` is how much more what differs between visits of a place is to be ignored than what changes along the
    way (the beta of theory 2; places order). ``edge_ridge`` is the white noise, in units of the mean edge variance,
    that is expected between two visits beyond what the recordings show; the fewer the conditions, the larger. These
    two and ``slow_features`` are chosen by leaving sessions out where they are ``None``. ``density_corrected`` lets
    places count alike, however long the robot dwelt there.
    """

    order: Order = "places"
    place_radius_m: Annotated[float, Field(gt=0)] | None = None
    slow_features: Count | None = None
    pca_components: Annotated[int, Field(ge=0)] = 256
    expansion: Literal["linear", "quadratic"] = "linear"
    reduced_dim: Count = 20
    ridge: Annotated[float, Field(ge=0)] = 0.0
    edge_ridge: Annotated[float, Field(ge=0)] | None = None
    invariance: Annotated[float, Field(ge=0)] | None = None
    density_corrected: bool = False
    stationary_m: Annotated[float, Field(ge=0)] = 0.01


class ReadoutConfig(_Frozen):
    """How a position follows from slow features.

    ``local``: the ``neighbours`` nearest references vote, with weights exp(-sharpness ((d / d1)² - 1)); those within
    ``consensus_m`` of the winner (default: 2 place radii) give the position, between them as the image lies between
    them in slow-feature space, the less so the more ``caution`` and the less the image looks like any of them. Caution
    is chosen by leaving sessions out where it is ``None``. ``polynomial``: of ``degree`` in the slowest ``inputs``
    features. At most ``max_references`` are kept, thinned by place.
    """

    kind: ReadoutKind = "local"
    neighbours: Count = 12
    sharpness: Annotated[float, Field(gt=0)] = 16.0
    caution: Annotated[float, Field(ge=0)] | None = None
    consensus_m: Annotated[float, Field(gt=0)] | None = None
    degree: Annotated[int, Field(ge=1, le=MAX_DEGREE)] = 2
    inputs: Count = 8
    max_references: Annotated[int, Field(ge=10)] = 4000


class CalibrationConfig(_Frozen):
    """How the 90 % radius is learnt: sessions left out in at most ``folds`` groups, or blocks of ``block_m`` of one."""

    coverage: Annotated[float, Field(gt=0, lt=1)] = 0.9
    folds: Annotated[int, Field(ge=2, le=20)] = 10
    block_m: Annotated[float, Field(gt=0)] | None = None


class DriftConfig(_Frozen):
    """What odometry is worth, as standard deviations, where drives are brought into one frame by it.

    ``gyro_rad_s`` is a bias of the gyro and ``scale`` an error of the wheels' size, constant in a drive; ``turn_rad``
    grows with the square root of the turn in radians, ``wheel_m`` with that of the way in metres.
    """

    gyro_rad_s: Annotated[float, Field(gt=0, lt=1)] = 0.003
    scale: Annotated[float, Field(gt=0, lt=1)] = 0.01
    turn_rad: Annotated[float, Field(gt=0, lt=1)] = 0.01
    wheel_m: Annotated[float, Field(gt=0, lt=1)] = 0.01


class OffPathConfig(_Frozen):
    """Whether images are also compared with views that the map imagines from where nobody drove (``enabled``).

    It needs headings of the mapped frames, and takes a second or two of mapping and a millisecond an image.
    """

    enabled: bool = True


class MemoryConfig(_Frozen):
    """Whether a map remembers its frames (``keep``), so that it can be updated, and how many at most.

    Beyond ``max_frames`` they are thinned by place and session.
    """

    keep: bool = True
    max_frames: Annotated[int, Field(ge=100)] = 20_000


class MapConfig(_Frozen):
    """Everything that decides a map besides its recordings; saved in the map with every default resolved."""

    positions: Positions = "auto"
    seed: Annotated[int, Field(ge=0)] = 0
    panorama: PanoramaConfig = PanoramaConfig()
    features: FeatureConfig = FeatureConfig()
    network: NetworkConfig = NetworkConfig()
    learning: LearningConfig = LearningConfig()
    readout: ReadoutConfig = ReadoutConfig()
    calibration: CalibrationConfig = CalibrationConfig()
    memory: MemoryConfig = MemoryConfig()
    off_path: OffPathConfig = OffPathConfig()
    drift: DriftConfig = DriftConfig()

    @classmethod
    def thesis(cls) -> MapConfig:
        """The thesis' choices (5.1, 6.2): 60 grey rows of 15 magnitudes, 20 -> 230 -> 8, one polynomial.

        The ridge is not in the thesis: without one, fewer frames than its 900 features have exactly constant
        combinations, and the polynomial of those goes astray by kilometres.
        """
        return cls(
            panorama=_THESIS_PANORAMA,
            features=FeatureConfig(kind="fourier", n_frequencies=15, normalise=False, orientations=0, unit=False),
            learning=LearningConfig(
                order="restructured",
                slow_features=8,
                pca_components=0,
                expansion="quadratic",
                ridge=1e-2,
                edge_ridge=0.0,
            ),
            readout=ReadoutConfig(kind="polynomial"),
        )

    @classmethod
    def thesis_pixels(cls) -> MapConfig:
        """The thesis' choices for raw images (5.1.1, table 5.1): eight outputs of the whole network, one polynomial.

        The outputs are slow features already, so what is learnt of them is linear and keeps all eight; a polynomial
        sees no difference. The thesis knows no ridge and no residual, and its receptive fields do not cross the seam.
        """
        return cls(
            panorama=_THESIS_PANORAMA,
            features=FeatureConfig(kind="pixels", unit=False),
            network=NetworkConfig(depth=4, residual=0.0, wrap=False, deviation_floor=20.0, ridge=0.0),
            learning=LearningConfig(order="restructured", slow_features=8, pca_components=0, edge_ridge=0.0),
            readout=ReadoutConfig(kind="polynomial"),
        )

    @classmethod
    def checked(cls, values: dict[str, Any], source: str = "configuration") -> MapConfig:
        """From plain values; raises ``ConfigError`` naming key, value and what is allowed."""
        try:
            return cls.model_validate(values)
        except ValidationError as error:
            raise ConfigError(_one_line(error, source)) from None

    @classmethod
    def from_toml(cls, path: str | Path) -> MapConfig:
        """From a TOML file with the sections ``[panorama]``, ``[features]``, ``[learning]`` and so on."""
        try:
            values = tomllib.loads(Path(path).read_text(encoding="utf-8"))
        except OSError as error:
            raise ConfigError(f"configuration {path} cannot be read: {error.strerror}; check the path") from None
        except (ValueError, RecursionError) as error:  # also no UTF-8, numbers of thousands of digits, deep nesting
            raise ConfigError(f"configuration {path} is no valid TOML: {error}") from None
        return cls.checked(values, f"configuration {path}")

    def with_values(self, values: dict[str, dict[str, Any] | Any]) -> MapConfig:
        """A copy with some fields replaced: ``{"learning": {"slow_features": 20}, "seed": 1}``."""
        merged = self.model_dump()
        for key, value in values.items():
            section = merged.get(key)
            merged[key] = {**section, **value} if isinstance(section, dict) and isinstance(value, dict) else value
        return MapConfig.checked(merged)


def _one_line(error: ValidationError, source: str) -> str:
    first = error.errors()[0]
    key = ".".join(str(part) for part in first["loc"]) or "value"
    if first["type"] == "extra_forbidden":
        allowed = ", ".join(_fields_at(first["loc"][:-1]))
        return f"{source}: unknown key {key!r}; allowed here: {allowed}"
    return f"{source}: {key} = {first['input']!r:.80} is not allowed: {first['msg'].lower()}"


def _fields_at(location: tuple[int | str, ...]) -> list[str]:
    model: type[BaseModel] = MapConfig
    for part in location:
        if isinstance(part, int):  # of a list, whose type is known already
            continue
        annotation = model.model_fields[part].annotation
        if get_origin(annotation) is tuple:
            annotation = get_args(annotation)[0]
        if not (isinstance(annotation, type) and issubclass(annotation, BaseModel)):
            return []
        model = annotation
    return sorted(model.model_fields)
