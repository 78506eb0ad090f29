"""Recordings and a detector in, a map with landmarks out."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import count

from andante.data import CameraSpec, Frame
from andante.errors import ConfigError
from andante.landmarks.boxes import Detection
from andante.landmarks.views import ViewCutter
from andante.mapping.config import Positions
from andante.mapping.frontend import camera_and_size
from andante.mapping.landmark_config import LandmarkConfig
from andante.mapping.landmark_lesson import Spotter, collect
from andante.mapping.landmarks import LandmarkDetector, LandmarkMap
from andante.mapping.sessions import Progress
from andante.mapping.slow_map import SlowMap
from andante.protocols import Recording
from andante.sfa import one_thread


def add_landmarks(
    slowmap: SlowMap,
    recordings: Sequence[Recording],
    detector: LandmarkDetector,
    config: LandmarkConfig | None = None,
    *,
    progress: Progress | None = None,
) -> SlowMap:
    """The same map with the landmarks that ``detector`` finds in recordings of the same place and frame of reference.

    Localizing goes by them as well from then on. ``progress`` is told of ``landmarks``. Raises ``ConfigError`` for a
    map of numbered places or of odometry, or a camera that is no fisheye, ``LearningError`` where no landmark is seen
    often enough.
    """
    if slowmap.unit != "m" or slowmap.config.positions == "odometry":
        raise ConfigError(
            "landmarks need reference poses in metres, and this map was made from "
            f"{slowmap.config.positions}; record with reference poses (x_m, y_m, heading_rad in frames.csv)"
        )
    landmarks = map_landmarks(recordings, detector, config, progress=progress)
    return replace(slowmap, landmarks=landmarks).with_detector(detector)


def check_drives(recordings: Sequence[Recording], positions: Positions = "auto") -> None:
    """Raise ``ConfigError`` for drives that no landmark can be mapped from: before the work that would be lost.

    ``positions`` are those that the map is asked to be made from.
    """
    if positions not in ("auto", "reference"):
        raise ConfigError(
            f"landmarks need reference poses in metres, a map with positions = {positions!r} goes without; ask for "
            "reference, or leave landmarks out"
        )
    for one in recordings:
        if one.camera.model != "fisheye":
            raise ConfigError(
                f"views of landmarks are cut out of fisheye images, the camera of {one.name!r} is a "
                f"{one.camera.model}; record with a fisheye or leave landmarks out"
            )
        if all(info.reference is None for info in one.infos):
            raise ConfigError(
                f"landmarks need reference poses in metres, {one.name!r} has none; record with reference poses "
                "(x_m, y_m, heading_rad in frames.csv)"
            )


def map_landmarks(
    recordings: Sequence[Recording],
    detector: LandmarkDetector,
    config: LandmarkConfig | None = None,
    *,
    progress: Progress | None = None,
) -> LandmarkMap:
    """Landmarks alone; raises ``LearningError`` where none is seen often enough, ``ConfigError`` for other cameras."""
    config, drives = config or LandmarkConfig(), list[tuple[Recording, ViewCutter, Spotter]]()
    total, done = sum(info.reference is not None for one in recordings for info in one.infos), count(1)

    def spotter(camera: CameraSpec) -> Spotter:
        def spot(frame: Frame) -> Sequence[Detection]:
            if progress is not None:
                progress("landmarks", next(done), total)
            return detector.detect(frame.image, camera)

        return spot

    for recording in recordings:
        camera, shape = camera_and_size(recording)
        drives.append((recording, ViewCutter(camera, shape), spotter(camera)))
    with one_thread():
        return LandmarkMap.learn(collect(drives, config.window), config)
