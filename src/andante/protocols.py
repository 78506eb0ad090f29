"""Every seam of the house on one page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from andante.data import CameraSpec, Estimate, Fix, Frame, FrameInfo, ImageArray, Pose2D

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
    """What a robot senses after a step: its picture, its drifting odometry, whether it bumped."""

    timestamp_s: float
    image: ImageArray
    odometry: Pose2D
    bumped: bool


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
