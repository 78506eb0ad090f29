"""Where the landmarks of a map stand, how well they tell the place along its drives, and where another would help."""

from __future__ import annotations

import io

import matplotlib as mpl
import numpy as np
from matplotlib.colors import LogNorm
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from andante.data import Status
from andante.evaluation.plots import ERROR_COLOURS, INK, LINE_COLOURS, STATUS_COLOURS, STYLE
from andante.mapping import LandmarkMap

_SIZE_IN = 8.0, 6.5
_FINEST_M, _COARSEST_M = 0.05, 5.0
_NAMED = 3
_CELL_M = 2.0
_STANDS, _ASKED = LINE_COLOURS[0], STATUS_COLOURS[Status.LOST]


def landmark_map(landmarks: LandmarkMap) -> Figure:
    """The mapped drives by the radius to expect, landmarks by name, and the places to teach another one (7.3.3).

    Where no landmark is seen the drives are grey. The worst three places say what is asked for, the others are circles.
    """
    x, y, radius = landmarks.places.T
    seen = np.isfinite(radius)
    weak = landmarks.weak_places(cell_m=_CELL_M)
    with mpl.rc_context(STYLE):
        figure = Figure(figsize=_SIZE_IN, layout="constrained")
        axes = figure.subplots()
        axes.scatter(x[~seen], y[~seen], s=8, color=INK, alpha=0.5, lw=0, label="no landmark is seen")
        shown = axes.scatter(
            *(x[seen], y[seen]),
            c=np.clip(radius[seen], _FINEST_M, _COARSEST_M),
            s=12,
            lw=0,
            cmap=ERROR_COLOURS,
            norm=LogNorm(_FINEST_M, _COARSEST_M),
        )
        colours = figure.colorbar(shown, ax=axes, shrink=0.6, label="90 % radius by landmarks alone, in m")
        colours.ax.yaxis.set_major_formatter("{x:g}")
        for model in landmarks.models:
            if model.geometry is not None:
                place = model.geometry.x_m, model.geometry.y_m
                axes.plot(*place, "*", ms=14, color=_STANDS, mec="white")
                axes.annotate(model.name, place, (8, 6), textcoords="offset points", color=_STANDS, weight="bold")
        for number, one in enumerate(weak):
            axes.add_patch(Circle((one.x_m, one.y_m), _CELL_M / 2, fill=False, ls="--", ec=_ASKED))
            if number < _NAMED:
                axes.annotate(
                    "teach one here",
                    (one.x_m, one.y_m + _CELL_M / 2),
                    (0, 4),
                    textcoords="offset points",
                    ha="center",
                    color=_ASKED,
                )
        axes.set(xlabel="x in m", ylabel="y in m", aspect="equal")
        axes.grid()
        if not seen.all():
            axes.legend(loc="upper right")
    return figure


def landmark_png(landmarks: LandmarkMap) -> bytes:
    """The same as the bytes of a picture."""
    data = io.BytesIO()
    landmark_map(landmarks).savefig(data, format="png", dpi=160, facecolor="white", metadata={"Software": None})
    return data.getvalue()
