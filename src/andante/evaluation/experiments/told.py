"""What was said of many frames, as arrays: small enough to keep, and all that figures are made of."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from typing import Any, Self

import numpy as np
from numpy.typing import NDArray

from andante.data import Estimate, FloatArray, FrameInfo, Status, Trajectory
from andante.evaluation.experiments.outcome import Cell
from andante.evaluation.figures import WRONG_M, apart_deg, best_guess, best_heading, figures_of, heading_figures

TOLD_COLUMNS = (
    *("mean [m]", "median [m]", "95 % [m]", "max [m]", "> 1 m [%]"),
    *("heading [°]", "its 95 % [°]", "in radius [%]", "answered [%]", "ok, > 1 m [%]"),
)
"""Of ``Told.cells``."""
_DECIMALS = 4


@dataclass(frozen=True, eq=False)
class Told:
    """Of n frames the best hypothesis, ``xy`` (n, 2) and ``heading_rad`` (n,), and ``radius_m`` (n,); NaN if unknown.

    ``status`` (n,) are names, ``truth`` (n, 2) and ``true_heading_rad`` (n,) what is true.
    """

    xy: FloatArray
    heading_rad: FloatArray
    radius_m: FloatArray
    status: NDArray[np.str_]
    truth: FloatArray
    true_heading_rad: FloatArray

    @classmethod
    def of(cls, estimates: Sequence[Estimate], infos: Sequence[FrameInfo]) -> Self:
        """What estimates say of frames with truth."""
        truth = Trajectory.of(infos, "reference")
        return cls(
            np.array([best_guess(one, "m") for one in estimates], dtype=np.float64).reshape(-1, 2),
            np.array([best_heading(one) for one in estimates], dtype=np.float64),
            np.array([one.radius_m for one in estimates], dtype=np.float64),
            np.array([str(one.status) for one in estimates]),
            truth.xy_m,
            truth.heading_rad,
        )

    @classmethod
    def joined(cls, parts: Sequence[Self]) -> Self:
        """One after the other."""
        return cls(*(np.concatenate([getattr(part, field.name) for part in parts]) for field in fields(cls)))

    @classmethod
    def from_dict(cls, values: dict[str, Any]) -> Self:
        """What ``as_dict`` made."""
        arrays: dict[str, Any] = {
            field.name: np.array(values[field.name], str if field.name == "status" else np.float64)
            for field in fields(cls)
        }
        return cls(**arrays)

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON, to a tenth of a millimetre."""
        return {field.name: _plain(getattr(self, field.name)) for field in fields(self)}

    @property
    def errors(self) -> FloatArray:
        """(n,) metres; NaN where nothing was said."""
        errors: FloatArray = np.linalg.norm(self.xy - self.truth, axis=1)
        return errors

    @property
    def heading_errors_deg(self) -> FloatArray:
        """(n,) 0 to 180; NaN where nothing was said."""
        return apart_deg(self.heading_rad, self.true_heading_rad)

    @property
    def answered(self) -> NDArray[np.bool_]:
        """(n,) whether there is a pose."""
        return np.asarray(np.isin(self.status, [str(one) for one in Status if one.has_pose]), dtype=bool)

    @property
    def confident_and_wrong(self) -> NDArray[np.bool_]:
        """(n,) whether the status is ok and the pose more than a metre off."""
        return np.asarray((self.status == str(Status.OK)) & (self.errors > WRONG_M), dtype=bool)

    @property
    def settled(self) -> NDArray[np.bool_]:
        """(n,) whether the status is ok and the pose right."""
        return np.asarray((self.status == str(Status.OK)) & (self.errors <= WRONG_M), dtype=bool)

    def figures(self) -> dict[str, float | int | None]:
        """The figures of ``cells`` and a few more by name, shares from 0 to 1."""
        errors, headings = figures_of(self.errors[np.isfinite(self.errors)]), heading_figures(self.heading_errors_deg)
        with_radius = self.answered & np.isfinite(self.radius_m) & np.isfinite(self.errors)
        within = self.errors[with_radius] <= self.radius_m[with_radius]
        return {
            "n": len(self.status),
            "mean_m": errors.mean_m,
            "median_m": errors.median_m,
            "p95_m": errors.p95_m,
            "max_m": errors.max_m,
            "share_over_1m": errors.share_over_1m,
            "heading_median_deg": headings.heading_median_deg,
            "heading_p95_deg": headings.heading_p95_deg,
            "coverage_90": _mean(within),
            "answered_share": _mean(self.answered),
            "confident_wrong_share": _mean(self.confident_and_wrong),
        }

    def cells(self) -> tuple[Cell, ...]:
        """A row under ``TOLD_COLUMNS``."""
        figures = self.figures()
        return tuple(
            100 * value if value is not None and ("share" in name or name == "coverage_90") else value
            for name, value in figures.items()
            if name != "n"
        )


def _plain(values: NDArray[Any]) -> list[Any]:
    if values.dtype.kind == "U":
        return list(values.tolist())
    rounded = np.round(values, _DECIMALS).astype(object)
    rounded[~np.isfinite(values)] = None
    return list(rounded.tolist())


def _mean(values: NDArray[Any]) -> float | None:
    return float(values.mean()) if len(values) else None
