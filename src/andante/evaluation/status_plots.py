"""Plots of what a localizer promised: its status and radius over time, and whether the errors kept to them."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import MultipleLocator
from numpy.typing import NDArray

from andante.data import FloatArray, Status
from andante.evaluation.comparison import Scored
from andante.evaluation.figures import heading_errors_of
from andante.evaluation.plots import (
    INK,
    LEAST,
    LINE_COLOURS,
    STATUS_COLOURS,
    STYLE,
    UNIT,
    logarithmic,
    svg,
)
from andante.mapping.slow_map import Unit

_LEAST_DEG = 0.1
_BINS = 8
_FEWEST_IN_BIN = 5
_PROMISED = 0.9


def timeline(scored: Scored, unit: Unit) -> str:
    """Error and promised radius of every frame, a band of its status, and below the error of its heading if known."""
    times, statuses = times_s(scored), statuses_of(scored)
    headings = heading_errors_of(scored.run)
    shows_headings = bool(np.isfinite(headings).any())
    with mpl.rc_context(STYLE):
        heights = (2.4, 0.22, 1.5) if shows_headings else (2.4, 0.22)
        figure = Figure(figsize=(5.8, sum(heights) + 0.7), layout="constrained")
        rows = figure.subplots(len(heights), 1, sharex=True, height_ratios=heights, squeeze=False)[:, 0]
        _errors_over_time(rows[0], times, scored, statuses, unit)
        _band_of_statuses(rows[1], times, statuses)
        if shows_headings:
            _dots(rows[2], times, np.maximum(headings, _LEAST_DEG), statuses)
            rows[2].set(ylabel="heading error in °")
            logarithmic(rows[2], y=True)
            rows[2].grid(axis="y")
        rows[-1].set(xlabel="time in s")
        figure.align_ylabels()
        return svg(figure)


def calibration(scored: Scored) -> str | None:
    """Errors of answered frames over the radius promised for 90 % of them; ``None`` where no radius is given.

    Below, the share that kept the promise, in bins of equally many frames, with what chance alone would make of 90 %.
    """
    radii, errors = radii_of(scored), np.maximum(scored.errors, LEAST["m"])
    chosen = np.isfinite(radii) & np.isfinite(errors)
    if not chosen.any():
        return None
    radii, errors = np.maximum(radii[chosen], LEAST["m"]), errors[chosen]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.8, 4.6), layout="constrained")
        above, below = figure.subplots(2, 1, sharex=True, height_ratios=(3, 1))
        _errors_over_radius(above, radii, errors)
        _coverage_over_radius(below, radii, errors)
        figure.align_ylabels()
        return svg(figure)


def times_s(scored: Scored) -> FloatArray:
    """(n,) seconds since the first frame."""
    times: FloatArray = np.array([frame.info.timestamp_s for frame in scored.run.frames], dtype=np.float64)
    return np.asarray(times - times[:1], np.float64)


def statuses_of(scored: Scored) -> NDArray[np.str_]:
    """(n,) the statuses' names."""
    return np.array([str(frame.estimate.status) for frame in scored.run.frames])


def radii_of(scored: Scored) -> FloatArray:
    """(n,) promised radii in metres, NaN where none is given."""
    return np.array([frame.estimate.radius_m for frame in scored.run.frames], dtype=np.float64)


def _errors_over_time(axes: Axes, times: FloatArray, scored: Scored, statuses: NDArray[np.str_], unit: Unit) -> None:
    radii = radii_of(scored)
    if np.isfinite(radii).any():
        axes.plot(times, np.maximum(radii, LEAST[unit]), "-", lw=0.8, color=INK, alpha=0.7, label="90 % radius")
    _dots(axes, times, np.maximum(scored.errors, LEAST[unit]), statuses)
    axes.set(ylabel=f"error in {UNIT[unit]}")
    logarithmic(axes, y=True)
    axes.grid(axis="y")
    if axes.get_legend_handles_labels()[0]:
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=5, borderaxespad=0, columnspacing=1.0)


def _dots(axes: Axes, times: FloatArray, values: FloatArray, statuses: NDArray[np.str_]) -> None:
    for status, colour in STATUS_COLOURS.items():
        chosen = (statuses == str(status)) & np.isfinite(values)
        if chosen.any():
            name = str(status).replace("_", " ")
            axes.plot(times[chosen], values[chosen], ".", ms=4, color=colour, label=name, rasterized=True)


def _band_of_statuses(axes: Axes, times: FloatArray, statuses: NDArray[np.str_]) -> None:
    """One bar for every frame, up to the next; frames without truth have their colour here as well."""
    usual = float(np.median(np.diff(times))) if len(times) > 1 else 1.0
    widths = np.minimum(np.append(np.diff(times), usual), 2 * usual)
    colours = [STATUS_COLOURS[Status(status)] for status in statuses.tolist()]
    axes.bar(times, 1.0, width=widths, align="edge", color=colours, lw=0, rasterized=True)
    axes.set(ylim=(0, 1), yticks=[], ylabel="")
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(bottom=False)


def _errors_over_radius(axes: Axes, radii: FloatArray, errors: FloatArray) -> None:
    limits = np.array([LEAST["m"], 1.3 * max(radii.max(), errors.max())])
    green = STATUS_COLOURS[Status.OK]
    axes.fill_between(limits, LEAST["m"], limits, color=green, alpha=0.1, lw=0)
    axes.plot(limits, limits, "-", color=green, lw=1.2, label="error = radius: 90 % belong below")
    outside = errors > radii
    for mask, colour in ((~outside, LINE_COLOURS[0]), (outside, STATUS_COLOURS[Status.LOST])):
        axes.plot(radii[mask], errors[mask], ".", ms=4, color=colour, rasterized=True)
    axes.set(ylabel="error in m")
    logarithmic(axes, x=True, y=True)
    axes.set(xlim=(0.8 * radii.min(), 1.25 * radii.max()), ylim=limits)
    axes.grid()
    axes.legend(loc="upper left")


def _coverage_over_radius(axes: Axes, radii: FloatArray, errors: FloatArray) -> None:
    order = np.argsort(radii, kind="stable")
    bins = np.array_split(order, max(1, min(_BINS, len(order) // _FEWEST_IN_BIN)))
    middle = np.array([np.median(radii[chosen]) for chosen in bins])
    shares = np.array([(errors[chosen] <= radii[chosen]).mean() for chosen in bins])
    spread = 2 * np.sqrt(_PROMISED * (1 - _PROMISED) / np.array([len(chosen) for chosen in bins]))
    low, high = np.maximum(_PROMISED - spread, 0), np.minimum(_PROMISED + spread, 1)
    axes.fill_between(middle, low, high, color=INK, alpha=0.15, lw=0, step=None)
    axes.axhline(_PROMISED, color=STATUS_COLOURS[Status.OK], lw=1.2)
    axes.plot(middle, shares, "o-", ms=3.5, lw=1.0, color=LINE_COLOURS[0])
    axes.set(xlabel="promised 90 % radius in m", ylabel="within it", ylim=(min(0.5, shares.min() - 0.05), 1.03))
    axes.yaxis.set_major_locator(MultipleLocator(0.25))
    axes.yaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
    axes.grid()
