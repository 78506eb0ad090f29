"""Where an image was taken, told by any patches of it: no landmark was taught, and no network (thesis 7.6)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from andante.data import Estimate, FloatArray, Hypothesis, ImageArray, Status
from andante.errors import BlankImageError, ConfigError, RecordingError
from andante.features import PatchEncoder
from andante.mapping.config import FeatureConfig
from andante.mapping.frontend import FrontEnd, camera_and_size
from andante.mapping.gaze_calibration import GazeBounds, calibrated
from andante.mapping.gaze_config import GazeConfig
from andante.mapping.gaze_lesson import GazeDrive, GazeModel, gallery_of, learn_gaze, read_drive
from andante.mapping.gaze_votes import Gallery, Rules, Verdict, verdict
from andante.mapping.memory import Source
from andante.mapping.sessions import Progress, require_distinct
from andante.mapping.uncertainty import covariance_of
from andante.protocols import Recording
from andante.sfa import one_thread

_DROPPED = 0.5
"""Support below which a patch counts as not agreeing."""


@dataclass(frozen=True, eq=False)
class GazeMap:
    """Patches of mapped frames, and what an image has to do with them; made by ``build_gaze_map``.

    ``encoder`` describes patches, ``model`` makes slow features of them, ``gallery`` is what these are compared with;
    ``bounds`` are what held-out frames allow to promise.
    """

    config: GazeConfig
    front_end: FrontEnd
    encoder: PatchEncoder
    model: GazeModel
    gallery: Gallery
    bounds: GazeBounds
    sources: tuple[Source, ...]
    name: str = "gaze"

    def localize(self, image: ImageArray) -> Estimate:
        """Where an image was taken, by patches all around: grey (height, width) or BGR (height, width, 3) uint8.

        A picture that shows nothing gives status lost; one of the wrong size raises ``ImageError``.
        """
        return self.localize_patches(image, self.default_azimuths)

    def localize_patches(self, image: ImageArray, azimuth_rad: Sequence[float] | FloatArray) -> Estimate:
        """The same by the patches whose middles are at azimuths (m,), counter-clockwise from the robot's forward."""
        try:
            panorama = self.front_end.grey_panorama(image)
        except BlankImageError as error:
            return Estimate(Status.LOST, str(error))
        return self.estimate(self.look(panorama, azimuth_rad))

    def look(self, panorama: ImageArray, azimuth_rad: Sequence[float] | FloatArray) -> Verdict:
        """What patches of a grey panorama (height, width) agree on; raises ``ArrayError`` for none of them."""
        azimuth = np.asarray(azimuth_rad, dtype=np.float64).reshape(1, -1)
        patches = self.encoder.cut(self.encoder.fields(panorama[None]), azimuth)[0]
        return verdict(self.gallery, self.model.transform(patches), azimuth[0], self.rules)

    def estimate(self, seen: Verdict) -> Estimate:
        """A verdict with what may be promised of it."""
        agree = int((seen.support >= _DROPPED).sum())
        told = f"{agree} of {len(seen.support)} patches agree, by a margin of {seen.margin:.1f}"
        best = Hypothesis(*seen.xy.tolist(), 1 / (1 + _odds(seen)), seen.heading_rad)
        rivals = tuple(
            Hypothesis(x, y, float(np.exp(-behind)) * best.weight, heading) for x, y, heading, behind in seen.rivals
        )
        likeness = float(seen.clarity @ seen.support / len(seen.support))
        if seen.margin < self.bounds.lost_below:
            reason = f"the patches do not agree on one place: {told}, at least {self.bounds.lost_below:.1f} is needed"
            return Estimate(Status.LOST, reason, likeness=likeness, hypotheses=(best, *rivals))
        status = Status.OK if seen.margin >= self.bounds.degraded_below else Status.DEGRADED
        radius = self.bounds.radius_m(seen)
        covariance = covariance_of(seen.covariance + np.eye(2) * 1e-6, radius, self.bounds.heading_rad)
        x, y = seen.xy.tolist()
        return Estimate(
            status, told, x, y, seen.heading_rad, covariance, radius, likeness=likeness, hypotheses=(best, *rivals)
        )

    def for_recording(self, recording: Recording) -> GazeMap:
        """The same map for the camera of a recording, whose image circle is found where it is not declared."""
        return replace(self, front_end=self.front_end.for_recording(recording))

    @property
    def default_azimuths(self) -> FloatArray:
        """(patches,) evenly spaced, the first straight ahead."""
        azimuths: FloatArray = 2 * np.pi * np.arange(self.config.patches) / self.config.patches
        return azimuths

    @cached_property
    def rules(self) -> Rules:
        """How patches vote, as configured."""
        return rules_of(self.config)


def rules_of(config: GazeConfig) -> Rules:
    """The part of a configuration that decides how patches vote."""
    return Rules(config.sharpness, config.outlier_share, config.consensus_m, config.width_deg)


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
    if front_end.phase_encoder is None:
        raise ConfigError(
            f"a map of gazes needs a camera that looks all around, that of {recordings[0].name!r} is "
            f"{front_end.camera.model}; use andante map for it"
        )
    encoder = PatchEncoder(*front_end.panorama_shape, config.width_deg, config.cell_deg)
    drives = [read_drive(one, front_end, encoder, config, progress=progress) for one in recordings]
    require_distinct([drive.session for drive in drives])
    return learn_gaze_map(drives, front_end, encoder, config, name=name)


def learn_gaze_map(
    drives: Sequence[GazeDrive], front_end: FrontEnd, encoder: PatchEncoder, config: GazeConfig, *, name: str = "gaze"
) -> GazeMap:
    """What ``build_gaze_map`` does once the pictures have become fields."""
    with one_thread():
        model = learn_gaze(drives, encoder, config)
        gallery = gallery_of(drives, encoder, model, config)
        bounds = calibrated(drives, encoder, config, rules_of(config))
    sources = tuple(drive.session.source for drive in drives)
    return GazeMap(config, front_end, encoder, model, gallery, bounds, sources, name)


def _odds(seen: Verdict) -> float:
    """That any of the rivals is right, against the winner."""
    return float(sum(np.exp(-behind) for *_, behind in seen.rivals))
