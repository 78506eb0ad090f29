"""The way of a track, with how sure it was of every pose."""

from __future__ import annotations

import matplotlib as mpl
import numpy as np
from matplotlib.collections import EllipseCollection, LineCollection

from andante.data import Estimate, FloatArray, Status
from andante.evaluation.comparison import Scored
from andante.evaluation.figures import WRONG_M, best_guess, truth_of
from andante.evaluation.plots import INK, STATUS_COLOURS, STYLE, new_figure, svg
from andante.evaluation.status_plots import statuses_of
from andante.mapping.uncertainty import RADIUS_OF_90_PERCENT

_ELLIPSES = 40  # more, or larger ones, would hide the way
_LARGEST_M = 3.0


def way(scored: Scored, references: FloatArray) -> str | None:
    """Truth as a line, poses coloured by status with 90 % ellipses, ``references`` (r, 2) of the map in grey.

    Poses more than 1 m off are tied to the truth; where a frame has no pose its truth is crossed out. ``None`` for a
    track without any pose.
    """
    estimates = [frame.estimate for frame in scored.run.frames]
    guess = np.array([best_guess(one, "m") for one in estimates]).reshape(-1, 2)
    truth = truth_of([frame.info for frame in scored.run.frames], "m")
    posed = np.array([one.status.has_pose for one in estimates], dtype=bool) & np.isfinite(guess).all(axis=1)
    if not posed.any():
        return None
    statuses = statuses_of(scored)
    with mpl.rc_context(STYLE):
        figure, axes = new_figure(5.0)
        axes.plot(*references.T, ".", ms=3.0, color=INK, alpha=0.3, label="mapped", rasterized=True)
        if np.isfinite(truth).any():
            axes.plot(*truth.T, "-", color=INK, lw=0.9, label="truth")
        wrong = posed & (scored.errors > WRONG_M)
        axes.add_collection(
            LineCollection(list(np.stack([truth[wrong], guess[wrong]], axis=1)), lw=0.4, color=INK, alpha=0.6)
        )
        for status in (Status.DEGRADED, Status.OK):
            chosen = posed & (statuses == str(status))
            if chosen.any():
                colour = STATUS_COLOURS[status]
                x, y = guess[chosen].T
                axes.plot(x, y, ".", ms=3.5, color=colour, label=str(status), rasterized=True)
                axes.add_collection(_ellipses([estimates[at] for at in np.flatnonzero(chosen)], colour, axes.transData))
        lost = ~posed & np.isfinite(truth).all(axis=1)
        if lost.any():
            axes.plot(*truth[lost].T, "x", ms=4, mew=0.8, color=STATUS_COLOURS[Status.LOST], label="truth while lost")
        axes.set(xlabel="x in m", ylabel="y in m", aspect="equal")
        axes.autoscale_view()
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=5, columnspacing=1.0)
        return svg(figure)


def ellipse_axes(estimate: Estimate) -> tuple[float, float, float] | None:
    """Half axes in metres, longer first, and its angle in radians, of the ellipse that promises to hold 90 %.

    Shaped as the covariance and as large as the calibrated radius; of a Gaussian where no radius is given. ``None``
    without a covariance.
    """
    if estimate.covariance is None or not np.isfinite(estimate.covariance[:2, :2]).all():
        return None
    values, vectors = np.linalg.eigh(estimate.covariance[:2, :2])
    values = np.maximum(values, 0.0)
    total = float(values.sum())
    if total <= 0.0:
        return None
    # A circle of the radius where the covariance is one.
    scale = RADIUS_OF_90_PERCENT if estimate.radius_m is None else estimate.radius_m / np.sqrt(total / 2)
    short, long = (scale * np.sqrt(values)).tolist()
    return long, short, float(np.arctan2(vectors[1, 1], vectors[0, 1]))


def _ellipses(estimates: list[Estimate], colour: str, data: mpl.transforms.Transform) -> EllipseCollection:
    """Of frames spread evenly over those given, but for radii of more than 3 m."""
    every = max(1, len(estimates) // _ELLIPSES)
    shapes_of = ((one, ellipse_axes(one)) for one in estimates[::every])
    drawn = [(one, shape) for one, shape in shapes_of if shape is not None and shape[0] <= _LARGEST_M]
    shapes = np.array([shape for _, shape in drawn]).reshape(-1, 3)
    centres = np.array([best_guess(one, "m") for one, _ in drawn]).reshape(-1, 2)
    return EllipseCollection(
        2 * shapes[:, 0], 2 * shapes[:, 1], np.degrees(shapes[:, 2]),
        units="xy", offsets=centres, offset_transform=data, facecolors=colour, edgecolors=colour, alpha=0.18, lw=0.5,
    )  # fmt: skip
