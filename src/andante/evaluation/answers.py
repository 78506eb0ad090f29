"""What one localizer said of one recording, as arrays: small enough to keep, and all that a comparison is made of."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields, replace
from typing import Any, Self

import numpy as np

from andante.data import Estimate, FloatArray, FrameInfo, Trajectory
from andante.evaluation.alignment import Alignment
from andante.evaluation.figures import apart_deg, best_guess, best_heading

_DECIMALS = 6
_UNANSWERED_M = 1e9  # stands in quantiles for the error of a frame without any answer


@dataclass(frozen=True, kw_only=True, slots=True)
class AnswerFigures:
    """Errors over all ``n`` frames with truth, of the best hypothesis whatever its status, so that "lost" helps nobody.

    In the quantiles and shares a frame without any hypothesis counts as infinitely wrong; ``mean_m`` and ``max_m``,
    where infinity says nothing, leave the ``unanswered_share`` out. ``None`` is unknown, or infinite. ``q75_m`` is the
    third quartile of the thesis' tables, ``max_m`` its fourth. Times are medians of a frame in one thread.
    """

    n: int
    median_m: float | None
    mean_m: float | None
    q75_m: float | None
    p95_m: float | None
    max_m: float | None
    share_over_1m: float
    share_over_3m: float
    lost_share: float
    unanswered_share: float
    heading_median_deg: float | None
    decode_ms: float | None
    prepare_ms: float | None
    locate_ms: float | None

    @property
    def ms_per_image(self) -> float | None:
        """Decoding and both steps together."""
        parts = (self.decode_ms, self.prepare_ms, self.locate_ms)
        known = [part for part in parts if part is not None]
        return sum(known) if len(known) == len(parts) else None

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON: ``None`` for what is unknown, never NaN."""
        return {**asdict(self), "ms_per_image": self.ms_per_image}


@dataclass(frozen=True, eq=False)
class Answers:
    """Of n frames with truth the best hypothesis, ``xy`` (n, 2) and ``heading_rad`` (n,); NaN where there is none.

    ``posed`` (n,) is one where the status stands for a pose and else zero; ``truth`` (n, 2) and ``true_heading_rad``
    (n,) are what is true; ``seconds`` (n, 3) are those of decoding, preparing and locating, NaN where not told apart.
    """

    truth: FloatArray
    true_heading_rad: FloatArray
    xy: FloatArray
    heading_rad: FloatArray
    posed: FloatArray
    seconds: FloatArray

    @classmethod
    def of(
        cls, infos: Sequence[FrameInfo], estimates: Sequence[Estimate], seconds: Sequence[Sequence[float]] | None = None
    ) -> Self:
        """From what was said of frames, of which those without truth are left out."""
        truth = Trajectory.of(infos, "reference")
        guesses = np.array([best_guess(one, "m") for one in estimates], dtype=np.float64).reshape(-1, 2)
        headings = np.array([best_heading(one) for one in estimates], dtype=np.float64)
        posed = np.array([one.status.has_pose for one in estimates], dtype=np.float64)
        times = np.full((len(infos), 3), np.nan) if seconds is None else np.array(seconds, dtype=np.float64)
        known = truth.known
        parts = (truth.xy_m, truth.heading_rad, guesses, headings, posed, times.reshape(-1, 3))
        return cls(*(part[known] for part in parts))

    @property
    def errors(self) -> FloatArray:
        """(n,) metres, NaN where there is no answer."""
        errors: FloatArray = np.linalg.norm(self.xy - self.truth, axis=1)
        return errors

    def laid_by(self, alignment: Alignment) -> Answers:
        """The same out of a frame of its own, in that of the truth."""
        turned = self.heading_rad + alignment.rotation_rad
        return replace(self, xy=alignment.out_of_map(self.xy), heading_rad=turned)

    def figures(self) -> AnswerFigures:
        """Over all frames, of which there is at least one."""
        errors = self.errors
        answered = np.isfinite(errors)
        filled = np.where(answered, errors, _UNANSWERED_M)
        headings = apart_deg(self.heading_rad, self.true_heading_rad)
        headings = headings[np.isfinite(headings)]
        decode_ms, prepare_ms, locate_ms = (_median_ms(column) for column in self.seconds.T)
        return AnswerFigures(
            n=len(errors),
            median_m=_quantile(filled, 0.5),
            mean_m=float(errors[answered].mean()) if answered.any() else None,
            q75_m=_quantile(filled, 0.75),
            p95_m=_quantile(filled, 0.95),
            max_m=float(errors[answered].max()) if answered.any() else None,
            share_over_1m=float((filled > 1).mean()),
            share_over_3m=float((filled > 3).mean()),
            lost_share=float(1 - self.posed.mean()),
            unanswered_share=float(1 - answered.mean()),
            heading_median_deg=float(np.median(headings)) if len(headings) else None,
            decode_ms=decode_ms,
            prepare_ms=prepare_ms,
            locate_ms=locate_ms,
        )

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON, ``None`` for NaN."""
        return {field.name: _plain(getattr(self, field.name)) for field in fields(self)}

    @classmethod
    def from_dict(cls, values: Mapping[str, Any]) -> Self:
        """What ``as_dict`` made."""
        return cls(*(np.array(values[field.name], dtype=np.float64) for field in fields(cls)))


def _quantile(filled: FloatArray, share: float) -> float | None:
    """Linear between frames; ``None`` where it is infinite."""
    value = float(np.quantile(filled, share))
    return value if value < _UNANSWERED_M / len(filled) else None


def _median_ms(seconds: FloatArray) -> float | None:
    known = seconds[np.isfinite(seconds)]
    return 1000 * float(np.median(known)) if len(known) else None


def _plain(array: FloatArray) -> list[Any]:
    """Nested lists, ``None`` for NaN."""
    values = np.round(array, _DECIMALS).astype(object)
    values[~np.isfinite(array)] = None
    nested: list[Any] = values.tolist()
    return nested
