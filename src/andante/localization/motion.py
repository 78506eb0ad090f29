"""From odometry to steps: only what changed between two consecutive frames is used, and only where it is plausible."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from andante.data import FrameInfo, Pose2D
from andante.localization.config import MotionConfig

_STANDING_M = 0.01
_LATE, _SET_BACK_S = 20, 1.0


@dataclass(frozen=True, slots=True)
class Step:
    """What a robot did since the frame before, in its own frame back then.

    ``known`` is false where odometry could not tell; ``note`` says why, empty where it could.
    """

    forward_m: float = 0.0
    left_m: float = 0.0
    turn_rad: float = 0.0
    duration_s: float = 0.0
    known: bool = True
    note: str = ""

    @property
    def way_m(self) -> float:
        """How far it went."""
        return math.hypot(self.forward_m, self.left_m)

    def after(self, pose: Pose2D) -> Pose2D:
        """Where the step leads from a pose, whose heading is zero where it is unknown."""
        heading = pose.heading_rad or 0.0
        dx, dy = self.seen_from(heading)
        return Pose2D(pose.x_m + dx, pose.y_m + dy, heading + self.turn_rad)

    def seen_from(self, heading_rad: float) -> tuple[float, float]:
        """The way along x and y of a robot that looked there before."""
        cos, sin = math.cos(heading_rad), math.sin(heading_rad)
        return cos * self.forward_m - sin * self.left_m, sin * self.forward_m + cos * self.left_m


@dataclass(frozen=True, slots=True)
class Odometer:
    """The newest frame's time and odometry: all that has to be remembered to tell the next step.

    Where odometry has no headings, the direction of travel stands in for them: a robot without a compass is taken to
    drive forwards. ``late`` counts frames that came after newer ones, in a row and in order among themselves, and
    ``late_s`` is the time of the last of them: twenty of them are no latecomers, the clock was set back.
    """

    timestamp_s: float | None = None
    odometry: Pose2D | None = None
    late: int = 0
    late_s: float = -math.inf

    def take(self, info: FrameInfo, config: MotionConfig) -> tuple[Odometer, Step | None]:
        """The odometer after a frame, and the step that led there; none for a frame that is old or repeated."""
        time = info.timestamp_s
        if not math.isfinite(time) or time == self.timestamp_s:
            return self, None
        now = _finite(info.odometry)
        if self.timestamp_s is None:
            return Odometer(time, now), Step()
        if time < self.timestamp_s:
            return self._passed(time, now)
        return self._advanced(time, now, config)

    def _passed(self, time: float, now: Pose2D | None) -> tuple[Odometer, Step | None]:
        """After a frame that is older than the newest one."""
        late = self.late + 1 if time > self.late_s else 1
        if late < _LATE:
            return replace(self, late=late, late_s=time), None
        return Odometer(time, now), Step(duration_s=_SET_BACK_S, known=False, note="the clock was set back")

    def _advanced(self, time: float, now: Pose2D | None, config: MotionConfig) -> tuple[Odometer, Step]:
        """After a newer frame."""
        duration = time - (self.timestamp_s or 0.0)
        if now is None:
            return Odometer(time), Step(duration_s=duration, known=False, note="odometry is missing")
        if self.odometry is None:
            return Odometer(time, now), Step(duration_s=duration, known=False, note="odometry was missing")
        before, now = _with_headings(self.odometry, now)
        return Odometer(time, now), _plausible(_between(before, now, duration), config)


def _finite(pose: Pose2D | None) -> Pose2D | None:
    """Odometry as far as it can be used."""
    if pose is None or not (math.isfinite(pose.x_m) and math.isfinite(pose.y_m)):
        return None
    if pose.heading_rad is not None and not math.isfinite(pose.heading_rad):
        return replace(pose, heading_rad=None)
    return pose


def _with_headings(before: Pose2D, now: Pose2D) -> tuple[Pose2D, Pose2D]:
    if now.heading_rad is None:
        dx, dy = now.x_m - before.x_m, now.y_m - before.y_m
        travels = math.hypot(dx, dy) > _STANDING_M
        now = replace(now, heading_rad=math.atan2(dy, dx) if travels else before.heading_rad)
    return (replace(before, heading_rad=now.heading_rad) if before.heading_rad is None else before), now


def _between(before: Pose2D, now: Pose2D, duration_s: float) -> Step:
    heading, new_heading = before.heading_rad or 0.0, now.heading_rad or 0.0
    cos, sin = math.cos(heading), math.sin(heading)
    dx, dy = now.x_m - before.x_m, now.y_m - before.y_m
    turn = math.remainder(new_heading - heading, 2 * math.pi)
    return Step(cos * dx + sin * dy, cos * dy - sin * dx, turn, duration_s)


def _plausible(step: Step, config: MotionConfig) -> Step:
    """The step itself, or an unknown one where it is faster than the robot can be."""
    speed, rate = step.way_m / step.duration_s, abs(step.turn_rad) / step.duration_s
    if speed > config.max_speed_m_s:
        note = f"odometry jumped {step.way_m:.1f} m in {step.duration_s:.2f} s and was not believed"
    elif rate > config.max_turn_rad_s:
        note = f"odometry turned {math.degrees(step.turn_rad):.0f}° in {step.duration_s:.2f} s and was not believed"
    else:
        return step
    return Step(duration_s=step.duration_s, known=False, note=note)
