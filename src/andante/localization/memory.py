"""What a tracker remembers from one frame to the next."""

from __future__ import annotations

from dataclasses import dataclass, field

from andante.data import FloatArray
from andante.localization.faults import Pulse
from andante.localization.judge import Judge
from andante.localization.motion import Odometer
from andante.localization.trail import Trail
from andante.localization.witness import Novelty


@dataclass(frozen=True, eq=False)
class Memory:
    """Everything besides the filter; replaced as a whole with every frame.

    ``good`` and ``last`` (k,) are slow features of the last image that did not jump and of the last one. ``fast`` and
    ``slow`` are running means of how often images agree with the prediction (augmented MCL, theory 8),
    ``image_radius_m`` is that of the radii they come with, ``strain_m`` that of how far they are from the prediction.
    """

    odometer: Odometer = field(default_factory=Odometer)
    trail: Trail = field(default_factory=Trail.empty)
    pulse: Pulse = field(default_factory=Pulse)
    image_news: Novelty = field(default_factory=Novelty)
    fix_news: Novelty = field(default_factory=Novelty)
    judge: Judge = field(default_factory=Judge)
    fast: float = 1.0
    slow: float = 1.0
    image_radius_m: float = 0.0
    strain_m: float = 0.0
    good: FloatArray | None = None
    last: FloatArray | None = None
