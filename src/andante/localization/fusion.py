"""What both trackers share: frames in any order, odometry of any quality, images and fixes, and a verdict."""

from __future__ import annotations

import math
from dataclasses import replace
from functools import cached_property
from pathlib import Path

import numpy as np

from andante.data import Estimate, Fix, Frame, FrameInfo, ImageArray, Status
from andante.errors import InputError, MapError
from andante.localization.config import KalmanConfig, ParticleConfig
from andante.localization.evidence import Evidence, evidence_of
from andante.localization.faults import Heard, listen
from andante.localization.filters import Filter, Weighted
from andante.localization.judge import Belief, Opinion, Testimony
from andante.localization.memory import Memory
from andante.localization.motion import Step
from andante.localization.sighting import Sighting, sighting_of_fix, sighting_of_image
from andante.localization.state import Owner, State, read_state, write_state
from andante.localization.witness import opinion_of
from andante.mapping.slow_map import SlowMap

_NO_PICTURE = "there is no picture"


class FusingTracker:
    """Feeds a filter and judges it; ``ParticleTracker`` and ``KalmanTracker`` choose the filter."""

    name = "tracker"

    def __init__(self, slowmap: SlowMap, config: ParticleConfig | KalmanConfig) -> None:
        if slowmap.unit != "m":
            raise InputError(
                "a map of numbered places has no metres to move through, so odometry is of no use; use andante "
                "localize, or build the map from recordings with poses or odometry"
            )
        self._map, self._config = slowmap, config
        self.reset()

    @property
    def config(self) -> ParticleConfig | KalmanConfig:
        """What it assumes."""
        return self._config

    def reset(self) -> None:
        """Forget everything."""
        self._filter = self._new_filter()
        self._memory = Memory()
        self._estimate = Estimate(Status.LOST, "no frame has been seen yet")

    def see(self, image: ImageArray) -> Evidence:
        """What one image says: grey or BGR uint8; leaves the tracker as it is, so that many threads may call it."""
        return evidence_of(self._map, image)

    def update(self, frame: Frame, fix: Fix | None = None) -> Estimate:
        """One frame, and a position from elsewhere where there is one; raises ``ImageError`` for a foreign size."""
        return self.fuse(self.see(frame.image), frame.info, fix)

    def fuse(self, evidence: Evidence | None, info: FrameInfo, fix: Fix | None = None) -> Estimate:
        """The same from what ``see`` made of the image; ``None`` is no image, and odometry has to do.

        A frame that is older than the newest one, or has its time stamp, changes nothing and gives the estimate of that
        one.
        """
        odometer, step = self._memory.odometer.take(info, self._config.motion)
        memory = replace(self._memory, odometer=odometer)
        if step is None:
            self._memory = memory
            return self._estimate
        self._filter.move(step)
        memory = memory.moved(step, self._config.motion.walk_m * math.sqrt(step.duration_s))
        memory, seen, testimony = self._heard(memory, step, evidence, fix)
        self._filter.correct(seen, memory.trail, doubt=memory.doubt)
        belief = memory.informed(self._filter.belief)
        judge = memory.judge.heard(testimony, belief, self._config.judge)
        if belief is not None and belief.moved_m > self._config.judge.far_m:
            memory = replace(memory, trail=memory.trail.begun_anew())
        self._memory = replace(memory, judge=judge)
        self._estimate = self._told(*judge.status(belief, testimony, self._config.judge), belief)
        return self._estimate

    def save(self, path: str | Path) -> None:
        """Write the whole state to a file, atomically; raises ``MapError`` where that fails."""
        state = State(self._memory, self._filter.to_arrays(), self._filter.generator_state, self._estimate)
        write_state(state, self._owner, path)

    def resume(self, path: str | Path) -> None:
        """Go on from a file as if there had been no stop.

        Raises ``MapError`` for a file that is damaged or belongs to another map, kind or configuration; the tracker is
        as it was then.
        """
        state = read_state(path, self._owner)
        resumed = self._new_filter()
        try:
            resumed.resume(state.filter_arrays, state.generator)
        except (ValueError, KeyError, TypeError) as error:
            raise MapError(f"tracker state {path} cannot be used: {error}; begin without it") from None
        self._filter, self._memory, self._estimate = resumed, state.memory, state.estimate

    @cached_property
    def _owner(self) -> Owner:
        return Owner.of(self.name, self._map, self._config)

    def _new_filter(self) -> Filter:
        raise NotImplementedError

    def _heard(
        self, memory: Memory, step: Step, evidence: Evidence | None, fix: Fix | None
    ) -> tuple[Memory, list[Weighted], Testimony]:
        """What the frame's image and fix say of the prediction, and what the memory is after that."""
        config, predicted = self._config, self._filter.best
        memory, heard = self._listened(memory, evidence)
        sightings = self._sightings(evidence, fix, faulty=bool(heard and heard.fault))
        opinions = {one: opinion_of(one, predicted, config.judge) for one in sightings}
        seen = []
        for one, (opinion, _) in opinions.items():
            elsewhere = opinion == "contradicts" or not one.trusted
            seen.append(memory.news(one).weighted(one, predicted, config.sighting, contradicts=elsewhere))
            memory = memory.with_sighting(one, opinion, predicted)
        if evidence is not None:
            memory = memory.with_radius(evidence.estimate)
        return memory, seen, _testimony(evidence, heard, opinions, step)

    def _listened(self, memory: Memory, evidence: Evidence | None) -> tuple[Memory, Heard | None]:
        """Whether slow features moved slowly."""
        if evidence is None or evidence.slow is None:
            return memory, None
        heard = listen(memory.pulse, evidence.slow, memory.good, memory.last, self._config.fault)
        good = evidence.slow if heard.good else memory.good
        return replace(memory, pulse=heard.pulse, good=good, last=evidence.slow), heard

    def _sightings(self, evidence: Evidence | None, fix: Fix | None, *, faulty: bool) -> list[Sighting]:
        image = None
        if evidence is not None:
            image = sighting_of_image(evidence.estimate, self._config.sighting, faulty=faulty)
        return [one for one in (image, sighting_of_fix(fix)) if one is not None]

    def _told(self, status: Status, reason: str, belief: Belief | None) -> Estimate:
        best, hypotheses = self._filter.best, self._filter.hypotheses
        if best is None or belief is None or not status.has_pose:
            return Estimate(status, reason, hypotheses=hypotheses)
        x, y, heading = best.mean.tolist()
        covariance = best.covariance.copy()
        if not best.heading_known:
            covariance[2], covariance[:, 2] = np.nan, np.nan
        return Estimate(
            status,
            reason,
            x,
            y,
            heading if best.heading_known else None,
            covariance,
            belief.radius_m,
            hypotheses=hypotheses,
        )


def _testimony(
    evidence: Evidence | None, heard: Heard | None, opinions: dict[Sighting, tuple[Opinion, str]], step: Step
) -> Testimony:
    """All opinions of one frame as one: who agrees counts more than who contradicts."""
    notes = [step.note] if step.note else []
    if heard is not None and heard.fault:
        notes.append(heard.fault)
    if heard is not None and heard.carried:
        notes.append("several images agree that the robot was carried elsewhere")
    image = None if evidence is None else evidence.estimate.status
    ranked = sorted(opinions.values(), key=lambda one: ("agrees", "contradicts", "silent").index(one[0]))
    if not ranked:
        why = _NO_PICTURE if evidence is None else evidence.estimate.reason
        return Testimony("silent", image, why, False, notes)
    opinion, why = ranked[0]
    if opinion == "agrees":
        notes.extend(other for one, other in ranked if one == "contradicts")
    elif opinion == "silent" and evidence is not None:
        why = evidence.estimate.reason
    sure = any(one.status == Status.OK and said == opinion for one, (said, _) in opinions.items())
    return Testimony(opinion, image, why, sure, notes)
