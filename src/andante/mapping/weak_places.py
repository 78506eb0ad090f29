"""Where another landmark would help: "ask the human for one here" (thesis 7.3.3)."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from andante.data import FloatArray
from andante.errors import ArrayError


@dataclass(frozen=True, slots=True)
class WeakPlace:
    """A place of the mapped drives where a human could teach another landmark.

    ``radius_m`` is what to expect there, infinite where no landmark is seen; ``frames`` of the drives lie there.
    """

    x_m: float
    y_m: float
    radius_m: float
    frames: int

    def as_dict(self) -> dict[str, Any]:
        """Plain values; a radius of ``None`` where no landmark is seen."""
        return asdict(self) | {"radius_m": self.radius_m if np.isfinite(self.radius_m) else None}


def weak_places(places: FloatArray, radius_m: float, cell_m: float) -> list[WeakPlace]:
    """Cells of ``cell_m`` whose median radius is above ``radius_m``, the worst first.

    ``places`` (n, 3) are x, y and the expected radius of the mapped frames. Raises ``ArrayError`` for a size that is
    not above zero.
    """
    if not (radius_m > 0 and cell_m > 0):
        raise ArrayError(f"radius_m and cell_m have to be above zero, got {radius_m} and {cell_m}")
    cells, member = np.unique(np.floor(places[:, :2] / cell_m), axis=0, return_inverse=True)
    weak = list[WeakPlace]()
    for number in range(len(cells)):
        here = places[member == number]
        expected = float(np.quantile(here[:, 2], 0.5, method="higher"))
        if expected > radius_m:
            x, y = here[:, :2].mean(axis=0).tolist()
            weak.append(WeakPlace(x, y, expected, len(here)))
    return sorted(weak, key=lambda place: (-place.radius_m, -place.frames))
