"""Thesis 7.4.3: what more landmarks bring, and what they cost."""

from __future__ import annotations

import time
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from andante.evaluation.experiments.landmark_trials import Boxes, Trialled, album_of, learnt, tried_on
from andante.evaluation.experiments.landmark_world import TEST
from andante.evaluation.experiments.outcome import Plot, Table
from andante.evaluation.experiments.trials import Bench
from andante.landmarks.boxes import Detection
from andante.landmarks.views import ViewCutter
from andante.mapping.landmark_sights import fused, trusted
from andante.mapping.landmarks import LandmarkMap
from andante.sfa import one_thread

_ORDERS = 743  # tells this use of the seed from others; the thesis' section
_TIMED = 40


def scaling(bench: Bench, names: Sequence[str], boxes: Boxes, seed: int, *, permutations: int) -> dict[str, Any]:
    """Median errors with the first 1 .. m landmarks of random orders, and the time of an image.

    Of those that are mapped and found in the test at all: of others there is no error.
    """
    landmarks = learnt(bench, names, boxes)
    test = boxes(TEST)
    tried = tried_on(landmarks, album_of(bench, [TEST], names, boxes))
    found = {one.model.name for sights in tried.sights for one in sights}
    names = [name for name in names if name in found]
    rng = np.random.default_rng([seed, _ORDERS])
    medians = np.empty((permutations, len(names)))
    for done, row in enumerate(medians, start=1):
        order = rng.permutation(len(names))
        row[:] = [_median(tried, {names[k] for k in order[: size + 1]}) for size in range(len(names))]
        bench.progress("permutations", done, permutations)
    return {
        "landmarks": list(names),
        "permutations": permutations,
        "median_m": np.median(medians, axis=0).tolist(),
        "variance_m2": medians.var(axis=0).tolist(),
        "lowest_m": medians.min(axis=0).tolist(),
        "highest_m": medians.max(axis=0).tolist(),
        "ms_per_image": [_ms_per_image(bench, landmarks, names[: k + 1], test) for k in range(len(names))],
    }


def _median(tried: Trialled, names: set[str]) -> float:
    """Median error where only some landmarks count, over the frames that show one of them."""
    landmarks, errors = tried.landmarks, list[float]()
    for sights, truth in zip(tried.sights, tried.truth, strict=True):
        some = trusted([one for one in sights if one.model.name in names])
        if some:
            pose = fused(some, landmarks.config.fusion, landmarks.calibration.correlation).pose
            errors.append(float(np.linalg.norm(pose[:2] - truth[:2])))
    return float(np.median(errors))


def _ms_per_image(
    bench: Bench, landmarks: LandmarkMap, names: Sequence[str], detections: Sequence[Sequence[Detection]]
) -> float:
    """From the boxes in an image to the estimate, in one thread, as the median over some images."""
    recording, camera = bench.recording(TEST), bench.plan.camera
    cutter = ViewCutter(recording.camera, (camera.height_px, camera.width_px))
    indices = np.unique(np.linspace(0, len(detections) - 1, _TIMED).astype(int)).tolist()
    seconds = []
    with one_thread():
        for frame in recording.frames(indices):
            boxes = [one for one in detections[frame.info.index] if one.name in names]
            start = time.perf_counter()
            landmarks.estimate(landmarks.signature(frame.image, boxes, cutter))
            seconds.append(time.perf_counter() - start)
    return 1000.0 * float(np.median(seconds))


def curve_table(curve: Mapping[str, Any]) -> Table:
    """A row for each number of landmarks."""
    columns = ("landmarks", "median [m]", "variance [m²]", "lowest [m]", "highest [m]", "time [ms]")
    keys = ("median_m", "variance_m2", "lowest_m", "highest_m", "ms_per_image")
    rows = tuple((str(k + 1), *(curve[key][k] for key in keys)) for k in range(len(curve["landmarks"])))
    title = f"18 x 18 m, one to ten landmarks, {curve['permutations']} random orders (figure 7.12)"
    return Table(title, columns, rows)


def curve_plot(curve: Mapping[str, Any]) -> Plot:
    """As figure 7.12."""
    from andante.evaluation.experiments.landmark_plots import error_over_landmarks

    return Plot("", "Median error over the number of landmarks.", error_over_landmarks(curve))
