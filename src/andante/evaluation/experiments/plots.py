"""The plots of experiments, after thesis figures 6.4 to 6.11."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import matplotlib as mpl
import numpy as np
from matplotlib.collections import LineCollection
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, MaxNLocator, NullFormatter

from andante.evaluation.experiments.statistics import Summary
from andante.evaluation.experiments.trials import Result
from andante.evaluation.plots import INK, LINE_COLOURS, PLAIN, STYLE

_LEAST_M = 1e-3  # a logarithm knows no zero
_MARKERS = "ov^s"
_PANEL_INCHES = 3.1
_MARGIN_M = 1.0


@dataclass(frozen=True, slots=True)
class Panel:
    """One estimated way with its title."""

    title: str
    result: Result


def error_over_sessions(summaries: Mapping[str, Sequence[Summary]], marks: Mapping[str, tuple[int, float]]) -> Figure:
    """Mean error over the number of mapped sessions, one line a localizer with a band of one standard deviation.

    ``marks`` are figures of others: name -> (sessions, mean in metres).
    """
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 4.8), layout="constrained")
        axes = figure.add_subplot()
        for (name, by_size), colour in zip(summaries.items(), _colours(len(summaries)), strict=True):
            sizes = np.arange(1, len(by_size) + 1)
            mean = np.array([max(one.mean_m, _LEAST_M) for one in by_size])
            deviation = np.array([one.deviation_m or 0.0 for one in by_size])
            # Where the band would reach below zero, it ends at a fifth of the mean.
            low = np.maximum(mean - deviation, mean / 5)
            axes.fill_between(sizes, low, mean + deviation, color=colour, alpha=0.13, lw=0)
            axes.plot(sizes, mean, "-o", ms=3.5, lw=1.6, color=colour, label=name)
        for (name, (sessions, mean_m)), marker in zip(marks.items(), _MARKERS, strict=False):
            axes.plot(sessions, mean_m, marker, ms=7, mfc="none", mec="#d4475a", mew=1.4, label=f"{name}, {mean_m:g} m")
        axes.set(xlabel="mapped sessions", ylabel="mean error of the next session in m", yscale="log")
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
        axes.yaxis.set_major_locator(LogLocator(subs=(1.0, 2.0, 5.0)))
        axes.yaxis.set_major_formatter(PLAIN)
        axes.yaxis.set_minor_formatter(NullFormatter())
        axes.grid()
        # Above the axes, where it takes the room it needs.
        figure.legend(loc="outside upper left", ncols=2, fontsize=8)
    return figure


def estimated_ways(titles: Sequence[str], rows: Sequence[Sequence[Panel]]) -> Figure:
    """Panels in rows: the driven way, and where every frame was located, tied to where it was taken."""
    columns = max(len(panels) for panels in rows)
    with mpl.rc_context(STYLE):
        size = (_PANEL_INCHES * columns, (_PANEL_INCHES + 0.5) * len(rows))
        figure = Figure(figsize=size, layout="constrained")
        parts = figure.subfigures(len(rows), 1, squeeze=False)[:, 0]
        for part, title, panels in zip(parts, titles, rows, strict=True):
            part.suptitle(title, fontsize=9)
            for number, panel in enumerate(panels):
                axes = part.add_subplot(1, columns, number + 1)
                mean_m = float(panel.result.errors.mean())
                xy, truth = panel.result.xy, panel.result.truth
                axes.plot(*truth.T, ".", ms=2.5, color=INK)
                ties = np.stack([truth, xy], axis=1)
                axes.add_collection(LineCollection(list(ties), lw=0.5, color=LINE_COLOURS[0], alpha=0.5))
                axes.plot(*xy.T, "*", ms=3.5, mew=0, color=LINE_COLOURS[0])
                # Estimates far away must not shrink the garden to a dot.
                (left, bottom), (right, top) = truth.min(axis=0) - _MARGIN_M, truth.max(axis=0) + _MARGIN_M
                axes.set(xlim=(left, right), ylim=(bottom, top), aspect="equal", xlabel="x in m", ylabel="y in m")
                axes.set_title(
                    f"{panel.title}: {mean_m:.2f} m" if mean_m < 100 else f"{panel.title}: {mean_m:.0f} m", fontsize=8
                )
    return figure


def _colours(count: int) -> list[str]:
    return [LINE_COLOURS[number % len(LINE_COLOURS)] for number in range(count)]
