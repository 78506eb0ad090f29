"""The particle filter's steps on arrays: move, weigh, draw anew, inject (Thrun, Burgard, Fox 2005, chapter 8)."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from andante.angles import wrapped
from andante.data import FloatArray
from andante.localization.config import MotionConfig, ParticleConfig
from andante.localization.motion import Step
from andante.localization.sighting import Sighting
from andante.localization.trail import Trail

X, Y, HEADING, BIAS, SCALE = range(5)
_BIAS_WALK, _SCALE_WALK = 0.02, 0.02
"""The shares of their deviations by which bias and scale change, in the root of a second and of a metre."""
_SLIP = (0.5, 1.5)
_SLIP_TURN_RAD = 0.03


@dataclass(frozen=True, eq=False)
class Cloud:
    """Particles.

    ``state`` (n, 5): x, y, heading, bias of the gyro in rad/s, and by how much the wheels' size is off. ``weight`` (n,)
    sums to one.
    """

    state: FloatArray
    weight: FloatArray

    @property
    def pose(self) -> FloatArray:
        """(n, 3) x, y, heading."""
        return self.state[:, :3]

    @classmethod
    def around(cls, sighting: Sighting, trail: Trail, config: ParticleConfig, rng: np.random.Generator) -> Cloud:
        """Where a first sighting says."""
        n = config.particles
        return cls(_drawn(sighting, trail, n, config.motion, rng), np.full(n, 1 / n))

    def moved(self, step: Step, config: MotionConfig, rng: np.random.Generator) -> Cloud:
        """After a step, with all that may be wrong with it; at rest nothing changes."""
        if not step.known:
            return replace(self, state=_wandered(self.state, step.duration_s, config, rng))
        if step.way_m == 0 and step.turn_rad == 0:
            return self
        n, state = len(self.weight), self.state.copy()
        noise = rng.normal(size=(4, n))
        slips = rng.random(n) < config.slip_share
        gain = np.where(
            slips, rng.uniform(*_SLIP, n), 1.0 + noise[0] * config.wheel_m / math.sqrt(max(step.way_m, 1e-3))
        )
        gain *= 1.0 - state[:, SCALE]
        turn_sigma = config.turn_rad * math.sqrt(abs(step.turn_rad) + 0.1 * step.way_m)
        turn = step.turn_rad - state[:, BIAS] * step.duration_s
        turn += noise[1] * np.where(slips, _SLIP_TURN_RAD, turn_sigma)
        # The step was taken half-way through its turn, so half of the turn's error is in its direction.
        heading = state[:, HEADING] + (turn - step.turn_rad) / 2
        cos, sin = np.cos(heading), np.sin(heading)
        state[:, X] += gain * (cos * step.forward_m - sin * step.left_m)
        state[:, Y] += gain * (sin * step.forward_m + cos * step.left_m)
        state[:, HEADING] = wrapped(state[:, HEADING] + turn)
        state[:, BIAS] += noise[2] * config.gyro_rad_s * _BIAS_WALK * math.sqrt(step.duration_s)
        state[:, SCALE] += noise[3] * config.scale * _SCALE_WALK * math.sqrt(step.way_m)
        return replace(self, state=state)

    def weighed(self, likelihood: FloatArray) -> Cloud:
        """After a measurement of likelihood (n,), which is positive."""
        weight = self.weight * likelihood
        return replace(self, weight=weight / weight.sum())

    def injected(
        self, sighting: Sighting, trail: Trail, mass: float, config: ParticleConfig, rng: np.random.Generator
    ) -> Cloud:
        """The lightest particles put where a sighting says, with ``mass`` of the weight together."""
        count = int(config.injected_share * len(self.weight))
        if count == 0 or mass <= 0:
            return self
        lightest = np.argpartition(self.weight, count - 1)[:count]
        state, weight = self.state.copy(), self.weight.copy()
        state[lightest] = _drawn(sighting, trail, count, config.motion, rng)
        weight[lightest] = 0.0
        weight *= (1 - mass) / weight.sum()
        weight[lightest] = mass / count
        return Cloud(state, weight)

    def resampled(self, config: ParticleConfig, rng: np.random.Generator) -> Cloud:
        """Drawn anew, systematically, where few particles carry most of the weight."""
        n = len(self.weight)
        if 1 / (self.weight**2).sum() >= config.resample_below * n:
            return self
        comb = (rng.random() + np.arange(n)) / n
        chosen = np.minimum(np.searchsorted(np.cumsum(self.weight), comb), n - 1)
        state = self.state[chosen]
        # Copies are spread a little, or they would never part again while the robot stands.
        state[:, :2] += rng.normal(0.0, config.roughening_m, (n, 2))
        state[:, HEADING] += rng.normal(0.0, config.roughening_rad, n)
        return Cloud(state, np.full(n, 1 / n))


def _drawn(sighting: Sighting, trail: Trail, count: int, config: MotionConfig, rng: np.random.Generator) -> FloatArray:
    xy, heading = sighting.draw(count, rng)
    told = trail.headings(xy, rng)
    bias, scale = rng.normal(0.0, config.gyro_rad_s, count), rng.normal(0.0, config.scale, count)
    return np.column_stack([xy, np.where(np.isfinite(heading), heading, told), bias, scale])


def _wandered(state: FloatArray, duration_s: float, config: MotionConfig, rng: np.random.Generator) -> FloatArray:
    """A random walk."""
    state, root = state.copy(), math.sqrt(duration_s)
    state[:, :2] += rng.normal(0.0, config.walk_m * root, (len(state), 2))
    turned = state[:, HEADING] + rng.normal(0.0, config.walk_rad * root, len(state))
    state[:, HEADING] = wrapped(turned)
    return state
