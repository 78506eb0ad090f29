"""Where an image was taken, told by any patches of it: no landmark was taught, and no network (thesis 7.6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np

from andante.data import Estimate, FloatArray, ImageArray, Status
from andante.errors import BlankImageError, ConfigError, RecordingError
from andante.features import PatchEncoder
from andante.mapping.config import FeatureConfig
from andante.mapping.frontend import FrontEnd, camera_and_size
from andante.mapping.gaze_calibration import GazeBounds, calibrated
from andante.mapping.gaze_config import GazeConfig
from andante.mapping.gaze_lesson import GazeDrive, learn_readout, read_drive
from andante.mapping.gaze_readout import GazeReadout, spaced_azimuths
from andante.mapping.gaze_resection import Resection
from andante.mapping.gaze_votes import Verdict
from andante.mapping.memory import Source
from andante.mapping.sessions import Progress, require_distinct
from andante.mapping.uncertainty import covariance_of
from andante.protocols import Recording
from andante.sfa import one_thread

_AGREES = 0.5
"""Support from which a patch counts as agreeing."""


@dataclass(frozen=True, eq=False)
class GazeMap:
    """Patches of mapped frames, and what those of an image have to do with them; made by ``build_gaze_map``.

    ``readout`` tells place and heading; ``bounds``, by rising number of patches, are what held-out frames allow to
    promise.
    """

    config: GazeConfig
    front_end: FrontEnd
    readout: GazeReadout
    bounds: tuple[GazeBounds, ...]
    sources: tuple[Source, ...]
    name: str = "gaze"

    @classmethod
    def load(cls, path: str | Path) -> GazeMap:
        """Read a file of ``save``; raises ``MapError`` for anything else."""
        from andante.mapping.gaze_file import read_gaze_map

        return read_gaze_map(path)

    def save(self, path: str | Path) -> int:
        """Write the map atomically and return its size in bytes; raises ``MapError`` where that fails."""
        from andante.mapping.gaze_file import write_gaze_map

        return write_gaze_map(self, path)

    def localize(self, image: ImageArray) -> Estimate:
        """Where an image was taken, by patches all around: grey (height, width) or BGR (height, width, 3) uint8.

        A picture that shows nothing gives status lost; one of the wrong size raises ``ImageError``.
        """
        return self.localize_patches(image, spaced_azimuths(self.config.patches))

    def localize_patches(self, image: ImageArray, azimuth_rad: Sequence[float] | FloatArray) -> Estimate:
        """The same by the patches whose middles are at azimuths (m,), counter-clockwise from the robot's forward.

        Raises ``ArrayError`` for none of them.
        """
        try:
            panorama = self.front_end.grey_panorama(image)
        except BlankImageError as error:
            return Estimate(Status.LOST, str(error))
        return self.estimate(self.look(panorama, azimuth_rad))

    def look(self, panorama: ImageArray, azimuth_rad: Sequence[float] | FloatArray) -> Verdict:
        """What patches of a grey panorama (height, width) agree on, and which of them do."""
        fields = self.readout.encoder.fields(panorama[None])[0]
        return self.readout.look(fields, np.asarray(azimuth_rad, dtype=np.float64))

    def resect(self, panorama: ImageArray, azimuth_rad: Sequence[float] | FloatArray) -> Resection:
        """Where a panorama was taken, by where the things stand that its patches show: also away from all drives.

        Between the drives it is the better one, along them ``look`` is. Nothing is promised of it. Raises
        ``ArrayError`` for fewer than three patches.
        """
        fields = self.readout.encoder.fields(panorama[None])[0]
        return self.readout.resect(fields, np.asarray(azimuth_rad, dtype=np.float64))

    def estimate(self, seen: Verdict) -> Estimate:
        """A verdict with what may be promised of it."""
        bounds = self._bounds_of(len(seen.support))
        agree = int((seen.support >= _AGREES).sum())
        told = f"{agree} of {len(seen.support)} patches agree, by a margin of {seen.margin:.1f}"
        likeness = float(seen.clarity @ seen.support / len(seen.support))
        status = bounds.status(seen)
        if status is Status.LOST:
            reason = f"the patches do not agree on one place: {told}, at least {bounds.lost_below:.1f} is needed"
            return Estimate(Status.LOST, reason, likeness=likeness, hypotheses=seen.hypotheses)
        return Estimate(
            status,
            told,
            x_m=float(seen.xy[0]),
            y_m=float(seen.xy[1]),
            heading_rad=seen.heading_rad,
            covariance=covariance_of(seen.covariance, bounds.radius_m(seen), bounds.heading_rad),
            radius_m=bounds.radius_m(seen),
            likeness=likeness,
            hypotheses=seen.hypotheses,
        )

    def for_recording(self, recording: Recording) -> GazeMap:
        """The same map for the camera of a recording, whose image circle is found where it is not declared."""
        return replace(self, front_end=self.front_end.for_recording(recording))

    def _bounds_of(self, patches: int) -> GazeBounds:
        """Of the largest number that was tried and is not larger."""
        return [bounds for bounds in self.bounds if bounds.patches <= max(1, patches)][-1]


def build_gaze_map(
    recordings: Sequence[Recording],
    config: GazeConfig | None = None,
    *,
    name: str = "gaze",
    progress: Progress | None = None,
) -> GazeMap:
    """Learn from recordings with known positions and headings in one frame of reference.

    Raises ``RecordingError`` for recordings that cannot be used, ``ConfigError`` for a camera that does not look all
    around, ``LearningError`` for too few frames. The same recordings and configuration give the same map.
    """
    config = config or GazeConfig()
    if not recordings:
        raise RecordingError("a map of gazes needs at least one recording, got none")
    if config.positions == "odometry" and len(recordings) > 1:
        raise RecordingError(
            f"{len(recordings)} recordings with odometry alone are in frames of their own; hand in one of them, or "
            "recordings with x_m, y_m and heading_rad"
        )
    front_end = FrontEnd(*camera_and_size(recordings[0]), config.panorama, FeatureConfig())
    encoder = patch_encoder(front_end, config)
    drives = [read_drive(one, front_end, encoder, config, progress=progress) for one in recordings]
    require_distinct([drive.session for drive in drives])
    return learn_gaze_map(drives, front_end, encoder, config, name=name)


def patch_encoder(front_end: FrontEnd, config: GazeConfig) -> PatchEncoder:
    """What describes patches of a camera; raises ``ConfigError`` for one that does not look all around."""
    if front_end.phase_encoder is None:
        raise ConfigError(
            f"a map of gazes needs a camera that looks all around, this one is {front_end.camera.model}; use andante "
            "map for it"
        )
    return PatchEncoder(*front_end.panorama_shape, config.width_deg, config.cell_deg)


def learn_gaze_map(
    drives: Sequence[GazeDrive], front_end: FrontEnd, encoder: PatchEncoder, config: GazeConfig, *, name: str = "gaze"
) -> GazeMap:
    """What ``build_gaze_map`` does once the pictures have become fields."""
    learn = partial(learn_readout, encoder=encoder, config=config)
    with one_thread():
        readout = learn(drives)
        bounds = calibrated(drives, learn, config.coverage)
    return GazeMap(config, front_end, readout, bounds, tuple(drive.session.source for drive in drives), name)
