"""Plots of a simulated garden: what stands where, and slow features over its places."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Polygon

from andante.data import FloatArray
from andante.evaluation.comparison import Evaluation
from andante.evaluation.figures import best_guess, truth_of
from andante.evaluation.plots import ERROR_COLOURS, INK, PLAIN, STYLE, svg
from andante.evaluation.spatial import SpatialMaps
from andante.evaluation.top_view import TopView
from andante.simulator.obstacles import Obstacles

_COLUMNS = 4


def localized_garden(evaluation: Evaluation, mapped_m: FloatArray, view: TopView, obstacles: Obstacles) -> str:
    """The garden from above with the footprints of its objects, mapped places (r, 2), the way, and the estimates."""
    frames = evaluation.run.frames
    truth = truth_of([frame.info for frame in frames], "m")
    guess = np.array([best_guess(frame.estimate, "m") for frame in frames])
    errors = evaluation.map.errors
    known = np.isfinite(errors)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(6.4, 6.0), layout="constrained")
        axes = figure.add_subplot()
        axes.imshow(view.image, extent=view.extent_m, alpha=0.75)
        for corners in footprint_corners(obstacles):
            axes.add_patch(Polygon(corners.tolist(), fill=False, ec="#20242a", lw=0.6))
        axes.plot(*mapped_m.T, ".", ms=2.0, color="#101418", alpha=0.5, label="mapped", rasterized=True)
        axes.plot(*truth.T, "-", color="#e0a92a", lw=2.2, label="driven")
        ties = np.stack([truth[known], guess[known]], axis=1)
        axes.plot(*np.moveaxis(ties, 2, 0).transpose(0, 2, 1), "-", color="#d4475a", lw=0.8)
        norm = LogNorm(0.02, max(1.0, float(errors[known].max())))
        colours = np.maximum(errors[known], 0.02)
        x, y = guess[known].T
        shown = axes.scatter(x, y, s=10, c=colours, cmap=ERROR_COLOURS, norm=norm, zorder=3)
        figure.colorbar(shown, ax=axes, label="error in m", shrink=0.7, pad=0.02, format=PLAIN)
        left, right, bottom, top = view.extent_m
        axes.set(xlabel="x in m", ylabel="y in m", aspect="equal", xlim=(left, right), ylim=(bottom, top))
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.08), ncols=2)
        return svg(figure)


def feature_maps(maps: SpatialMaps, obstacles: Obstacles | None = None, title: str = "s") -> Figure:
    """Every feature as colours over the places (thesis figure 9.1 a): blue low, red high, blank where nobody was."""
    count = len(maps.values)
    columns = min(count, _COLUMNS)
    rows = -(-count // columns)
    left, right, bottom, top = extent_m(maps)
    with mpl.rc_context(STYLE):
        height = 1.9 * rows * (top - bottom) / (right - left)
        figure = Figure(figsize=(1.9 * columns, height + 0.3 * rows), layout="constrained")
        for number, values in enumerate(maps.values):
            axes = figure.add_subplot(rows, columns, number + 1)
            bound = float(np.nanquantile(np.abs(values), 0.98)) or 1.0
            image = np.ma.masked_invalid(values)
            axes.imshow(
                image, extent=(left, right, bottom, top), origin="lower", cmap="RdBu_r", vmin=-bound, vmax=bound
            )
            for corners in footprint_corners(obstacles) if obstacles is not None else ():
                axes.add_patch(Polygon(corners.tolist(), fill=False, ec=INK, lw=0.8))
            axes.set(xlim=(left, right), ylim=(bottom, top), xticks=[], yticks=[])
            axes.set_title(f"{title}{number + 1}", fontsize=9)
    return figure


def extent_m(maps: SpatialMaps) -> tuple[float, float, float, float]:
    """Left, right, bottom, top of the cells of a map."""
    half = (maps.x_m[1] - maps.x_m[0]) / 2, (maps.y_m[1] - maps.y_m[0]) / 2
    x, y = maps.x_m, maps.y_m
    return float(x[0] - half[0]), float(x[-1] + half[0]), float(y[0] - half[1]), float(y[-1] + half[1])


def footprint_corners(obstacles: Obstacles) -> list[FloatArray]:
    """The four corners (4, 2) of every footprint."""
    found = []
    for x, y, heading, half_x, half_y in obstacles.rows:
        own = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * (half_x, half_y)
        cos, sin = np.cos(heading), np.sin(heading)
        found.append(own @ np.array([[cos, sin], [-sin, cos]]) + (x, y))
    return found
