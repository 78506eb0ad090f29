"""The frozen values that rooms hand to each other.

Frames follow ROS REP-103: x forward, y left, z up, heading counter-clockwise from x, SI units.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from enum import StrEnum
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from andante.errors import ConfigError

ImageArray = NDArray[np.uint8]
FloatArray = NDArray[np.float64]
IndexArray = NDArray[np.int64]

CameraModel = Literal["fisheye", "panorama", "perspective"]
Projection = Literal["equidistant", "equisolid", "stereographic", "kannala-brandt", "ocam"]
Facing = Literal["up", "down-mirror"]
PoseSource = Literal["reference", "odometry"]


class Status(StrEnum):
    """How far an estimate can be believed."""

    OK = "ok"
    DEGRADED = "degraded"
    LOST = "lost"
    OFF_MAP = "off_map"

    @property
    def has_pose(self) -> bool:
        """Whether an estimate with this status carries a pose."""
        return self in (Status.OK, Status.DEGRADED)


@dataclass(frozen=True, slots=True)
class Pose2D:
    """A position in metres and a heading in radians, ``None`` where the heading is unknown."""

    x_m: float
    y_m: float
    heading_rad: float | None = None


@dataclass(frozen=True, slots=True)
class CameraSpec:
    """What a recording says of its camera; ``andante.camera`` turns it into rays.

    ``centre_px`` is (x, y) with pixel centres at whole numbers; it and ``radius_px`` are found from the
    images where absent. ``forward_deg`` is where the robot's forward lies in the image, counter-clockwise
    from image right. ``mirrored`` is true where counter-clockwise in the image is clockwise seen from above.
    ``coefficients`` are k1..k4 of Kannala-Brandt or a0..an of the OCam polynomial (Scaramuzza 2006, pixels).
    """

    model: CameraModel = "fisheye"
    projection: Projection = "equidistant"
    field_of_view_deg: float = 180.0
    facing: Facing = "up"
    centre_px: tuple[float, float] | None = None
    radius_px: float | None = None
    focal_px: float | None = None
    coefficients: tuple[float, ...] = ()
    forward_deg: float = 0.0
    mirrored: bool = False
    horizontal_field_of_view_deg: float = 360.0

    @property
    def heading_invariant(self) -> bool:
        """Whether turning the robot on the spot only shifts the columns of its panorama."""
        if self.model == "perspective":
            return False
        return self.model == "fisheye" or self.horizontal_field_of_view_deg >= 360.0


@dataclass(frozen=True, slots=True)
class FrameInfo:
    """Everything known of a frame except its picture; ``image`` is relative to the recording."""

    index: int
    image: str
    timestamp_s: float
    odometry: Pose2D | None = None
    reference: Pose2D | None = None
    place: int | None = None


@dataclass(frozen=True, slots=True)
class Frame:
    """One decoded image, grey (height, width) or BGR (height, width, 3) uint8, and what is known of it."""

    info: FrameInfo
    image: ImageArray


@dataclass(frozen=True, slots=True)
class Trajectory:
    """Poses over time as arrays; NaN where a pose or a heading is unknown.

    Shapes: ``timestamp_s`` (n,), ``xy_m`` (n, 2), ``heading_rad`` (n,).
    """

    timestamp_s: FloatArray
    xy_m: FloatArray
    heading_rad: FloatArray

    def __len__(self) -> int:
        return len(self.timestamp_s)

    @property
    def known(self) -> NDArray[np.bool_]:
        """(n,) true where the position is known."""
        known: NDArray[np.bool_] = np.asarray(np.isfinite(self.xy_m).all(axis=1))
        return known

    @classmethod
    def of(cls, infos: Iterable[FrameInfo], source: PoseSource) -> Trajectory:
        """The reference poses or the odometry of some frames."""
        infos = list(infos)
        rows = np.full((len(infos), 3), np.nan)
        for row, info in zip(rows, infos, strict=True):
            pose = info.reference if source == "reference" else info.odometry
            if pose is not None:
                row[:2] = pose.x_m, pose.y_m
                if pose.heading_rad is not None:
                    row[2] = pose.heading_rad
        times = np.array([info.timestamp_s for info in infos], dtype=np.float64)
        return cls(times, rows[:, :2], rows[:, 2])


@dataclass(frozen=True, slots=True)
class Edges:
    """Weighted, undirected pairs of frames that ought to look alike to a slow feature.

    ``first`` and ``second`` (m,) int64 index frames, ``weight`` (m,) float64 is positive.
    """

    first: IndexArray
    second: IndexArray
    weight: FloatArray

    def __post_init__(self) -> None:
        if not (self.first.shape == self.second.shape == self.weight.shape and self.first.ndim == 1):
            raise ConfigError(
                f"edges need three one-dimensional arrays of one length, got shapes {self.first.shape}, "
                f"{self.second.shape}, {self.weight.shape}"
            )

    def __len__(self) -> int:
        return len(self.first)

    @classmethod
    def between(cls, first: IndexArray, second: IndexArray, weight: float = 1.0) -> Edges:
        """Edges of equal weight."""
        first, second = np.asarray(first, np.int64), np.asarray(second, np.int64)
        return cls(first, second, np.full(first.shape, float(weight)))

    @classmethod
    def joined(cls, parts: Sequence[Edges]) -> Edges:
        """All edges of several sets over the same frames."""
        if not parts:
            return cls.between(np.empty(0, np.int64), np.empty(0, np.int64))
        return cls(
            np.concatenate([part.first for part in parts]),
            np.concatenate([part.second for part in parts]),
            np.concatenate([part.weight for part in parts]),
        )

    def shifted(self, offset: int) -> Edges:
        """The same edges, over frames numbered from ``offset``."""
        return Edges(self.first + offset, self.second + offset, self.weight)


@dataclass(frozen=True, slots=True)
class Hypothesis:
    """One place where the robot may be, with a weight; the weights of an estimate sum to one."""

    x_m: float
    y_m: float
    weight: float
    heading_rad: float | None = None


@dataclass(frozen=True, slots=True)
class Fix:
    """A position in the frame of the map from elsewhere, as of RTK; ``sigma_m`` is its deviation along each axis."""

    x_m: float
    y_m: float
    sigma_m: float


@dataclass(frozen=True, slots=True)
class Estimate:
    """Where a robot is, how sure that is, and why not where it is not.

    ``x_m, y_m, heading_rad`` are ``None`` where the status is lost or off_map: a lost robot has no
    plausible pose. ``hypotheses`` (best first) hold what was considered, whatever the status.
    ``covariance`` is (3, 3) over x, y, heading with NaN for an unknown heading; ``radius_m`` is a 90 %
    radius calibrated on held-out data. ``likeness`` says from 1 to 0 how much the image looks like a mapped place, by
    itself, whatever the status. In a map of numbered places ``place`` is set and metres are not.
    """

    status: Status
    reason: str
    x_m: float | None = None
    y_m: float | None = None
    heading_rad: float | None = None
    covariance: FloatArray | None = None
    radius_m: float | None = None
    place: int | None = None
    likeness: float | None = None
    hypotheses: tuple[Hypothesis, ...] = field(default=(), repr=False)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: every key present, ``None`` for what is unknown, never NaN."""
        covariance = None
        if self.covariance is not None:
            covariance = [[v if np.isfinite(v) else None for v in row] for row in self.covariance.tolist()]
        return {
            "x_m": self.x_m,
            "y_m": self.y_m,
            "heading_rad": self.heading_rad,
            "radius_m": self.radius_m,
            "covariance": covariance,
            "place": self.place,
            "likeness": self.likeness,
            "status": str(self.status),
            "reason": self.reason,
        }
