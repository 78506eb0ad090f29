"""Where and how often methods are wrong, side by side (thesis figures 8.3 to 8.6)."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure

from andante.data import FloatArray
from andante.evaluation.answers import Answers
from andante.evaluation.plots import ERROR_COLOURS, INK, STYLE

FAR_M = 3.0
"""Beyond it the thesis draws pink triangles in place of colours."""
_LEAST_M = 0.03
_SHOWN_M = (0.001, 30.0)
"""Errors that are shown; methods that go astray by kilometres must not squeeze the others."""
_TICKS_M = (0.001, 0.01, 0.1, 1.0, 10.0)
_FAR_COLOUR = "#e85da8"
_COLUMNS = 3
_PANEL_INCHES = 2.5
_COLOURS = (
    "#2f7fd6",
    "#d08a1d",
    "#2f9e78",
    "#8d6cc9",
    "#d4475a",
    "#1fa3b5",
    "#b0722f",
    "#8a8f98",
    "#d873b0",
    "#7a9a2a",
)
_DASHES = ("-", "--", ":")


def error_maps(answers: Mapping[str, Answers], mapped_m: FloatArray) -> Figure:
    """One panel a method: mapped positions (n, 2) in grey, test positions coloured by their error on a common scale.

    Positions whose error is more than three metres, or that have no answer, are pink triangles.
    """
    columns = min(_COLUMNS, len(answers))
    rows = -(-len(answers) // columns)
    truth = np.concatenate([mapped_m, *(one.truth for one in answers.values())])
    low, high = truth.min(axis=0) - 0.5, truth.max(axis=0) + 0.5
    with mpl.rc_context(STYLE):
        tall = 0.87 * _PANEL_INCHES * float((high - low)[1] / (high - low)[0])
        figure = Figure(figsize=(_PANEL_INCHES * columns + 0.8, (tall + 0.5) * rows + 0.4), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False, sharex=True, sharey=True)
        norm = LogNorm(_LEAST_M, FAR_M)
        for axes, (name, one) in zip(panels.flat, answers.items(), strict=False):
            _error_map(axes, one, mapped_m, norm)
            axes.set(title=_title(name, one), xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
            axes.title.set_fontsize(8)
        for axes in panels.flat[len(answers) :]:
            axes.set_axis_off()
        figure.supxlabel("x in m", fontsize=9)
        figure.supylabel("y in m", fontsize=9)
        scale = figure.colorbar(
            ScalarMappable(norm, ERROR_COLOURS), ax=list(panels.flat), shrink=0.8, pad=0.02, aspect=30
        )
        scale.set_ticks([_LEAST_M, 0.1, 0.3, 1.0, FAR_M], labels=["0.03", "0.1", "0.3", "1", "3"])
        scale.minorticks_off()
        scale.set_label("error in m; triangles: more than 3 m")
    return figure


def error_distributions(tests: Mapping[str, Mapping[str, Answers]]) -> Figure:
    """The share of images with at most some error, one panel a test and one line a method."""
    names = list(dict.fromkeys(name for answers in tests.values() for name in answers))
    columns = min(2, len(tests))
    rows = -(-len(tests) // columns)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3.6 * columns + 0.4, 2.9 * rows + 0.7), layout="constrained")
        panels = figure.subplots(rows, columns, squeeze=False)
        for axes, (test, answers) in zip(panels.flat, tests.items(), strict=False):
            for name, one in answers.items():
                _distribution(axes, one, _line(names.index(name)), name)
            axes.set(title=test, xlabel="error in m", ylabel="share of images", xlim=_SHOWN_M, ylim=(0, 1.02))
            axes.title.set_fontsize(9)
            axes.axvline(FAR_M, color=_FAR_COLOUR, lw=0.8, alpha=0.6)
            axes.set_xscale("log")
            axes.set_xticks(_TICKS_M, labels=[f"{tick:g}" for tick in _TICKS_M])
            axes.yaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
            axes.grid()
        for axes in panels.flat[len(tests) :]:
            axes.set_axis_off()
        handles, labels = panels.flat[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside upper left", ncols=4, fontsize=8)
    return figure


def _error_map(axes: Axes, one: Answers, mapped_m: FloatArray, norm: LogNorm) -> None:
    errors = np.nan_to_num(one.errors, nan=np.inf)
    far = errors > FAR_M
    axes.plot(*mapped_m.T, ".", ms=2.2, color=INK, alpha=0.6, mew=0, rasterized=True)
    x, y = one.truth[~far].T
    colours = np.maximum(errors[~far], _LEAST_M)
    axes.scatter(x, y, s=7, c=colours, cmap=ERROR_COLOURS, norm=norm, lw=0, rasterized=True)
    axes.plot(*one.truth[far].T, "^", ms=3.2, mew=0, color=_FAR_COLOUR, rasterized=True)


def _title(name: str, one: Answers) -> str:
    figures = one.figures()
    median = "no median" if figures.median_m is None else f"median {figures.median_m:.3f} m"
    if figures.median_m is not None and figures.median_m > 1000:
        median = "median > 1 km"
    return f"{name}\n{median}, {100 * figures.share_over_3m:.1f} % > 3 m"


def _distribution(axes: Axes, one: Answers, line: tuple[str, str, float], name: str) -> None:
    errors = one.errors
    known = np.sort(np.maximum(errors[np.isfinite(errors)], _SHOWN_M[0]))
    colour, dashes, width = line
    # What has no answer keeps the line below one.
    share = np.arange(1, len(known) + 1) / max(len(errors), 1)
    axes.step(known, share, where="post", color=colour, ls=dashes, lw=width, label=name)


def _line(index: int) -> tuple[str, str, float]:
    """Colour, dashes and width of the methods in their order, the first one thicker."""
    dashes = _DASHES[(index // len(_COLOURS)) % len(_DASHES)]
    return _COLOURS[index % len(_COLOURS)], dashes, 2.2 if index == 0 else 1.1
