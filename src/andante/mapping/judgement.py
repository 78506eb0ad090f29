"""How far an estimate can be believed, and why, in numbers and in words that a person understands."""

from __future__ import annotations

import numpy as np

from andante.data import Status
from andante.mapping.calibration import Calibration
from andante.mapping.locating import Sighting


def judge(sighting: Sighting, bounds: Calibration) -> tuple[Status, str]:
    """Status and reason for the first image of a sighting."""
    likeness, agreement = float(sighting.likeness[0]), float(sighting.located.agreement[0])
    if not np.isfinite([likeness, agreement, *sighting.located.xy[0]]).all():
        return Status.LOST, "the image leads to numbers that are not finite; is the map damaged?"
    alike = f"likeness {likeness:.2f}"
    if bounds.usual_likeness:
        alike += f" where {bounds.usual_likeness:.2f} is usual"
    if likeness < bounds.off_map_below:
        return Status.OFF_MAP, (
            f"no mapped place looks like this: {alike}, and places that are not in the map reach "
            f"{bounds.off_map_below:.2f}"
        )
    if agreement < bounds.lost_below:
        return Status.LOST, (
            f"several places look like this: {agreement:.0%} of the evidence agrees, at least "
            f"{bounds.lost_below:.0%} is needed"
        )
    if likeness * agreement < bounds.degraded_below:
        return Status.DEGRADED, (
            f"not much more like this place than like others: {alike}, {agreement:.0%} of the evidence agrees"
        )
    if bounds.off_map_below <= 0:
        return Status.DEGRADED, (
            "this map has not learnt what places look like that are not in it: its readout is a regression, or its "
            "drives are too short"
        )
    return Status.OK, f"{alike}, {agreement:.0%} of the evidence agrees"
