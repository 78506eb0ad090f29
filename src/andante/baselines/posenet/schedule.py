"""How long and how fast PoseNet learns."""

from __future__ import annotations

from dataclasses import dataclass

from andante.errors import ConfigError


@dataclass(frozen=True, slots=True)
class Schedule:
    """``steps`` batches of ``batch_size`` pictures, but no longer than ``max_seconds``.

    The learning rate warms up and falls along a cosine to zero. Every ``validate_every`` steps the held-out pictures
    are tried; after ``patience`` tries without a better median, learning stops. ``threads`` are those of torch.
    Raises ``ConfigError`` for what cannot be.
    """

    steps: int = 4000
    batch_size: int = 32
    learning_rate: float = 2e-3
    weight_decay: float = 0.02
    max_seconds: float = 660.0
    validate_every: int = 100
    patience: int = 20
    threads: int = 2
    seed: int = 0

    def __post_init__(self) -> None:
        for name in ("steps", "batch_size", "validate_every", "patience", "threads"):
            if getattr(self, name) < 1:
                raise ConfigError(f"{name} of a schedule must be at least 1, got {getattr(self, name)}")
        for name in ("learning_rate", "max_seconds"):
            if not getattr(self, name) > 0:
                raise ConfigError(f"{name} of a schedule must be positive, got {getattr(self, name):g}")
