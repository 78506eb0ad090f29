"""The plots of a report as SVG text that reads on light and on dark paper; of runs with at least one error."""

from __future__ import annotations

import io
from collections.abc import Sequence
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.collections import LineCollection
from matplotlib.colors import LinearSegmentedColormap, LogNorm
from matplotlib.figure import Figure
from matplotlib.ticker import LogLocator, NullFormatter
from numpy.typing import NDArray

from andante.data import FloatArray, Status
from andante.evaluation.comparison import Evaluation, Scored
from andante.evaluation.figures import best_guess, truth_of

STATUS_COLOURS = {
    Status.OK: "#2f9e78",
    Status.DEGRADED: "#d08a1d",
    Status.LOST: "#d4475a",
    Status.OFF_MAP: "#8d6cc9",
}
LINE_COLOURS = ("#2f7fd6", "#d08a1d", "#2f9e78", "#8d6cc9", "#8a8f98")
"""The map first, then its baselines."""

# Grey that has a contrast of about 4.5 on white and on near-black alike.
INK = "#7c828c"
ERROR_COLOURS = LinearSegmentedColormap.from_list("errors", ["#2f7fd6", "#2f9e78", "#d9a21b", "#d4475a"])
STYLE: dict[Any, Any] = {
    "svg.hashsalt": "andante",  # the same evaluation gives the same page
    "font.size": 9.0,
    "text.color": INK,
    "axes.labelcolor": INK,
    "axes.edgecolor": INK,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "xtick.color": INK,
    "ytick.color": INK,
    "grid.color": INK,
    "grid.alpha": 0.25,
    "grid.linewidth": 0.5,
    "legend.frameon": False,
}
LEAST = {"m": 0.01, "place": 0.5}
"""Errors below this are drawn at it: a logarithm knows no zero."""
_FAILURE = {"m": 1.0, "place": 10.0}
UNIT = {"m": "m", "place": "places"}
PLAIN = "{x:g}"


def trajectory(evaluation: Evaluation, references: FloatArray) -> str:
    """Truth as a line, estimates coloured by their error, and ``references`` (r, 2) of the map in grey.

    Large errors are tied to the truth, frames that the map called lost are crossed out. In a map of places the
    estimated place is drawn over the true one.
    """
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(4.8)
        truth, guess = _positions(evaluation)
        if evaluation.unit == "place":
            truth, guess = (np.column_stack([truth[:, 0], one[:, 0]]) for one in (truth, guess))
            axes.set(xlabel="true place", ylabel="estimated place")
        else:
            axes.set(xlabel="x in m", ylabel="y in m", aspect="equal")
            axes.plot(*references.T, ".", ms=2.5, color=INK, alpha=0.35, label="mapped", rasterized=True)
        axes.plot(*_gaps(truth, evaluation).T, "-", color=INK, lw=0.9, label="truth")
        errors, known = evaluation.map.errors, np.isfinite(evaluation.map.errors)
        large = known & (errors > _FAILURE[evaluation.unit])
        if evaluation.unit == "m":
            ties = np.stack([truth[large], guess[large]], axis=1)
            axes.add_collection(LineCollection(list(ties), lw=0.6, color=INK, alpha=0.7))
        norm = LogNorm(5 * LEAST[evaluation.unit], max(5 * _FAILURE[evaluation.unit], float(errors[known].max())))
        drawn = np.maximum(errors[known], norm.vmin or 0)
        x, y = guess[known].T
        shown = axes.scatter(x, y, s=9, c=drawn, cmap=ERROR_COLOURS, norm=norm, rasterized=True)
        lost = ~_has_pose(evaluation) & np.isfinite(truth).all(axis=1)
        if lost.any():
            crossed = np.where(known[:, None], guess, truth)[lost]
            axes.plot(*crossed.T, "x", ms=5, mew=0.9, color=STATUS_COLOURS[Status.LOST], label="lost or off the map")
        title = f"error in {UNIT[evaluation.unit]}"
        figure.colorbar(shown, ax=axes, label=title, shrink=0.8, pad=0.02, format=PLAIN)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=3)
        return svg(figure)


def distribution(evaluation: Evaluation) -> str:
    """The share of frames with at most some error, for the map and all baselines."""
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(3.0)
        scored: Sequence[Scored] = (evaluation.map, *evaluation.others)
        for index, (one, colour) in enumerate(zip(scored, LINE_COLOURS, strict=False)):
            errors = np.sort(np.maximum(one.errors[np.isfinite(one.errors)], LEAST[evaluation.unit]))
            share = np.arange(1, len(errors) + 1) / max(len(errors), 1)
            label = "the map" if index == 0 else one.name
            axes.step(errors, share, where="post", color=colour, lw=2.0 if index == 0 else 1.2, label=label)
        axes.set(xlabel=f"error in {UNIT[evaluation.unit]}", ylabel="share of frames", ylim=(0, 1.02))
        logarithmic(axes, x=True)
        axes.yaxis.set_major_formatter(lambda share, _: f"{100 * share:.0f} %")
        axes.grid()
        axes.legend(loc="lower left", bbox_to_anchor=(0, 1), ncols=3, borderaxespad=0)
        return svg(figure)


def new_figure(height: float) -> tuple[Figure, Axes]:
    """Small in inches, so that its text can be read on a phone."""
    figure = Figure(figsize=(5.8, height), layout="constrained")
    return figure, figure.add_subplot()


def logarithmic(axes: Axes, *, x: bool = False, y: bool = False) -> None:
    """Scales labelled 0.1, 0.3, 1 in place of powers of ten."""
    axes.set(xscale="log" if x else "linear", yscale="log" if y else "linear")
    for axis in [axes.xaxis] * x + [axes.yaxis] * y:
        axis.set_major_locator(LogLocator(subs=(1.0, 3.0)))
        axis.set_major_formatter(PLAIN)
        axis.set_minor_formatter(NullFormatter())


def svg(figure: Figure) -> str:
    """A figure as the text of an SVG, the same for the same figure."""
    text = io.StringIO()
    figure.savefig(text, format="svg", transparent=True, dpi=200, metadata={"Date": None})
    return text.getvalue()


def _positions(evaluation: Evaluation) -> tuple[FloatArray, FloatArray]:
    """Truth and best hypotheses, (n, 2) each."""
    frames = evaluation.run.frames
    guesses = np.array([best_guess(frame.estimate, evaluation.unit) for frame in frames])
    return truth_of([frame.info for frame in frames], evaluation.unit), guesses


def _has_pose(evaluation: Evaluation) -> NDArray[np.bool_]:
    return np.array([frame.estimate.status.has_pose for frame in evaluation.run.frames], dtype=bool)


def _gaps(truth: FloatArray, evaluation: Evaluation) -> FloatArray:
    """The truth with a break wherever frames were left out for long, so that no line crosses the garden."""
    times = np.array([frame.info.timestamp_s for frame in evaluation.run.frames])
    steps = np.diff(times)
    breaks = np.flatnonzero(steps > 10 * np.median(steps)) + 1 if len(steps) else np.empty(0, dtype=np.int64)
    return np.insert(truth, breaks, np.nan, axis=0)
