"""One sentence on whether the map is worth it."""

from __future__ import annotations

from collections.abc import Mapping

from andante.evaluation.figures import Figures

_STATISTICS = {"median": "median", "mean": "mean", "p95": "95 % error"}


def verdict(figures: Figures, baselines: Mapping[str, Figures]) -> str | None:
    """Compare median, mean and 95th percentile with the best baseline, as precisely as tables show them.

    ``None`` where there is nothing to compare.
    """
    digits = 3 if figures.places is None else 1
    better: list[str] = []
    worse: dict[str, list[str]] = {}
    for statistic, title in _STATISTICS.items():
        own = _value(figures, statistic, digits)
        values = {name: _value(other, statistic, digits) for name, other in baselines.items()}
        known = {name: value for name, value in values.items() if value is not None}
        if own is None or not known:
            return None
        best = min(known, key=lambda name: known[name])
        if known[best] < own:
            comparison = f"{title} ({known[best]:.{digits}f} against {own:.{digits}f} {_unit(figures)})"
            worse.setdefault(best, []).append(comparison)
        elif own < known[best]:
            better.append(title)
    return _sentence(better, worse)


def _sentence(better: list[str], worse: dict[str, list[str]]) -> str:
    if not worse and not better:
        return "The best baseline is as good as the map in median, mean and 95 % error."
    if not worse:
        return f"The map is better than every baseline in {_listed(better)}."
    beaten = "; ".join(f"{name} is better in {_listed(titles)}" for name, titles in worse.items())
    if not better:
        return f"The map does not win: {beaten}."
    return f"The map does not win everywhere: {beaten}. It is better than every baseline in {_listed(better)}."


def _value(figures: Figures, statistic: str, digits: int) -> float | None:
    values = figures.as_dict()
    value = values[f"{statistic}_m"] if figures.places is None else values["places"][statistic]
    return None if value is None else round(value, digits)


def _unit(figures: Figures) -> str:
    return "m" if figures.places is None else "places"


def _listed(parts: list[str]) -> str:
    return parts[0] if len(parts) == 1 else f"{', '.join(parts[:-1])} and {parts[-1]}"
