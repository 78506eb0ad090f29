"""A picture of one drive: where the robot was, where it believed to be, and the shortest way."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from andante.data import FloatArray
from andante.evaluation.garden_plots import footprint_corners
from andante.evaluation.plots import INK, LINE_COLOURS, STYLE, svg
from andante.navigation import Drive
from andante.simulator import Garden


def drive_plot(
    run: Drive, way_m: FloatArray, shortest_m: FloatArray | None, places_m: FloatArray, garden: Garden
) -> str:
    """SVG of the true way (n, 2), the estimates, the shortest way (m, 2) and the nodes (k, 2) of the place graph."""
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(5.8, 5.8), layout="constrained")
        axes = figure.add_subplot()
        border = garden.border.points_m
        axes.plot(*np.concatenate([border, border[:1]]).T, "-", lw=0.6, color=INK)
        for corners in footprint_corners(garden.obstacles):
            axes.add_patch(Polygon(corners.tolist(), fc=INK, ec=INK, alpha=0.3))
        axes.plot(*places_m.T, ".", ms=2, color=INK, alpha=0.4, label="places")
        if shortest_m is not None:
            axes.plot(*shortest_m.T, "--", lw=1, color=LINE_COLOURS[1], label="shortest way")
            axes.plot(*shortest_m[-1], "*", ms=10, color=LINE_COLOURS[1], label="goal")
        axes.plot(*run.estimate[:, :2].T, ".", ms=3, color=LINE_COLOURS[2], label="estimates")
        axes.plot(*way_m.T, "-", lw=1.5, color=LINE_COLOURS[0], label="robot")
        axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]", title=f"{run.outcome}: {run.reason}")
        axes.legend(loc="upper right", fontsize=7)
        return svg(figure)
