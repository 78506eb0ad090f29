"""A comparison as tables: errors of every test (thesis tables 8.1 and 8.2), and what methods cost (8.3)."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from andante.evaluation.answers import AnswerFigures
from andante.evaluation.compare import OWN, Comparison, Entry
from andante.evaluation.standings import COSTS, ERRORS, SHARES, standings
from andante.evaluation.tables import Cell, Table

ERROR_COLUMNS = (
    "method",
    *("median [m]", "mean [m]", "3rd quartile [m]", "max [m]", "> 1 m [%]", "> 3 m [%]"),
    *("lost [%]", "no answer [%]", "heading, median [°]"),
)
COST_COLUMNS = (
    "method",
    *("preprocessing [s]", "mapping [s]", f"both, times {OWN}"),
    *("decoding [ms]", "preprocessing [ms]", "locating [ms]", f"all, times {OWN}"),
    "size [kB]",
)
FAILED = "failed"


def tables_of(comparison: Comparison) -> tuple[Table, ...]:
    """All tables: errors of every test, of what was followed where there is any, and costs."""
    errors = tuple(error_table(comparison.entries, test.name) for test in comparison.tests)
    followed = followed_table(comparison.entries)
    return (*errors, *((followed,) if followed.rows else ()), cost_table(comparison.entries))


def error_table(
    entries: Sequence[Entry], test: str, *, title: str | None = None, thesis: Sequence[tuple[Cell, ...]] = ()
) -> Table:
    """Errors of single images of one test; rows of the ``thesis`` stand below, and are not compared."""
    figures = {one.name: one.tests[test].figures() for one in entries if one.failure is None}
    rows = [(one.name, *_error_cells(figures[one.name])) if one.name in figures else _failed(one) for one in entries]
    count = next(iter(figures.values())).n if figures else 0
    values = {name: _comparable(of) for name, of in figures.items()}
    shown = title or test
    verdict = _with_gaps(standings(OWN, values, (*ERRORS, *SHARES)), figures)
    return Table(f"{shown}: {count} images", ERROR_COLUMNS, (*rows, *thesis), verdict)


def followed_table(entries: Sequence[Entry]) -> Table:
    """Errors of what was followed through every test with odometry; single images of the same tests beside."""
    rows: list[tuple[Cell, ...]] = []
    for one in entries:
        for test, answers in one.followed.items():
            rows.append((f"{test}: {one.name} + tracker", *_error_cells(answers.figures())))
            rows.append((f"{test}: {one.name}, single images", *_error_cells(one.tests[test].figures())))
    return Table("Followed with odometry, every frame from the first", ERROR_COLUMNS, tuple(rows))


def cost_table(entries: Sequence[Entry]) -> Table:
    """What learning cost once, what an image costs in one thread, and what has to be kept."""
    values = {one.name: _costs(one) for one in entries if one.failure is None}
    own = values.get(OWN, {})
    rows: list[tuple[Cell, ...]] = []
    for one in entries:
        if one.failure is not None:
            rows.append(_failed(one, len(COST_COLUMNS)))
            continue
        cost = values[one.name]
        steps = (cost["decode_ms"], cost["prepare_ms"], cost["locate_ms"])
        rows.append((
            one.name,
            *(one.preprocessing_s, one.mapping_s, _ratio(cost["learning_s"], own.get("learning_s"))),
            *(*steps, _ratio(cost["ms_per_image"], own.get("ms_per_image"))),
            None if one.bytes is None else round(one.bytes / 1000),
        ))  # fmt: skip
    title = "Time to map once, time for an image in one thread (medians), and size"
    return Table(title, COST_COLUMNS, tuple(rows), standings(OWN, values, COSTS))


def _error_cells(of: AnswerFigures) -> tuple[Cell, ...]:
    # Kilometres have no decimals.
    metres = [
        value if value is None or value < 1000 else round(value)
        for value in (of.median_m, of.mean_m, of.q75_m, of.max_m)
    ]
    return (
        *(*metres, 100 * of.share_over_1m, 100 * of.share_over_3m),
        *(100 * of.lost_share, 100 * of.unanswered_share, of.heading_median_deg),
    )


def _failed(entry: Entry, columns: int = len(ERROR_COLUMNS)) -> tuple[Cell, ...]:
    return (f"{entry.name} ({FAILED})", *[None] * (columns - 1))


def _comparable(of: AnswerFigures) -> dict[str, float | None]:
    """Means and largest errors only of methods that answer all images: of some of them they are not the same thing."""
    known: dict[str, float | None] = of.as_dict()
    return known if of.unanswered_share == 0 else {**known, "mean_m": None, "max_m": None}


def _with_gaps(sentence: str, figures: dict[str, AnswerFigures]) -> str:
    """What means and maxima leave out has to be said beside them."""
    gaps = [f"{name} {100 * of.unanswered_share:.1f} %" for name, of in figures.items() if of.unanswered_share > 0]
    if not gaps:
        return sentence
    gap = f"mean and max leave out what has no answer: {', '.join(gaps)}"
    return f"{sentence}; {gap}" if sentence else gap


def _costs(entry: Entry) -> dict[str, float | None]:
    """Of learning, and of an image as the median over all tests."""
    figures = [answers.figures().as_dict() for answers in entry.tests.values()]
    times = {key: _median([one[key] for one in figures]) for key in ("decode_ms", "prepare_ms", "locate_ms")}
    return {
        **times,
        "ms_per_image": None if None in times.values() else sum(value or 0.0 for value in times.values()),
        "learning_s": entry.learning_s,
        "bytes": entry.bytes,
    }


def _median(values: Sequence[float | None]) -> float | None:
    known = [value for value in values if value is not None]
    return float(np.median(known)) if known else None


def _ratio(value: float | None, own: float | None) -> str | None:
    if value is None or not own:
        return None
    ratio = value / own
    return f"{ratio:.0f}" if ratio >= 10 else f"{ratio:.2g}"
