"""How fast a robot may drive, turn and change its mind."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from andante.errors import ConfigError
from andante.protocols import VelocityCommand

STAND = VelocityCommand(0.0, 0.0)


@dataclass(frozen=True, slots=True)
class Limits:
    """Speeds in m/s and rad/s, their changes in m/s² and rad/s², and how long a drive may take.

    Raises ``ConfigError`` for values that are not positive.
    """

    forward_m_s: float = 0.5
    turn_rad_s: float = 1.2
    acceleration_m_s2: float = 1.0
    turn_acceleration_rad_s2: float = 6.0
    timeout_s: float = 300.0

    def __post_init__(self) -> None:
        for field in fields(self):
            value = getattr(self, field.name)
            if not (np.isfinite(value) and value > 0.0):
                raise ConfigError(f"{field.name} = {value} is not allowed; limits are finite and greater than 0")

    def held(self, wanted: VelocityCommand, before: VelocityCommand, seconds: float) -> VelocityCommand:
        """As near to ``wanted`` as is allowed ``seconds`` after ``before``.

        Slowing down is free: a robot that is told to stop for a reason should not argue.
        """
        forward = _held(
            wanted.forward_m_s, before.forward_m_s, most=self.forward_m_s, change=self.acceleration_m_s2 * seconds
        )
        turn = _held(
            wanted.turn_rad_s, before.turn_rad_s, most=self.turn_rad_s, change=self.turn_acceleration_rad_s2 * seconds
        )
        return VelocityCommand(forward, turn)


def _held(wanted: float, before: float, *, most: float, change: float) -> float:
    wanted = float(np.clip(wanted, -most, most))
    floor, ceiling = min(before, 0.0) - change, max(before, 0.0) + change
    return float(np.clip(wanted, floor, ceiling))
