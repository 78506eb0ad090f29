"""What one image says, before anything is made of it over time."""

from __future__ import annotations

from dataclasses import dataclass

from andante.data import Estimate, FloatArray, ImageArray, Status
from andante.errors import BlankImageError
from andante.mapping.readout import LocalReadout
from andante.mapping.slow_map import SlowMap


@dataclass(frozen=True, eq=False)
class Evidence:
    """The ``estimate`` of one image, and its slow features.

    ``slow`` (k,) is scaled by the readout's metric, so that a distance means the same in all directions; it is ``None``
    where a picture shows nothing.
    """

    estimate: Estimate
    slow: FloatArray | None = None


def evidence_of(slowmap: SlowMap, image: ImageArray) -> Evidence:
    """Grey (height, width) or BGR (height, width, 3) uint8 -> what it says; without state, for many threads.

    A picture that shows nothing gives status lost; one of the wrong size raises ``ImageError``.
    """
    try:
        encoded = slowmap.front_end.encode(image)
    except BlankImageError as error:
        return Evidence(Estimate(Status.LOST, str(error)))
    slow = slowmap.model.transform(encoded.features)
    metric = slowmap.readout.metric if isinstance(slowmap.readout, LocalReadout) else 1.0
    return Evidence(slowmap.estimate(encoded, slow), slow[0] * metric)
