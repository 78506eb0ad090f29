"""Whether a pose is to be believed: a status with hysteresis, and the reason for it in words.

A filter's own spread knows only of errors that the filter thinks of. So a pose is called ok only where images,
one after the other and each from a little farther on, agreed with what odometry made of the ones before; an image that
contradicts ends that at once, and enough of them lose the pose.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

from andante.data import Status
from andante.localization.config import JudgeConfig
from andante.localization.motion import Step

Opinion = Literal["agrees", "contradicts", "silent"]
_OFF_MAP_RUN = 3
_LOST_RADII = 1.2


@dataclass(frozen=True, slots=True)
class Belief:
    """What of a filter decides how far it is believed.

    ``radius_m`` holds 90 % of it, ``core_radius_m`` 90 % of its best cluster, ``share`` is the weight of that cluster;
    ``moved_m`` is how far it is from where the one before was to be, ``rivals`` says where else the robot may be.
    ``image_radius_m`` is what images that name a pose have of late, ``misfit_m`` how badly they fit the way
    and ``agreement`` how many of them agreed with the prediction.
    """

    radius_m: float
    core_radius_m: float
    share: float
    moved_m: float
    rivals: str = ""
    image_radius_m: float = 0.0
    misfit_m: float = 0.0
    agreement: float = 1.0


@dataclass(frozen=True, slots=True)
class Testimony:
    """What was seen in one frame: an opinion on the prediction, the status of the image, and what was out of order.

    ``sure`` says whether what was seen is believed by itself.
    """

    opinion: Opinion
    image: Status | None
    why: str
    sure: bool = False
    notes: Sequence[str] = ()


@dataclass(frozen=True, slots=True)
class Judge:
    """Points for agreement, and how long there has been none.

    ``fresh_m`` is the way since the last point, ``since_m`` and ``since_s`` way and time since a sure image agreed;
    ``contradicted`` and ``off_map`` count images in a row, ``ok`` says whether the last status was that.
    """

    points: int = 0
    fresh_m: float = 0.0
    since_m: float = 0.0
    since_s: float = 0.0
    contradicted: int = 0
    off_map: int = 0
    ok: bool = False

    def moved(self, step: Step, walk_m: float) -> Judge:
        """After a step; ``walk_m`` is its length where odometry does not know it."""
        way = step.way_m if step.known else walk_m
        return replace(
            self,
            fresh_m=self.fresh_m + way,
            since_m=self.since_m + way,
            since_s=self.since_s + step.duration_s,
        )

    def heard(self, testimony: Testimony, belief: Belief | None, config: JudgeConfig) -> Judge:
        """After one frame's evidence was taken in."""
        judge = replace(self, off_map=self._off_map_run(testimony))
        misfits = belief is not None and belief.misfit_m > config.misfit_m
        if misfits or self._long_unconfirmed(config):  # one image that agrees by and by proves little
            judge = replace(judge, points=min(judge.points, max(config.trusted_points - 3, 1)))
        if belief is not None and belief.moved_m > config.far_m:  # it went over to another place
            judge = replace(judge, points=min(judge.points, 1), fresh_m=0.0)
        if testimony.opinion == "agrees":
            fresh = judge.points == 0 or judge.fresh_m >= config.fresh_m
            # Doubtful images, however many, make no trusted pose.
            most = config.max_points if testimony.sure else max(config.trusted_points - 1, judge.points)
            points = min(judge.points + fresh, most)
            fresh_m = 0.0 if fresh else judge.fresh_m
            judge = replace(judge, points=points, fresh_m=fresh_m, contradicted=0)
            if testimony.sure:
                judge = replace(judge, since_m=0.0, since_s=0.0)
        elif testimony.opinion == "contradicts":
            judge = replace(judge, points=max(judge.points - 1, 0), contradicted=judge.contradicted + 1)
        return replace(judge, ok=belief is not None and judge._trusts(belief, config))

    def status(self, belief: Belief | None, testimony: Testimony, config: JudgeConfig) -> tuple[Status, str]:
        """How far the pose is believed, and why."""
        notes = "".join(f"; {note}" for note in testimony.notes)
        if belief is None:
            return self._without_pose(), f"no image has named a place yet: {testimony.why}{notes}"
        if self.points == 0:
            return self._without_pose(), f"{self._lost(testimony)}{notes}"
        if belief.core_radius_m > max(config.lost_radius_m, _LOST_RADII * belief.image_radius_m):
            unsure = f"somewhere within {belief.core_radius_m:.1f} m"
            return self._without_pose(), f"{unsure}: {self._unconfirmed(testimony)}{notes}"
        if self.ok:
            return Status.OK, f"images and odometry agree{notes}"
        return Status.DEGRADED, f"{self._doubt(belief, testimony, config)}{notes}"

    def _trusts(self, belief: Belief, config: JudgeConfig) -> bool:
        """Ok begins and ends at different bounds, so that it does not flicker."""
        return (
            self.contradicted == 0
            and self.off_map == 0
            and self.points >= config.trusted_points - (1 if self.ok else 0)
            and belief.radius_m <= config.ok_radius_m * (1.2 if self.ok else 1.0)
            and belief.misfit_m <= config.misfit_m * (1.0 if self.ok else 0.8)
            and belief.agreement >= config.agreement
            and 1 - belief.share <= config.rival_share * (1.0 if self.ok else 0.5)
            and not self._long_unconfirmed(config)
        )

    def _long_unconfirmed(self, config: JudgeConfig) -> bool:
        return self.since_m > config.unconfirmed_m or self.since_s > config.unconfirmed_s

    def _off_map_run(self, testimony: Testimony) -> int:
        if testimony.image is None:
            return self.off_map
        return self.off_map + 1 if testimony.image == Status.OFF_MAP else 0

    def _without_pose(self) -> Status:
        return Status.OFF_MAP if self.off_map >= _OFF_MAP_RUN else Status.LOST

    def _lost(self, testimony: Testimony) -> str:
        if self.contradicted:
            return f"the last {self.contradicted} images contradict odometry"
        return f"no image has been believed yet: {testimony.why}"

    def _unconfirmed(self, testimony: Testimony) -> str:
        return f"no image that is sure confirmed it for {self.since_m:.1f} m and {self.since_s:.0f} s ({testimony.why})"

    def _doubt(self, belief: Belief, testimony: Testimony, config: JudgeConfig) -> str:
        """The gravest of what keeps the pose from being ok."""
        now = testimony.opinion == "contradicts"
        doubts = (
            (self.contradicted > 0, testimony.why if now else "the last image contradicts odometry"),
            (self.off_map > 0, f"the image looks like no mapped place: {testimony.why}"),
            (1 - belief.share > config.rival_share / 2, f"it may be elsewhere: {belief.rivals}"),
            (
                belief.misfit_m > 0.8 * config.misfit_m,
                f"images lie {belief.misfit_m:.2f} m off the way that odometry tells; is this off the mapped paths?",
            ),
            (belief.agreement < config.agreement, "images and odometry disagree too often"),
            (self._long_unconfirmed(config), self._unconfirmed(testimony)),
            (belief.radius_m > config.ok_radius_m, f"within {belief.radius_m:.1f} m, ok is {config.ok_radius_m:.1f} m"),
        )
        few = f"{self.points} of {config.trusted_points} images along the way agree with odometry so far"
        return next((doubt for holds, doubt in doubts if holds), few)
