"""The plots of experiments with trackers: how often how wrong, and whether radii hold."""

from __future__ import annotations

from collections.abc import Mapping

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from andante.data import FloatArray
from andante.evaluation.experiments.told import Told
from andante.evaluation.plots import INK, LEAST, LINE_COLOURS, STYLE, logarithmic

_PANEL_INCHES = 2.7
_BINS = 8
_PROMISED = 0.9
BySize = Mapping[int, Mapping[str, Told]]
"""By number of mapped sessions and localizer."""


def error_distributions(told: BySize) -> Figure:
    """The share of frames with at most some error, a panel for each number of mapped sessions."""
    with mpl.rc_context(STYLE):
        figure, panels = _panels(told)
        for axes, by_name in zip(panels, told.values(), strict=True):
            for (name, one), colour in zip(by_name.items(), LINE_COLOURS, strict=False):
                errors = np.sort(np.maximum(one.errors[np.isfinite(one.errors)], LEAST["m"]))
                share = np.arange(1, len(errors) + 1) / max(1, len(one.errors))
                axes.step(errors, share, where="post", lw=1.6, color=colour, label=name)
            axes.axvline(1.0, color=INK, lw=0.6, ls=":")
            logarithmic(axes, x=True)
            axes.set(xlabel="error in m", ylim=(0, 1.02))
        _finish(figure, panels, "share of frames")
    return figure


def coverage_over_radius(told: BySize) -> Figure:
    """The share of answers within their 90 % radius, in bins of equally many, over the radius."""
    with mpl.rc_context(STYLE):
        figure, panels = _panels(told)
        for axes, by_name in zip(panels, told.values(), strict=True):
            axes.axhline(_PROMISED, color=INK, lw=0.8)
            for (name, one), colour in zip(by_name.items(), LINE_COLOURS, strict=False):
                middle, share = binned_coverage(one)
                axes.plot(middle, share, "o-", ms=3, lw=1.2, color=colour, label=name)
            _radius_axis(axes)
            axes.set(xlabel="promised radius in m", ylim=(-0.02, 1.02))
        _finish(figure, panels, "share within it")
    return figure


def binned_coverage(one: Told) -> tuple[FloatArray, FloatArray]:
    """Median radius and share within it (b,), of bins of equally many answers from small to large radii."""
    counted = one.answered & np.isfinite(one.radius_m) & np.isfinite(one.errors)
    radii, errors = one.radius_m[counted], one.errors[counted]
    if not len(radii):
        return np.empty(0), np.empty(0)
    bins = np.array_split(np.argsort(radii, kind="stable"), min(_BINS, len(radii)))
    middle = np.array([max(float(np.median(radii[chosen])), LEAST["m"]) for chosen in bins])
    return middle, np.array([float((errors[chosen] <= radii[chosen]).mean()) for chosen in bins])


def receiver_operating(curves: Mapping[str, tuple[FloatArray, FloatArray, float]]) -> Figure:
    """ROC curves by name: false and true positive rates, and the area below, which the legend tells."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(4.8, 4.6), layout="constrained")
        axes = figure.add_subplot()
        for (name, (false, true, area)), colour in zip(curves.items(), _many_colours(len(curves)), strict=True):
            axes.plot(false, true, "-", lw=1.4, color=colour, label=f"{name}: {area:.3f}")
        axes.plot([0, 1], [0, 1], ":", lw=0.6, color=INK)
        axes.set(xlabel="off-map images taken for mapped places", ylabel="images of mapped places known as such")
        axes.set(xlim=(-0.01, 1.0), ylim=(0, 1.01), aspect="equal")
        axes.grid()
        axes.legend(loc="lower right", title="area below the curve", fontsize=8)
    return figure


def _panels(told: BySize) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(_PANEL_INCHES * len(told) + 0.4, 3.2), layout="constrained")
    panels = figure.subplots(1, len(told), sharey=True, squeeze=False)[0]
    for axes, size in zip(panels, told, strict=True):
        axes.set_title(f"{size} mapped", fontsize=9)
    return figure, list(panels)


def _radius_axis(axes: Axes) -> None:
    """A logarithm, unless all radii are much the same."""
    low, high = axes.get_xlim()
    if low > 0 and high / low > 4:
        logarithmic(axes, x=True)
    else:
        axes.xaxis.set_major_locator(MaxNLocator(4))


def _finish(figure: Figure, panels: list[Axes], label: str) -> None:
    panels[0].set_ylabel(label)
    panels[0].yaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    for axes in panels:
        axes.grid()
    figure.legend(*panels[0].get_legend_handles_labels(), loc="outside upper left", ncols=4, fontsize=8)


def _many_colours(count: int) -> list[str]:
    more = (*LINE_COLOURS, "#d4475a", "#6aa84f", "#3d3d8f")
    return [more[number % len(more)] for number in range(count)]
