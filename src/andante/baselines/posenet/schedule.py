"""How long and how fast PoseNet learns."""

from __future__ import annotations

from dataclasses import dataclass

from andante.errors import ConfigError

CHANNEL_GROUP = 8
"""Channels of the network that are normalised together."""


@dataclass(frozen=True, slots=True)
class Schedule:
    """``steps`` batches of ``batch_size`` pictures, but no longer than ``max_seconds``.

    The learning rate warms up and falls along a cosine to zero. Every ``validate_every`` steps the held-out pictures
    are tried; after ``patience`` tries without a better median, learning stops. ``threads`` are those of torch: two
    are a little faster on a quiet machine, and many times slower on a busy one. Raises ``ConfigError`` for numbers that
    are not positive.
    """

    steps: int = 5000
    batch_size: int = 32
    learning_rate: float = 3e-3
    weight_decay: float = 0.02
    max_seconds: float = 660.0
    validate_every: int = 100
    patience: int = 20
    threads: int = 1
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("steps", "batch_size", "validate_every", "patience", "threads"):
            if getattr(self, name) < 1:
                raise ConfigError(f"{name} of a schedule must be at least 1, got {getattr(self, name)}")
        for name in ("learning_rate", "max_seconds"):
            if not getattr(self, name) > 0:
                raise ConfigError(f"{name} of a schedule must be positive, got {getattr(self, name):g}")
