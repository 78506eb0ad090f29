"""Thesis 6.3.1, the experiments with one or two recordings: static light, growing light, a dynamic object."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from andante.evaluation.experiments.contenders import (
    ANDANTE,
    CONTENDERS,
    NEAREST,
    NEAREST_NOTE,
    THESIS,
    Contender,
    fit_split,
)
from andante.evaluation.experiments.outcome import ERROR_COLUMNS, Outcome, Plot, Table, error_cells
from andante.evaluation.experiments.plans import COW, GROWING, STATIC, UNSEEN, Scale
from andante.evaluation.experiments.statistics import summary
from andante.evaluation.experiments.trials import Bench, Drive, Result, Trial

_TEST_SHARE = 0.3
_SPLIT = 630  # tells this use of the seed from others; the thesis' section
_COLUMNS = ("localizer", *ERROR_COLUMNS, "thesis: mean [m]")


@dataclass(frozen=True)
class Case:
    """What is tried with one or several localizers, each with the mean error that the thesis got for it, if any."""

    title: str
    train: tuple[Drive, ...]
    test: Drive
    contenders: tuple[tuple[Contender, float | None], ...]


def run_static(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """One recording in static light, 70 % of its frames to learn from (figure 6.4)."""
    kept, rest = random_split(seed, scale.frames)
    own = Contender(THESIS.name, THESIS.config, partial(fit_split, kept), kept)
    cases = (
        Case(
            "Thesis' protocol: slow features of all images, a regression of 70 %",
            (Drive(STATIC),),
            Drive(STATIC, rest),
            ((own, 0.08),),
        ),
        Case(
            "70 % of the images mapped, the others localized",
            (Drive(STATIC, kept),),
            Drive(STATIC, rest),
            _all(None),
        ),
    )
    return _outcome(bench, cases)


def run_slow_light(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """Light that grows during the only mapped drive, and the cure: a second drive joined by places (6.6, 6.7)."""
    both = (Drive(STATIC), Drive(GROWING))
    cases = (
        Case("Mapped in growing light, localized in static light", (Drive(GROWING),), Drive(STATIC), _all(1.41)),
        Case("Both mapped, localized in the mapped static drive (thesis' protocol)", both, Drive(STATIC), _all(0.17)),
        Case("Both mapped, localized in an unseen static drive", both, Drive(UNSEEN), _all(None)),
    )
    return _outcome(bench, cases)


def run_dynamic_object(bench: Bench, seed: int, scale: Scale) -> Outcome:
    """A cow that was not there when the garden was mapped (figure 6.9)."""
    cases = (
        Case("Localized with a cow that was not mapped", (Drive(STATIC),), Drive(COW), _all(0.12)),
        Case("The same drive without the cow", (Drive(STATIC),), Drive(UNSEEN), _all(None)),
    )
    return _outcome(bench, cases)


def random_split(seed: int, frames: int) -> tuple[tuple[int, ...], tuple[int, ...]]:
    """Ascending indices of 70 % of the frames, at random, and of the others."""
    order = np.random.default_rng([seed, _SPLIT]).permutation(frames)
    count = round(_TEST_SHARE * frames)
    kept, rest = np.sort(order[count:]).tolist(), np.sort(order[:count]).tolist()
    return tuple(kept), tuple(rest)


def _all(thesis: float | None) -> tuple[tuple[Contender, float | None], ...]:
    """Every localizer; the thesis' figure belongs to its own choices."""
    return ((ANDANTE, None), (THESIS, thesis), *((nearest, None) for nearest in NEAREST))


def _outcome(bench: Bench, cases: tuple[Case, ...]) -> Outcome:
    trials = [Trial(contender, case.train, case.test) for case in cases for contender, _ in case.contenders]
    results = iter(bench.run(trials))
    by_case = [[(*pair, next(results)) for pair in case.contenders] for case in cases]
    tables = tuple(_table(case, done) for case, done in zip(cases, by_case, strict=True))
    figures = [
        {
            "case": case.title,
            "localizers": {
                contender.name: {**summary([result]).as_dict(), "thesis_mean_m": thesis}
                for contender, thesis, result in done
            },
        }
        for case, done in zip(cases, by_case, strict=True)
    ]
    plot = _plot(cases, [[(contender, result) for contender, _, result in done] for done in by_case])
    return Outcome(tables, (plot,), {"cases": figures}, CONTENDERS, (NEAREST_NOTE,))


def _table(case: Case, done: list[tuple[Contender, float | None, Result]]) -> Table:
    rows = tuple((contender.name, *error_cells(summary([result])), thesis) for contender, thesis, result in done)
    return Table(case.title, _COLUMNS, rows)


def _plot(cases: tuple[Case, ...], by_case: list[list[tuple[Contender, Result]]]) -> Plot:
    """A row for each case, a column for the thesis' choices and for the package's own."""
    from andante.evaluation.experiments.plots import Panel, estimated_ways

    shown = [
        [Panel(contender.name, result) for contender, result in done if not contender.name.startswith("nearest")]
        for done in by_case
    ]
    return Plot("", "Driven (grey) and estimated (blue).", estimated_ways([case.title for case in cases], shown))
