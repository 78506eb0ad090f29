"""What is said of many trials at once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from andante.evaluation.experiments.trials import Result


@dataclass(frozen=True, kw_only=True)
class Summary:
    """Errors over ``trials`` trials, in metres.

    ``mean_m`` and ``variance_m2`` are those of the trials' mean errors (thesis figure 6.10), the variance unbiased and
    ``None`` for a single trial; ``median_m`` is the median of their medians. The others are over all frames of all
    trials together. ``seconds`` of learning and ``bytes`` are means.
    """

    trials: int
    frames: int
    mean_m: float
    variance_m2: float | None
    median_m: float
    p95_m: float
    max_m: float
    share_over_1m: float
    seconds: float
    bytes: float

    @property
    def deviation_m(self) -> float | None:
        """The root of the variance."""
        return None if self.variance_m2 is None else float(np.sqrt(self.variance_m2))

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self)


def summary(results: Sequence[Result]) -> Summary:
    """Summarise at least one result."""
    errors = [result.errors for result in results]
    means, pooled = np.array([one.mean() for one in errors]), np.concatenate(errors)
    return Summary(
        trials=len(results),
        frames=len(pooled),
        mean_m=float(means.mean()),
        variance_m2=float(means.var(ddof=1)) if len(means) > 1 else None,
        median_m=float(np.median([np.median(one) for one in errors])),
        p95_m=float(np.quantile(pooled, 0.95)),
        max_m=float(pooled.max()),
        share_over_1m=float((pooled > 1).mean()),
        seconds=float(np.mean([result.seconds for result in results])),
        bytes=float(np.mean([result.bytes for result in results])),
    )
