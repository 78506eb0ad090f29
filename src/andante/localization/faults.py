"""Slow features must move slowly (thesis 10.1): a jump is a fault of the camera, or the robot was carried away.

Over the first half metre the distance between two images in slow-feature space grows about as way^(2/3), then it
saturates (rendered gardens, 1 to 9 mapped sessions: exponents from 0.5 to 0.7). A step divided by that has a
distribution of its own in each light, whose median and spread are learnt on the way by stochastic approximation
(Robbins and Monro 1951): two numbers, whatever was seen.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from andante.data import FloatArray
from andante.localization.config import FaultConfig
from andante.localization.motion import Step

_TURN_M_PER_RAD = 0.3
"""A turn changes an image as much as so much way, in cameras that do not look all around."""
_LEAST_M, _MOST_M, _GROWTH = 0.05, 0.6, 2 / 3
_STANDING_M = 0.02
_AGREEING = 3
"""So many images in a row that jumped together are no fault any more."""


@dataclass(frozen=True, slots=True)
class Pulse:
    """How fast slow features usually move, and how long ago they last did so.

    ``middle`` and ``spread`` are the running median of ln(step / way^(2/3)) and that of its distance from it, ``seen``
    how many steps they were learnt from. ``way_m`` is the way since the last good image, ``step_m`` that since the last
    image; ``run`` counts images that jumped and agree among each other.
    """

    middle: float = 0.0
    spread: float = 0.3
    seen: int = 0
    way_m: float = 0.0
    step_m: float = 0.0
    run: int = 0

    def moved(self, step: Step) -> Pulse:
        """After a step, of an unknown length where odometry cannot tell."""
        way = step.way_m + _TURN_M_PER_RAD * abs(step.turn_rad) if step.known else math.inf
        return replace(self, way_m=self.way_m + way, step_m=self.step_m + way)


@dataclass(frozen=True, eq=False)
class Heard:
    """What an image means for the pulse: ``fault`` is empty for a good image; ``carried`` marks the end of a jump."""

    pulse: Pulse
    fault: str = ""
    good: bool = True
    carried: bool = False


def listen(
    pulse: Pulse, slow: FloatArray, good: FloatArray | None, last: FloatArray | None, config: FaultConfig
) -> Heard:
    """Compare an image's slow features (k,) with those of the last good image and of the last one."""
    if good is None or last is None or good.shape != slow.shape:
        return Heard(replace(pulse, way_m=0.0, step_m=0.0, run=0))
    excess = _excess(pulse, slow, good, pulse.way_m, config)
    if excess <= 1.0:
        if np.array_equal(slow, last) and _STANDING_M < pulse.step_m < math.inf:
            fault = f"the picture stands still although the robot moved {pulse.step_m:.2f} m"
            return Heard(replace(pulse, step_m=0.0), fault, good=False)
        return Heard(replace(_learnt(pulse, slow, last, config), way_m=0.0, step_m=0.0, run=0))
    together = _excess(pulse, slow, last, pulse.step_m, config) <= 1.0
    run = pulse.run + 1 if together and pulse.run > 0 else 1
    if run >= _AGREEING:
        return Heard(replace(pulse, way_m=0.0, step_m=0.0, run=0), carried=True)
    fault = f"what the camera sees jumped, {excess:.1f} times as far as is possible in {pulse.way_m:.2f} m"
    return Heard(replace(pulse, step_m=0.0, run=run), fault, good=False)


def _excess(pulse: Pulse, slow: FloatArray, other: FloatArray, way_m: float, config: FaultConfig) -> float:
    """A step's length over the longest that is believed; nothing is impossible before the usual ones are known."""
    if pulse.seen < config.warm_up or way_m > _MOST_M:
        return 0.0
    longest = pulse.middle + max(config.spreads * pulse.spread, math.log(config.least_factor))
    step = float(np.linalg.norm(slow - other))
    return step / (math.exp(longest) * math.pow(max(way_m, _LEAST_M), _GROWTH))


def _learnt(pulse: Pulse, slow: FloatArray, last: FloatArray, config: FaultConfig) -> Pulse:
    step = float(np.linalg.norm(slow - last))
    if step <= 0 or not _STANDING_M < pulse.step_m <= _MOST_M:
        return pulse
    value = math.log(step / max(pulse.step_m, _LEAST_M) ** _GROWTH)
    if pulse.seen == 0:
        return replace(pulse, middle=value, seen=1)
    gain = max(1.0 / config.memory, 1.0 / (pulse.seen + 1))
    off = value - pulse.middle
    middle = pulse.middle + gain * min(max(off, -pulse.spread), pulse.spread)
    spread = pulse.spread * math.exp(gain * (1.0 if abs(off) > pulse.spread else -1.0))
    return replace(pulse, middle=middle, spread=spread, seen=min(pulse.seen + 1, config.memory))
