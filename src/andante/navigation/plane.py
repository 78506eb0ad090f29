"""The estimation matrix of thesis 9.3.1: where the robot was, what it cost there, and the plane through both."""

from __future__ import annotations

from collections import deque

import numpy as np

from andante.data import FloatArray

_MOST_ROWS = 20_000


class EstimationMatrix:
    """Rows (x, y, cost) of the last ``window_m`` metres of the way, or of all of it where ``None``.

    Positions are those of odometry. However long a drive, at most 20,000 rows are kept.
    """

    def __init__(self, window_m: float | None = None) -> None:
        self._window_m = window_m
        self._rows: deque[tuple[float, float, float, float]] = deque(maxlen=_MOST_ROWS)
        self._way_m = 0.0

    def __len__(self) -> int:
        return len(self._rows)

    def append(self, x_m: float, y_m: float, cost: float) -> None:
        """One more image."""
        if self._rows:
            self._way_m += float(np.hypot(x_m - self._rows[-1][0], y_m - self._rows[-1][1]))
        self._rows.append((x_m, y_m, cost, self._way_m))
        while self._window_m is not None and self._rows[0][3] < self._way_m - self._window_m:
            self._rows.popleft()

    @property
    def rows(self) -> FloatArray:
        """(n, 3) x, y, cost, oldest first."""
        return np.array(self._rows, np.float64).reshape(-1, 4)[:, :3]


def plane_gradient(rows: FloatArray) -> FloatArray:
    """The slope (2,) of the plane that is nearest to points ``rows`` (n, 3), by singular value decomposition.

    The normal of the plane is the direction in which the centred points vary least. Three points that are not on a line
    decide it; for points on a line, and for an upright plane, it is what rounding makes of it, and may be infinite.
    """
    _, _, directions = np.linalg.svd(rows - rows.mean(axis=0), full_matrices=len(rows) < 3)
    normal = directions[-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        slope: FloatArray = -normal[:2] / normal[2]
    return slope


def unit(vector: FloatArray) -> FloatArray:
    """A vector (2,) with length one; zero, and what is not finite, become zero."""
    length = float(np.hypot(*vector))
    result: FloatArray = vector / length if np.isfinite(length) and length > 0.0 else np.zeros(2)
    return result
