"""Whether the parts of a map file fit each other: no shape and no number that localizing would stumble over."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.errors import MapError
from andante.landmarks.detector import MAX_BYTES
from andante.mapping.calibration import Calibration
from andante.mapping.codes import LARGEST_CODE, Codes
from andante.mapping.compact import CompactModel
from andante.mapping.compass import Compass
from andante.mapping.config import MAX_DEGREE
from andante.mapping.frontend import FrontEnd
from andante.mapping.landmarks import LandmarkMap
from andante.mapping.located import Readout
from andante.mapping.memory import Source, phase_of, rows_of
from andante.mapping.readout import LocalReadout
from andante.mapping.regressions import GaussianProcessReadout, PolynomialReadout
from andante.mapping.scenery import Scenery
from andante.sfa.arrays import require_names

_FARTHEST, _FINEST_M, _MOST_CELLS = 1e9, 1e-3, 1e3


def check_parts(front_end: FrontEnd, model: CompactModel, readout: Readout) -> None:
    """Every product that localizing will form and every number that it divides by; raises ``MapError``."""
    r = len(model.weights)
    k = r if model.quadratic is None else model.quadratic.output_dim
    _expect("model.mean", model.mean, (front_end.dim,), "f4")
    _expect("model.weights", model.weights, (r, front_end.dim), "f2")
    _expect("model.scale", model.scale, (r,), "f4")
    _expect("model.deltas", model.deltas, (k,), "f8")
    if model.quadratic is not None:
        _expect("model.quadratic.weights", model.quadratic.weights, (r + r * (r + 1) // 2, k), "f8")
    if isinstance(readout, LocalReadout):
        _check_local(readout, k)
    elif isinstance(readout, PolynomialReadout):
        _check_polynomial(readout, k)
    elif isinstance(readout, GaussianProcessReadout):
        _check_gaussian_process(readout, k)


def check_compass(compass: Compass) -> None:
    """Whether signatures, places and encoder fit each other; raises ``MapError``."""
    count = len(compass.codes)
    _check_codes("compass", compass.codes, count, compass.encoder.dim)
    _expect("compass.xy", compass.xy, (count, 2), "f8")
    if not count or not _FINEST_M <= compass.cell_m <= _FARTHEST:
        raise MapError(f"a compass of {count} places of {compass.cell_m:g} m")
    if (np.abs(compass.xy) > _FARTHEST).any():
        raise MapError(f"array compass.xy holds numbers beyond {_FARTHEST:g}")


def check_landmarks(landmarks: LandmarkMap) -> None:
    """Whether each landmark's window, slow features, readout and geometry fit each other; raises ``MapError``."""
    _expect("landmarks.places", landmarks.places, (len(landmarks.places), 3), "f8")
    for number, one in enumerate(landmarks.models):
        section, rows = f"landmarks.{number}", one.model.weights.shape[0]
        _expect(f"{section}.model.mean", one.model.mean, (one.view_dim,), "f4")
        _expect(f"{section}.model.weights", one.model.weights, (rows, one.view_dim), "f2")
        _expect(f"{section}.model.scale", one.model.scale, (rows,), "f4")
        _expect(f"{section}.model.deltas", one.model.deltas, (rows,), "f8")
        if one.model.quadratic is not None:
            raise MapError(f"{section} has a quadratic model, landmarks have linear ones")
        _check_local(one.readout, rows)
        _expect_positive(one.scale, one.error_m)
        if one.geometry is not None:
            _expect_positive(one.geometry.bearing_rad, one.geometry.rise_sigma)
    if landmarks.detector is not None and len(landmarks.detector) > MAX_BYTES:
        raise MapError(
            f"its landmark detector has {len(landmarks.detector):,} bytes, at most {MAX_BYTES:,} are allowed"
        )
    known = landmarks.calibration
    _expect_positive(known.radius_factor, known.usual_radius_m, known.heading_factor or 1.0)
    if not 0.0 <= known.correlation <= 1.0:
        raise MapError(f"the errors of landmarks have a correlation of {known.correlation}, from 0 to 1 is allowed")


def check_scenery(scenery: Scenery) -> None:
    """Whether things, their looks and the area fit each other; raises ``MapError``."""
    count = len(scenery.codes)
    _check_codes("scenery", scenery.codes, count, scenery.encoder.bands)
    _expect("scenery.xy", scenery.xy, (count, 2), "f4")
    _expect("scenery.distance", scenery.distance_m, (count,), "f4")
    _expect("scenery.area", scenery.area, (2, 2), "f8")
    size = scenery.area[1] - scenery.area[0]
    if (
        not count
        or scenery.distance_m.min() <= 0
        or max(np.abs(scenery.xy).max(), np.abs(scenery.area).max()) > _FARTHEST
    ):
        raise MapError("a scenery without things, or with things that are nowhere")
    if not (_FINEST_M <= scenery.radius_m <= _FARTHEST and size.min() > 0 and size.max() < _MOST_CELLS * size.min()):
        raise MapError(f"a scenery of places of {scenery.radius_m:g} m on {size[0]:g} x {size[1]:g} m")


def check_sources(sources: Sequence[Source], pictures: NDArray[Any], calibration: Calibration) -> None:
    """Whether the map's sources, their fingerprints and the trials on them speak of the same; raises ``MapError``."""
    if any(source.frames < 0 for source in sources):
        raise MapError("a source has fewer than 0 frames")
    _expect("pictures", pictures, (sum(source.frames for source in sources),), "u4")
    for fold in calibration.folds:
        if not all(0 <= session < len(sources) for session in fold.sessions):
            raise MapError(f"trial {fold.left_out!r} speaks of sessions {fold.sessions}, but there are {len(sources)}")


def check_memory(arrays: Mapping[str, NDArray[Any]], sources: Sequence[Source], front_end: FrontEnd) -> None:
    """Whether what a map remembers fits its sources and its features; raises ``MapError``."""
    names = ("codes", "scale", "phase.codes", "phase.scale", "xy", "heading", "number")
    require_names(arrays, names, "the memory of a map")
    n = sum(source.frames for source in sources)
    _check_codes("memory", Codes.from_arrays(arrays), n, front_end.dim)
    _check_codes("memory.phase", phase_of(arrays), n, front_end.phase_dim)
    _expect("memory.xy", arrays["xy"], (n, 2), "f8")
    _expect("memory.heading", arrays["heading"], (n,), "f8")
    _expect("memory.number", arrays["number"], (n,), "i8")
    for rows in rows_of(sources):
        number = arrays["number"][rows]
        if len(number) and (number[0] < 0 or (np.diff(number) <= 0).any()):
            raise MapError("array memory.number does not count the frames of a drive upwards from 0 or more")
    if (np.abs(arrays["xy"]) > _FARTHEST).any() or (np.abs(arrays["heading"]) > _FARTHEST).any():
        raise MapError(f"array memory.xy or memory.heading holds numbers beyond {_FARTHEST:g}")


def _check_codes(section: str, codes: Codes, count: int, dim: int) -> None:
    _expect(f"{section}.codes", codes.codes, (count, dim), "i1")
    _expect(f"{section}.scale", codes.scale, (count,), "f4")
    if count and (codes.codes.min(initial=0) < -LARGEST_CODE or codes.scale.min() < 0):
        raise MapError(f"array {section}.codes or {section}.scale holds what nothing is coded as")


def _check_local(readout: LocalReadout, k: int) -> None:
    count = len(readout.codes)
    _check_codes("readout", readout.codes, count, k)
    _expect("readout.xy", readout.xy, (count, 2), "f8")
    _expect("readout.spread", readout.spread, (count,), "f4")
    _expect("readout.metric", readout.metric, (k,), "f8")
    if not 1 <= readout.neighbours <= count:
        raise MapError(f"{readout.neighbours} neighbours of {count} references")
    _expect_positive(readout.typical, readout.sharpness, readout.consensus_m, readout.floor_m)
    if not readout.caution >= 0:
        raise MapError(f"the caution of the readout is {readout.caution}, but has to be 0 or more")


def _check_polynomial(readout: PolynomialReadout, k: int) -> None:
    # The number of terms comes last: for absurd numbers it takes longer than a life to work out.
    if not (1 <= readout.inputs <= k and 1 <= readout.degree <= MAX_DEGREE):
        raise MapError(f"a polynomial of degree {readout.degree} in {readout.inputs} of {k} slow features")
    _expect("readout.coefficients", readout.coefficients, (readout.terms, 2), "f8")
    _expect("readout.residual", readout.residual, (2, 2), "f8")


def _check_gaussian_process(readout: GaussianProcessReadout, k: int) -> None:
    count = len(readout.points)
    _expect("readout.points", readout.points, (count, k), "f8")
    _expect("readout.metric", readout.metric, (k,), "f8")
    _expect("readout.dual", readout.dual, (count, 2), "f8")
    _expect("readout.factor", readout.factor, (count, count), "f8")
    _expect("readout.mean", readout.mean, (2,), "f8")
    _expect_positive(readout.length, readout.noise, readout.prior, *np.diag(readout.factor).tolist())


def _expect(name: str, array: NDArray[Any], shape: tuple[int, ...], dtype: str) -> None:
    if array.shape != shape or array.dtype != np.dtype(dtype):
        raise MapError(f"array {name} is {array.dtype} of shape {array.shape}, expected {np.dtype(dtype)} {shape}")


def _expect_positive(*numbers: float) -> None:
    for number in numbers:
        if not number > 0:
            raise MapError(f"a number of the readout is {number}, but has to be above zero")
