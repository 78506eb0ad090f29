"""What a robot senses on its way, as values: sensed once, then changed, cut and followed by any tracker."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from andante.angles import wrapped
from andante.data import Estimate, FloatArray, Frame, FrameInfo, ImageArray, Pose2D, Trajectory
from andante.errors import RecordingError
from andante.localization import Evidence, KalmanTracker, ParticleTracker, evidence_of
from andante.localization.motion import Step
from andante.mapping import Progress, SlowMap
from andante.protocols import Recording
from andante.recordings import map_frames
from andante.sfa import one_thread


@dataclass(frozen=True, eq=False)
class Ride:
    """Frame by frame what is known (``infos``, with odometry and truth) and what the picture says, if there is one.

    Frames come as they come to the robot: late, twice or out of order as well.
    """

    infos: tuple[FrameInfo, ...]
    evidence: tuple[Evidence | None, ...]

    def __post_init__(self) -> None:
        if len(self.infos) != len(self.evidence):
            raise RecordingError(f"a ride of {len(self.infos)} frames has evidence of {len(self.evidence)}")

    def __len__(self) -> int:
        return len(self.infos)

    def taken(self, order: Sequence[int]) -> Ride:
        """These frames in this order."""
        return Ride(tuple(self.infos[at] for at in order), tuple(self.evidence[at] for at in order))

    def with_odometry(self, poses: Sequence[Pose2D | None]) -> Ride:
        """The same with another odometry."""
        infos = tuple(replace(info, odometry=pose) for info, pose in zip(self.infos, poses, strict=True))
        return replace(self, infos=infos)

    def steps(self) -> FloatArray:
        """(n, 3) odometry from the frame before, in the robot's frame there: forward, left in metres, turn in radians.

        The first leads from the last frame to the first by true poses, as on a closed lap.
        """
        believed = Trajectory.of(self.infos, "odometry")
        truth = Trajectory.of([self.infos[-1], self.infos[0]], "reference")
        return np.concatenate([_steps(truth), _steps(believed)])


def composed(steps: FloatArray, start: Pose2D | None = None) -> list[Pose2D]:
    """Odometry (n poses) that begins at ``start`` and then makes ``steps[1:]`` (n, 3); ``steps[0]`` is not made."""
    at = start or Pose2D(0.0, 0.0, 0.0)
    poses = [at]
    for forward, left, turn in steps[1:].tolist():
        at = Step(forward, left, turn).after(at)
        poses.append(at)
    return poses


def around(ride: Ride, start: int, frames: int) -> Ride:
    """``frames`` frames from ``start`` on, lap after lap, with an odometry of their own and times that go on."""
    order = (start + np.arange(frames)) % len(ride)
    times = np.array([info.timestamp_s for info in ride.infos])
    pauses = np.diff(times)
    waits = np.concatenate([[np.median(pauses)], pauses])[order]
    odometry = composed(ride.steps()[order])
    at_s = times[0] + np.cumsum(waits) - waits[0]
    infos = tuple(
        replace(ride.infos[old], index=number, timestamp_s=float(time), odometry=pose)
        for number, (old, time, pose) in enumerate(zip(order, at_s, odometry, strict=True))
    )
    return Ride(infos, tuple(ride.evidence[old] for old in order))


def sensed(
    slowmap: SlowMap,
    recording: Recording,
    *,
    through: Callable[[ImageArray], ImageArray] = lambda image: image,
    progress: Progress | None = None,
) -> Ride:
    """A whole recording as a map sees it, every picture ``through`` something first.

    Raises ``RecordingError`` where a picture cannot be read.
    """
    slowmap, found = slowmap.for_recording(recording), list[Evidence]()

    def see(frame: Frame) -> Evidence:
        return evidence_of(slowmap, through(frame.image))

    with one_thread():
        for _, evidence in map_frames(recording, see):
            found.append(evidence)
            if progress is not None:
                progress(f"see {recording.name}", len(found), len(recording.infos))
    if len(found) != len(recording.infos):
        raise RecordingError(f"recording {recording.name!r} lacks pictures; remove it to render it anew")
    return Ride(tuple(recording.infos), tuple(found))


def followed(tracker: ParticleTracker | KalmanTracker, ride: Ride) -> list[Estimate]:
    """What a tracker says of every frame, as it comes."""
    return [tracker.fuse(seen, info) for seen, info in zip(ride.evidence, ride.infos, strict=True)]


def overexposed(image: ImageArray) -> ImageArray:
    """A camera that looks into the sun: all but the darkest tenth of what it sees is burnt out."""
    seen = image[image > 0]
    darkest = float(np.quantile(seen, 0.1)) if len(seen) else 0.0
    burnt = np.where(image > 0, 255.0 + 6.0 * (image - darkest), 0.0)
    return np.clip(burnt, 0, 255).astype(np.uint8)


def covered(image: ImageArray) -> ImageArray:
    """A covered lens: black."""
    return np.zeros_like(image)


def _steps(poses: Trajectory) -> FloatArray:
    """(n - 1, 3) from one pose to the next, in the frame of the first of them."""
    apart, heading = np.diff(poses.xy_m, axis=0), poses.heading_rad[:-1]
    cos, sin = np.cos(heading), np.sin(heading)
    turn = wrapped(np.diff(poses.heading_rad))
    return np.stack([cos * apart[:, 0] + sin * apart[:, 1], cos * apart[:, 1] - sin * apart[:, 0], turn], axis=1)
