"""Every seam of the house on one page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from enum import StrEnum
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from andante.data import CameraSpec, Estimate, Fix, FloatArray, Frame, FrameInfo, ImageArray, Pose2D

SkipCallback = Callable[[FrameInfo, str], None]
"""Called with a frame that had to be skipped and a one-line reason."""


@runtime_checkable
class Recording(Protocol):
    """One drive of a robot: what is known of its frames, and their pictures on demand."""

    @property
    def name(self) -> str:
        """A short name for people."""
        ...

    @property
    def camera(self) -> CameraSpec:
        """The camera that took all frames."""
        ...

    @property
    def conditions(self) -> Mapping[str, Any]:
        """Free keys: season, weather, time of day."""
        ...

    @property
    def infos(self) -> Sequence[FrameInfo]:
        """What is known of every frame, without decoding any; strictly increasing time stamps."""
        ...

    def load(self, info: FrameInfo, *, colour: bool = False) -> ImageArray:
        """Read one frame's picture; raises ``ImageError``. Many threads call this at once."""
        ...

    def frames(
        self,
        indices: Sequence[int] | None = None,
        *,
        colour: bool = False,
        on_skip: SkipCallback | None = None,
    ) -> Iterator[Frame]:
        """Decode frames lazily, in order; every call starts again.

        ``indices`` chooses frames (ascending). A picture that cannot be read is skipped and told to
        ``on_skip``; more than 5 % of them, or pictures of mixed size, raise ``RecordingError``.
        """
        ...

    def content_hash(self) -> str:
        """A hash of the table and the pictures, for provenance: the same for the same content anywhere."""
        ...


@runtime_checkable
class StoredRecording(Recording, Protocol):
    """A recording that lies on disk and can be found there again."""

    @property
    def folder(self) -> Path:
        """Where it lies."""
        ...


@runtime_checkable
class Encoder(Protocol):
    """A panorama in, a feature vector out; without state, so that one encoder serves many threads."""

    @property
    def dim(self) -> int:
        """Length d of the feature vector."""
        ...

    def encode(self, panoramas: ImageArray) -> NDArray[np.float32]:
        """Grey uint8 (height, width) -> (d,) float32, or a stack (n, height, width) -> (n, d)."""
        ...


@runtime_checkable
class Localizer(Protocol):
    """One image in, one estimate out."""

    @property
    def name(self) -> str:
        """The name in tables."""
        ...

    def localize(self, image: ImageArray) -> Estimate:
        """Grey (height, width) or BGR (height, width, 3) uint8 -> estimate."""
        ...


@runtime_checkable
class Tracker(Protocol):
    """Images and odometry over time in, an estimate of now out."""

    @property
    def name(self) -> str:
        """The name in tables."""
        ...

    def update(self, frame: Frame, fix: Fix | None = None) -> Estimate:
        """One frame, whose ``info.odometry`` may be unknown, and a position from elsewhere where there is one.

        Frames come as they come: late, twice, out of order or not at all.
        """
        ...


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """Forward speed in m/s and turn rate in rad/s, counter-clockwise positive."""

    forward_m_s: float
    turn_rad_s: float


@dataclass(frozen=True, slots=True)
class Observation:
    """What a robot senses after a step: its picture, its drifting odometry, whether it bumped.

    ``range_m`` is how far it could go straight on before it touched something, as far as its sensor reaches, and
    ``None`` where it has no such sensor.
    """

    timestamp_s: float
    image: ImageArray
    odometry: Pose2D
    bumped: bool
    range_m: float | None = None


@runtime_checkable
class Robot(Protocol):
    """Something that drives and looks."""

    @property
    def camera(self) -> CameraSpec:
        """The camera on the robot."""
        ...

    def step(self, command: VelocityCommand, duration_s: float) -> Observation:
        """Drive for a while, then look."""
        ...


class DriveState(StrEnum):
    """What a navigator is about."""

    DRIVING = "driving"
    RECOVERING = "recovering"
    ARRIVED = "arrived"
    BLOCKED = "blocked"
    TIMED_OUT = "timed_out"
    STOPPED = "stopped"

    @property
    def over(self) -> bool:
        """Whether the navigator will not drive any more."""
        return self not in (DriveState.DRIVING, DriveState.RECOVERING)


@dataclass(frozen=True, slots=True)
class View:
    """All that a navigator is told of one moment.

    ``estimate`` is the live pose in the frame of the map, ``odometry`` that of the wheels in a frame of its own, which
    drifts. ``range_m`` is the free way ahead, where a sensor tells it; ``slow`` (k,) are the slow features of the
    current image, where somebody computed them.
    """

    timestamp_s: float
    estimate: Estimate
    odometry: Pose2D
    bumped: bool = False
    range_m: float | None = None
    slow: FloatArray | None = None


@runtime_checkable
class Navigator(Protocol):
    """Where the robot is in, how it should move out, until it has arrived or gives up."""

    @property
    def name(self) -> str:
        """The name in tables."""
        ...

    @property
    def state(self) -> DriveState:
        """What it is about; once this is over, every command is to stand still."""
        ...

    @property
    def reason(self) -> str:
        """Why it is in this state, in words."""
        ...

    def command(self, view: View) -> VelocityCommand:
        """One control step. Time stamps increase from call to call."""
        ...

    def stop(self, reason: str = "stopped from outside") -> None:
        """Drive no more; the state becomes stopped where it was not over already."""
        ...
