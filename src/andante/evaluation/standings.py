"""Where others beat the package's own method, in one sentence for below a table; and where they do not."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

Values = Mapping[str, float | None]
"""By statistic."""


@dataclass(frozen=True, slots=True)
class Statistic:
    """What is compared, of which less is better: its ``key``, its ``title``, what a winner does, how tables show it.

    Tables show it in ``unit``, of which there are ``scale`` to one of the value.
    """

    key: str
    title: str
    winner: str
    unit: str
    digits: int
    scale: float = 1.0


ERRORS = (
    Statistic("median_m", "median", "has the smaller median", "m", 3),
    Statistic("mean_m", "mean", "has the smaller mean", "m", 3),
    Statistic("max_m", "largest error", "has the smaller largest error", "m", 3),
)
SHARES = (
    Statistic("share_over_3m", "share beyond 3 m", "has the smaller share beyond 3 m", "%", 1, 100.0),
    Statistic("heading_median_deg", "error of the heading", "has the better heading", "deg", 2),
)
COSTS = (
    Statistic("learning_s", "time to map", "maps faster", "s", 1),
    Statistic("ms_per_image", "time to localize", "localizes faster", "ms", 2),
    Statistic("bytes", "size", "is smaller", "kB", 0, 1e-3),
)


def standings(own: str, values: Mapping[str, Values], statistics: Sequence[Statistic]) -> str:
    """Each statistic that another method has smaller, and by how much; then what no other method has smaller.

    Compared as precisely as tables show it. Empty where ``own`` is not among ``values``, or alone.
    """
    if own not in values or len(values) < 2:
        return ""
    said, won = list[str](), list[str]()
    for one in statistics:
        shown = {name: _shown(one, of) for name, of in values.items()}
        known = {name: value for name, value in shown.items() if value is not None}
        if own not in known:
            said.append(f"{own} has no {one.title}")
        elif better := sorted((name for name in known if known[name] < known[own]), key=lambda name: known[name]):
            said.append(_beaten(one, better, known[better[0]], known[own]))
        else:
            won.append(one.title)
    if won:
        said.append(f"no other method has a smaller {_listed(won, 'or')} than {own}")
    return "; ".join(said)


def _shown(one: Statistic, values: Values) -> float | None:
    value = values.get(one.key)
    return None if value is None else round(one.scale * value, one.digits)


def _beaten(one: Statistic, better: Sequence[str], best: float, own: float) -> str:
    by = f"{best:.{one.digits}f} against {own:.{one.digits}f} {one.unit}"
    others = f" (so {'does' if len(better) == 2 else 'do'} {_listed(better[1:])})" if len(better) > 1 else ""
    return f"{better[0]} {one.winner}: {by}{others}"


def _listed(parts: Sequence[str], word: str = "and") -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} {word} {parts[-1]}"
