"""The plots of the navigation experiment, after thesis figures 9.1 and 9.4 to 9.6."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Polygon
from scipy.ndimage import gaussian_filter

from andante.data import FloatArray
from andante.evaluation.garden_plots import footprint_corners
from andante.evaluation.plots import INK, LINE_COLOURS, STYLE
from andante.evaluation.spatial import SpatialMaps, spatial_maps

if TYPE_CHECKING:
    from andante.evaluation.experiments.navigation import Case, Place
    from andante.evaluation.experiments.navigation_trials import Result

_COLOURS = (*LINE_COLOURS, "#d4475a", "#20a4b8")
_SHOWN_MAPS = 5
_THESIS_REACHED = {"in the open": 0.85, "around the obstacle": 0.70}
_ARROW_EVERY = 2

Found = Sequence[tuple["Case", dict[str, list["Result"]]]]


def approach(found: Found) -> Figure:
    """For each case and navigator, the share of drives that ended within a distance of 0 to 1 m."""
    limits = np.linspace(0.0, 1.0, 201)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(3.1 * len(found), 3.9), layout="constrained")
        for number, (case, by_driver) in enumerate(found):
            axes = figure.add_subplot(1, len(found), number + 1)
            for (name, results), colour in zip(by_driver.items(), _COLOURS, strict=False):
                end = np.array([one.distance_m for one in results])
                share = (end[None] < limits[:, None]).mean(axis=1)
                axes.plot(limits, 100 * share, lw=1.6, color=colour, label=name if number == 0 else None)
            for place, share in _THESIS_REACHED.items():
                if case.name.startswith(place):
                    mark = "thesis, in its own room" if number == 0 else None
                    axes.plot(0.8, 100 * share, "x", ms=7, mew=1.6, color=INK, label=mark)
            axes.set(xlim=(0, 1), ylim=(-2, 102), xlabel="distance to the goal in m")
            axes.set_title(f"{case.name} ({len(case.errands)})", fontsize=9)
            axes.grid()
        figure.axes[0].set_ylabel("drives that ended nearer, %")
        figure.legend(loc="outside lower center", ncols=3, fontsize=8)
    return figure


def ways(found: Found, places: Sequence[Place]) -> Figure:
    """The driven ways of the four fixed pairs; those that hit something are dashed."""
    fixed = [(case, by_driver) for case, by_driver in found if case.name.endswith("four pairs")]
    names = list(fixed[0][1])
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(2.3 * len(names), 4.6 * len(fixed)), layout="constrained")
        for row, ((case, by_driver), place) in enumerate(zip(fixed, places, strict=True)):
            for column, name in enumerate(names):
                axes = figure.add_subplot(len(fixed), len(names), row * len(names) + column + 1)
                _lawn(axes, place)
                starts = sorted({errand.start[:2] for errand in case.errands})
                for errand, result in zip(case.errands, by_driver[name], strict=True):
                    colour = _COLOURS[starts.index(errand.start[:2]) % len(_COLOURS)]
                    axes.plot(*result.xy_m.T, "--" if result.hits else "-", lw=0.8, color=colour)
                    axes.plot(*errand.start[:2], "o", ms=4, color=colour)
                    axes.plot(*errand.goal, "x", ms=7, mew=1.8, color=colour)
                axes.set_title(name.replace(", ", ",\n"), fontsize=8)
    return figure


def cost_surfaces(places: Sequence[Place]) -> Figure:
    """The cost of every place for the goal of the first fixed pair, and arrows down its slope."""
    with mpl.rc_context(STYLE):
        columns = len(places[0].costs)
        figure = Figure(figsize=(2.0 * columns, 4.4 * len(places)), layout="constrained")
        for row, place in enumerate(places):
            for column, one in enumerate(place.costs):
                axes = figure.add_subplot(len(places), columns, row * columns + column + 1)
                maps = spatial_maps(one.xy_m, one.cost_to(one.goal_m)[:, None])
                axes.imshow(maps.values[0], extent=_extent(maps), origin="lower", cmap="viridis")
                _arrows(axes, maps)
                _lawn(axes, place)
                axes.plot(*one.goal_m, "o", ms=6, mfc="none", mec="#d4475a", mew=1.8)
                axes.set_title(one.by.name.replace(", ", ",\n"), fontsize=7)
    return figure


def slow_maps(places: Sequence[Place]) -> Figure:
    """The first five slow features of both sights on both lawns."""
    with mpl.rc_context(STYLE):
        rows = [(place, one) for place in places for one in place.costs if one.by.name.endswith("s1 and s2")]
        figure = Figure(figsize=(1.6 * _SHOWN_MAPS, 3.5 * len(rows)), layout="constrained")
        for row, (place, one) in enumerate(rows):
            maps = spatial_maps(one.xy_m, one.slow[:, :_SHOWN_MAPS])
            for column, values in enumerate(maps.values):
                axes = figure.add_subplot(len(rows), _SHOWN_MAPS, row * _SHOWN_MAPS + column + 1)
                bound = float(np.nanquantile(np.abs(values), 0.98))
                axes.imshow(values, extent=_extent(maps), origin="lower", cmap="RdBu_r", vmin=-bound, vmax=bound)
                _lawn(axes, place)
                axes.set_title(f"{one.by.sight}, s{column + 1}", fontsize=8)
    return figure


def _arrows(axes: Axes, maps: SpatialMaps) -> None:
    """Unit arrows down the slope of the smoothed cost."""
    values = maps.values[0]
    known = np.isfinite(values)
    weight = gaussian_filter(known.astype(np.float64), 1.0)
    smooth = gaussian_filter(np.where(known, values, 0.0), 1.0) / np.maximum(weight, 1e-9)
    down_y, down_x = (-slope for slope in np.gradient(np.where(known, smooth, np.nan)))
    length = np.hypot(down_x, down_y)
    every = (slice(None, None, _ARROW_EVERY), slice(None, None, _ARROW_EVERY))
    x, y = np.meshgrid(maps.x_m, maps.y_m)
    axes.quiver(x[every], y[every], (down_x / length)[every], (down_y / length)[every],
                color="white", width=0.008, scale=14, pivot="middle")  # fmt: skip


def _lawn(axes: Axes, place: Place) -> None:
    border: FloatArray = place.lawn.garden.border.points_m
    axes.plot(*np.concatenate([border, border[:1]]).T, "-", lw=0.6, color=INK)
    for corners in footprint_corners(place.lawn.wall):
        axes.add_patch(Polygon(corners.tolist(), fc="#20242a", ec="#20242a", lw=1.0))
    (left, bottom), (right, top) = border.min(axis=0) - 0.3, border.max(axis=0) + 0.3
    axes.set(xlim=(left, right), ylim=(bottom, top), xticks=[], yticks=[], aspect="equal")


def _extent(maps: SpatialMaps) -> tuple[float, float, float, float]:
    half = (maps.x_m[1] - maps.x_m[0]) / 2, (maps.y_m[1] - maps.y_m[0]) / 2
    return (
        float(maps.x_m[0] - half[0]), float(maps.x_m[-1] + half[0]),
        float(maps.y_m[0] - half[1]), float(maps.y_m[-1] + half[1]),
    )  # fmt: skip
