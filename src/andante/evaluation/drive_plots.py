"""Plots of one drive to a goal: the way over the garden, and how far the goal was over time."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from andante.data import FloatArray, Status
from andante.evaluation.garden_plots import footprint_corners
from andante.evaluation.plots import INK, LINE_COLOURS, STATUS_COLOURS, STYLE, svg
from andante.evaluation.simulated_drive import SimulatedDrive
from andante.protocols import DriveState
from andante.simulator import Garden

Kind = TypeVar("Kind", DriveState, Status)

STATE_COLOURS = {
    DriveState.DRIVING: "#2f7fd6",
    DriveState.RECOVERING: "#d08a1d",
    DriveState.ARRIVED: "#2f9e78",
    DriveState.BLOCKED: "#d4475a",
    DriveState.TIMED_OUT: "#d4475a",
    DriveState.STOPPED: "#d4475a",
}
_PLANS = 12
_AROUND_M = 0.6


def from_above(one: SimulatedDrive, places_m: FloatArray, plans: Sequence[FloatArray], garden: Garden) -> str:
    """Obstacles, mapped places (k, 2), planned ways (m, 2), the true way and where the robot believed to be."""
    border = garden.border.points_m
    (left, bottom), (right, top) = border.min(axis=0) - _AROUND_M, border.max(axis=0) + _AROUND_M
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.8, min(max(5.8 * (top - bottom) / (right - left), 3.6), 8.5)), layout="constrained")
        axes = figure.add_subplot()
        axes.plot(*np.concatenate([border, border[:1]]).T, "-", lw=0.6, color=INK)
        for corners in footprint_corners(garden.obstacles):
            axes.add_patch(Polygon(corners.tolist(), fc=INK, ec=INK, alpha=0.5))
        axes.plot(*places_m.T, ".", ms=2, color=INK, alpha=0.35, label="mapped", rasterized=True)
        for number, way in enumerate(plans[:_PLANS]):
            label = "planned" if number == 0 else "planned again" if number == 1 else None
            axes.plot(*way.T, "--" if number == 0 else ":", lw=1.3, color=LINE_COLOURS[1], label=label)
        if np.isfinite(one.run.estimate[:, 0]).any():
            axes.plot(*one.run.estimate[:, :2].T, ".", ms=3, color=LINE_COLOURS[2], label="believed")
        axes.plot(*one.way_m.T, "-", lw=1.6, color=LINE_COLOURS[0], label="driven")
        axes.plot(*one.way_m[0], "o", ms=6, color=LINE_COLOURS[0])
        axes.plot(one.goal.pose.x_m, one.goal.pose.y_m, "x", ms=9, mew=2.2, color="#d4475a", label="goal")
        axes.set(aspect="equal", xlabel="x in m", ylabel="y in m", xlim=(left, right), ylim=(bottom, top))
        figure.legend(loc="outside lower center", ncols=3)
        return svg(figure)


def over_time(one: SimulatedDrive) -> str:
    """The true distance to the goal, with bands of the navigator's states and of the estimates' statuses."""
    times = one.run.timestamp_s - one.run.timestamp_s[0]
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.8, 3.3), layout="constrained")
        upper, states, statuses = figure.subplots(3, 1, sharex=True, height_ratios=(2.4, 0.2, 0.2))
        upper.plot(times, one.distances_m[1 : len(times) + 1], "-", lw=1.4, color=LINE_COLOURS[0])
        upper.set(ylabel="distance to the goal in m", ylim=(0, None))
        upper.grid(axis="y")
        _band(states, times, one.run.state, STATE_COLOURS)
        _band(statuses, times, one.run.status, STATUS_COLOURS)
        statuses.set(xlabel="time in s")
        figure.legend(loc="outside lower center", ncols=6)
        return svg(figure)


def costs(places_m: FloatArray, cost: FloatArray, one: SimulatedDrive, garden: Garden) -> str:
    """What slow features made of every mapped place (n, 2): its cost (n,), low at the goal, and the way down."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.8, 5.2), layout="constrained")
        axes = figure.add_subplot()
        x, y = places_m.T
        shown = axes.scatter(x, y, c=cost, s=14, cmap="viridis", lw=0, rasterized=True)
        figure.colorbar(shown, ax=axes, label="steps of the mapped drive", shrink=0.8, pad=0.02)
        for corners in footprint_corners(garden.obstacles):
            axes.add_patch(Polygon(corners.tolist(), fc=INK, ec=INK, alpha=0.5))
        axes.plot(*one.way_m.T, "-", lw=1.6, color="#d4475a", label="driven")
        axes.plot(one.goal.pose.x_m, one.goal.pose.y_m, "x", ms=9, mew=2.2, color="#d4475a", label="goal")
        (left, bottom), (right, top) = places_m.min(axis=0) - 1.0, places_m.max(axis=0) + 1.0
        axes.set(aspect="equal", xlabel="x in m", ylabel="y in m", xlim=(left, right), ylim=(bottom, top))
        figure.legend(loc="outside lower center", ncols=2)
        return svg(figure)


def _band(axes: Axes, times: FloatArray, seen: Sequence[Kind], colours: Mapping[Kind, str]) -> None:
    """One bar for every step, up to the next, and a name in the legend for each colour that occurs."""
    width = np.diff(times, append=times[-1] + 0.2)
    axes.bar(times, 1.0, width=width, align="edge", color=[colours[one] for one in seen], lw=0)
    axes.set(ylim=(0, 1), yticks=[])
    axes.spines[["left", "bottom"]].set_visible(False)
    axes.tick_params(bottom=False)
    for one in dict.fromkeys(seen):
        axes.plot([], [], "s", ms=5, color=colours[one], label=str(one).replace("_", " "))
