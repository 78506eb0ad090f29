"""The plot of thesis figure 7.12."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from matplotlib.ticker import MaxNLocator

from andante.evaluation.plots import LINE_COLOURS, STYLE


def error_over_landmarks(curve: Mapping[str, Any]) -> Figure:
    """Median error over the number of landmarks, one standard deviation of the orders around it, and the time taken."""
    median, deviation = np.array(curve["median_m"]), np.sqrt(curve["variance_m2"])
    sizes = np.arange(1, len(median) + 1)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=(8.0, 3.6), layout="constrained")
        error, duration = figure.subplots(1, 2)
        error.fill_between(sizes, median - deviation, median + deviation, color=LINE_COLOURS[0], alpha=0.15, lw=0)
        error.plot(sizes, median, "-o", ms=4, lw=1.6, color=LINE_COLOURS[0])
        error.set(xlabel="landmarks", ylabel="median error in m", ylim=(0, None))
        duration.plot(sizes, curve["ms_per_image"], "-o", ms=4, lw=1.6, color=LINE_COLOURS[1])
        duration.set(xlabel="landmarks", ylabel="time of an image in ms, without detection", ylim=(0, None))
        for axes in (error, duration):
            axes.xaxis.set_major_locator(MaxNLocator(integer=True))
            axes.grid()
    return figure
