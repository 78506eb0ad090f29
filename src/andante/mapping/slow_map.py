"""The map: one value that turns an image into an estimate, and fits into one small file."""

from __future__ import annotations

import contextlib
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from numpy.typing import NDArray

from andante.data import CameraSpec, Estimate, FloatArray, Hypothesis, ImageArray, Status
from andante.errors import BlankImageError, ImageError, MapError
from andante.mapping.calibration import Calibration, Fold
from andante.mapping.compact import CompactModel
from andante.mapping.compass import Compass
from andante.mapping.config import MapConfig
from andante.mapping.frontend import Encoded, FrontEnd
from andante.mapping.judgement import judge
from andante.mapping.landmark_joint import joined
from andante.mapping.landmarks import LandmarkDetector, LandmarkEye, LandmarkMap
from andante.mapping.located import Readout
from andante.mapping.locating import Locator, Sighting
from andante.mapping.memory import MappedSession, Source
from andante.mapping.off_path import weighed
from andante.mapping.scenery import Scenery
from andante.mapping.sessions import short_fingerprint
from andante.mapping.uncertainty import covariance_of
from andante.protocols import Recording
from andante.recordings import picture_fingerprint

Unit = Literal["m", "place"]

_SAMPLED_PICTURES = 100


@dataclass(frozen=True, eq=False)
class SlowMap:
    """What is needed to localize, and where it came from; made by ``build_map`` or ``SlowMap.load``.

    ``config`` is how the map was made, with every default resolved, ``asked`` how it was asked for, with what was left
    open. ``compass`` tells headings, where those of the drives are known and the camera looks all around; ``scenery``
    finds images that were taken away from all mapped places. ``pictures`` are the fingerprints of each source's frames.
    ``memory`` are the sessions themselves, where the map remembers them: what ``andante update`` learns from again.
    ``landmarks`` are those that were taught here; they count in estimates once ``with_detector`` says who finds them,
    which a map that was loaded knows where the detector is a file, as learnt ones are: it lies in the map.
    """

    config: MapConfig
    asked: MapConfig
    front_end: FrontEnd
    model: CompactModel
    readout: Readout
    compass: Compass | None
    scenery: Scenery | None
    calibration: Calibration
    sources: tuple[Source, ...]
    pictures: tuple[NDArray[np.uint32], ...] = field(repr=False)
    unit: Unit = "m"
    name: str = "andante"
    memory: tuple[MappedSession, ...] | None = field(default=None, repr=False)
    landmarks: LandmarkMap | None = None

    @classmethod
    def load(cls, path: str | Path, *, with_memory: bool = False) -> SlowMap:
        """Read a map file; raises ``MapError`` for anything but a complete map of a known schema.

        Localizing needs no memory of the mapped frames, which may be many times larger than all else, so it stays in
        the file unless it is asked for; a map that is saved without it cannot be updated any more.
        """
        from andante.mapping.artifact import read_map

        return read_map(path, with_memory=with_memory)

    def save(self, path: str | Path) -> int:
        """Write the map atomically and return its size in bytes; raises ``MapError`` where that fails."""
        from andante.mapping.artifact import write_map

        return write_map(self, path)

    def for_recording(self, recording: Recording) -> SlowMap:
        """The same map for the camera of a recording, whose image circle is found where it is not declared."""
        front_end = self.front_end.for_recording(recording) if recording.infos else self.front_end
        return self if front_end is self.front_end else replace(self, front_end=front_end)

    def for_camera(self, camera: CameraSpec, image: ImageArray) -> SlowMap:
        """The same map for another camera, ``image`` being one of its pictures."""
        return replace(self, front_end=self.front_end.with_camera(camera, (image.shape[0], image.shape[1])))

    def with_detector(self, detector: LandmarkDetector) -> SlowMap:
        """The same map, which goes by its landmarks as well, as ``detector`` finds them in images.

        Raises ``MapError`` for a map without landmarks, ``ConfigError`` for one of a camera that is no fisheye.
        """
        if self.landmarks is None:
            raise MapError("this map has no landmarks to look for; teach some with: andante teach")
        landmarks = self.landmarks.with_detector(detector)
        eye = LandmarkEye(landmarks, detector, self.front_end.camera, self.front_end.image_shape)
        return replace(self, front_end=self.front_end.with_landmarks(eye), landmarks=landmarks)

    def slow_features(self, image: ImageArray) -> FloatArray:
        """(height, width[, 3]) uint8 -> (k,) slow features, slowest first."""
        slow: FloatArray = self.model.transform(self.front_end.features(image)[None])[0]
        return slow

    def localize(self, image: ImageArray) -> Estimate:
        """Where an image was taken: grey (height, width) or BGR (height, width, 3) uint8.

        A picture that shows nothing gives status lost; one of the wrong size raises ``ImageError``.
        """
        try:
            encoded = self.front_end.encode(image)
        except BlankImageError as error:
            return Estimate(Status.LOST, str(error))
        return self.estimate(encoded)

    def sight(self, encoded: Encoded, slow: FloatArray | None = None) -> Sighting:
        """What the map says of n pictures; ``slow`` (n, k) are their slow features, where they are known already."""
        slow = self.model.transform(encoded.features) if slow is None else slow
        return Locator(self.readout, self.compass).sight(slow, self.model.spread(encoded.features), encoded.phase)

    def estimate(self, encoded: Encoded, slow: FloatArray | None = None) -> Estimate:
        """The same as ``localize`` from one picture that is encoded already, and ``slow`` (1, k) as for ``sight``."""
        whole = self._by_whole_image(encoded, slow)
        if self.landmarks is None or encoded.landmarks is None:
            return whole
        sights = self.landmarks.sights(encoded.landmarks[0])
        return joined(whole, self.landmarks.estimate_of(sights), sights)

    def _by_whole_image(self, encoded: Encoded, slow: FloatArray | None) -> Estimate:
        """What slow features and phases of the panorama say, landmarks or not."""
        sighting = self.sight(encoded, slow)
        on_path = self._on_path(sighting, encoded)
        bounds = self.calibration.views
        if self.scenery is None or bounds is None:
            return on_path
        peak = _peak(sighting)
        spot = self.scenery.search(encoded.phase[0], bounds.least_alike(on_path, peak))
        return on_path if spot is None else weighed(on_path, peak, spot, bounds)

    def _on_path(self, sighting: Sighting, encoded: Encoded) -> Estimate:
        """What the mapped places say."""
        status, reason = judge(sighting, self.calibration)
        hypotheses, likeness = self._hypotheses(sighting, encoded), float(np.nan_to_num(sighting.likeness[0]))
        if not status.has_pose:
            return Estimate(status, reason, likeness=likeness, hypotheses=hypotheses)
        x, y = sighting.located.xy[0].tolist()
        if self.unit == "place":
            return Estimate(status, reason, place=round(x), likeness=likeness, hypotheses=hypotheses)
        radius = self.calibration.radius_factor * float(sighting.sigma[0])
        factor = self.calibration.heading_factor
        # Where no trial told how far headings are off, nothing can be promised of them.
        heading = None if factor is None else hypotheses[0].heading_rad
        off = np.nan if factor is None or heading is None else factor * float(sighting.doubt[0])
        covariance = covariance_of(sighting.located.covariance[0], radius, off)
        return Estimate(status, reason, x, y, heading, covariance, radius, likeness=likeness, hypotheses=hypotheses)

    def describe(self) -> dict[str, Any]:
        """What is in the map, as plain values."""
        return {
            "unit": self.unit,
            "features": self.front_end.feature_kind,
            "feature_dim": self.model.input_dim,
            "slow_features": self.model.output_dim,
            "deltas": [float(delta) for delta in self.model.deltas],
            "panorama_px": [self.front_end.panorama_shape[1], self.front_end.panorama_shape[0]],
            "heading_invariant": self.heading_invariant,
            "tells_heading": self.tells_heading,
            "compass_places": 0 if self.compass is None else len(self.compass.codes),
            "updatable": self.asked.memory.keep,
            "landmarks": [] if self.landmarks is None else self.landmarks.describe(),
            "weak_places": [] if self.landmarks is None else [one.as_dict() for one in self.landmarks.weak_places()],
            "recordings": [
                {
                    "name": source.name,
                    "content_hash": source.content_hash,
                    "frames": source.frames,
                    "poses": source.poses,
                    "conditions": dict(source.conditions),
                    "skipped": list(source.skipped),
                }
                for source in self.sources
            ],
            "cross_validation": {
                "kind": self.calibration.kind,
                "folds": [self._fold(fold) for fold in self.calibration.folds],
            },
            "config": self.config.model_dump(mode="json"),
        }

    def _fold(self, fold: Fold) -> dict[str, Any]:
        conditions = [dict(self.sources[session].conditions) for session in fold.sessions]
        values = {key: value for key, value in vars(fold).items() if key != "sessions"}
        return values | {"conditions": conditions if self.calibration.kind == "sessions" else []}

    @property
    def heading_invariant(self) -> bool:
        """Whether features are the same whichever way the robot looks."""
        return self.front_end.feature_kind == "fourier" and self.front_end.camera.heading_invariant

    @property
    def tells_heading(self) -> bool:
        """Whether estimates say which way the robot looks."""
        return self.compass is not None and self.calibration.heading_factor is not None and self.unit == "m"

    def learnt_from(self, content_hash: str) -> bool:
        """Whether a recording with this content is in the map."""
        return any(source.content_hash == content_hash for source in self.sources)

    def share_learnt(self, recording: Recording) -> float:
        """The share of a recording's pictures that are in the map, by up to 100 of them spread over it."""
        count = len(recording.infos)
        sample = np.unique(np.linspace(0, count - 1, min(count, _SAMPLED_PICTURES)).astype(int)).tolist()
        seen: list[int] = []
        for index in sample:
            with contextlib.suppress(ImageError):  # where all are read it is judged whether too many are missing
                seen.append(short_fingerprint(picture_fingerprint(recording.load(recording.infos[index]))))
        return float(np.isin(seen, np.concatenate(self.pictures)).sum()) / max(1, len(seen))

    def _hypotheses(self, sighting: Sighting, encoded: Encoded) -> tuple[Hypothesis, ...]:
        """The estimate itself with what speaks for it, then the other candidates."""
        located = sighting.located
        rivals = np.flatnonzero(located.weights[0] > 0)
        xy = np.concatenate([located.xy, located.candidates[0][rivals]])
        weights = [float(located.agreement[0]), *located.weights[0][rivals].tolist()]
        headings: list[float | None] = [None] * len(xy)
        if self.compass is not None and np.isfinite(xy).all():
            found = self.compass.bearings(np.repeat(encoded.phase, len(xy), axis=0), xy).heading
            headings = [heading if np.isfinite(heading) else None for heading in found.tolist()]
        return tuple(
            Hypothesis(x, y, weight, heading)
            for (x, y), weight, heading in zip(xy.tolist(), weights, headings, strict=True)
        )


def _peak(sighting: Sighting) -> float:
    """How alike the image and the mapped place are; 0 where nothing tells."""
    return 0.0 if sighting.bearings is None else float(np.nan_to_num(sighting.bearings.peak[0]))
