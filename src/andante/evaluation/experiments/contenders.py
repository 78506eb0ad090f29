"""The localizers that experiments compare; another one is one more entry."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from andante.baselines import NearestNeighbours
from andante.data import FloatArray
from andante.evaluation.alignment import fit_rigid
from andante.evaluation.experiments.drives import EncodedDrive
from andante.mapping import FrontEnd, MapConfig, SlowMap, learn_map
from andante.mapping.codes import Codes
from andante.mapping.config import FeatureConfig
from andante.mapping.frontend import Encoded
from andante.mapping.network_lesson import learn_network
from andante.mapping.odometry import in_one_frame
from andante.mapping.readout import fit_readout

Locate = Callable[[EncodedDrive], FloatArray]
"""A drive -> positions (n, 2), the best hypothesis for every frame."""


@dataclass(frozen=True)
class Fitted:
    """A localizer that has learnt, and the ``bytes`` that it keeps."""

    locate: Locate
    bytes: int


Fit = Callable[[FrontEnd, Sequence[EncodedDrive], MapConfig], Fitted]


@dataclass(frozen=True)
class Contender:
    """A localizer by name: ``config`` decides its features, ``fit`` learns from drives.

    ``detail`` is whatever else decides what ``fit`` does, so that finished results are told apart.
    """

    name: str
    config: MapConfig = field(repr=False)
    fit: Fit = field(repr=False)
    detail: tuple[int, ...] = field(default=(), repr=False)

    @property
    def key(self) -> dict[str, Any]:
        """Plain values that change with what the contender does."""
        return {"name": self.name, "detail": list(self.detail), "config": self.config.model_dump(mode="json")}


def fit_map(front_end: FrontEnd, drives: Sequence[EncodedDrive], config: MapConfig) -> Fitted:
    """A map of the drives, as ``andante map`` makes it."""
    slowmap = learn_map([drive.session for drive in drives], front_end, config)

    def locate(drive: EncodedDrive) -> FloatArray:
        return _located(slowmap, drive, drive.features)

    return Fitted(locate, _file_bytes(slowmap))


def fit_network(front_end: FrontEnd, drives: Sequence[EncodedDrive], config: MapConfig) -> Fitted:
    """A map of the drives with a network that is learnt from their panoramas."""
    sessions = [drive.session for drive in drives]
    taught = front_end.with_network(learn_network([drive.features for drive in drives], sessions, front_end, config))
    encoded = [replace(one.session, codes=Codes.of(taught.encoder.encode(one.features))) for one in drives]
    slowmap = learn_map(encoded, taught, config)

    def locate(drive: EncodedDrive) -> FloatArray:
        return _located(slowmap, drive, taught.encoder.encode(drive.features))

    return Fitted(locate, _file_bytes(slowmap))


def fit_odometry(front_end: FrontEnd, drives: Sequence[EncodedDrive], config: MapConfig) -> Fitted:
    """A map of the drives that knows their odometry alone, laid over the truth of these drives once, without scale."""
    unplaced = [
        (replace(one.session, source=replace(one.session.source, poses="odometry")), one.recording) for one in drives
    ]
    placed, _ = in_one_frame([], unplaced, config.drift)
    slowmap = learn_map(placed, front_end, config)
    laid = fit_rigid(np.concatenate([one.xy for one in placed]), np.concatenate([one.xy for one in drives]), "drives")

    def locate(drive: EncodedDrive) -> FloatArray:
        return laid.out_of_map(_located(slowmap, drive, drive.features))

    return Fitted(locate, _file_bytes(slowmap))


def fit_neighbours(neighbours: int, front_end: FrontEnd, drives: Sequence[EncodedDrive], config: MapConfig) -> Fitted:
    """Plain nearest neighbours among all frames of the drives."""
    features, xy = _joined(drives)
    nearest = NearestNeighbours.fit(front_end, "m", features, xy, neighbours)

    def locate(drive: EncodedDrive) -> FloatArray:
        return np.stack([nearest.position(query) for query in drive.features])

    # Kept in one byte a number, as a map keeps its references, they would take a quarter of what they take here.
    return Fitted(locate, nearest.features.nbytes // 4 + nearest.xy.nbytes)


def fit_split(
    regressed: tuple[int, ...], front_end: FrontEnd, drives: Sequence[EncodedDrive], config: MapConfig
) -> Fitted:
    """The thesis' protocol for one recording (6.3.1): slow features of all frames, a regression of some of them."""
    features, xy = _joined(drives)
    slowmap, chosen = learn_map([drive.session for drive in drives], front_end, config), list(regressed)
    readout = fit_readout(
        slowmap.model.transform(features[chosen]),
        xy[chosen],
        np.zeros(len(chosen), dtype=np.int64),
        metric=np.ones(slowmap.model.output_dim),
        config=config.readout,
        consensus_m=slowmap.config.readout.consensus_m or np.inf,
    )

    def locate(drive: EncodedDrive) -> FloatArray:
        return readout.locate(slowmap.model.transform(drive.features)).xy

    return Fitted(locate, _file_bytes(slowmap))


ANDANTE = Contender("andante", MapConfig(), fit_map)
THESIS = Contender("thesis choices (Fourier)", MapConfig.thesis(), fit_map)
ODOMETRY = Contender("andante, odometry only", MapConfig(), fit_odometry)
PIXELS = Contender("andante, pixels", MapConfig(features=FeatureConfig(kind="pixels")), fit_network)
THESIS_PIXELS = Contender("thesis choices (raw images)", MapConfig.thesis_pixels(), fit_network)
NEAREST = tuple(Contender(f"nearest-{count}", MapConfig(), partial(fit_neighbours, count)) for count in (1, 5))
CONTENDERS = (ANDANTE, THESIS, *NEAREST)
"""Those that know where the mapped frames were taken, the package's own first."""
ODOMETRY_NOTE = (
    f"{ODOMETRY.name} knows no true positions: its map is laid over the truth of the mapped drives by one rotation and "
    "translation"
)
NETWORK_NOTE = (
    f"{PIXELS.name} and {THESIS_PIXELS.name} learn a network from the panoramas of the mapped drives in every trial, "
    "which counts as learning"
)
NEAREST_NOTE = (
    "nearest-1 and nearest-5 see the features of andante; their size counts one byte a number, as in its maps, "
    "although here they keep four"
)


def _located(slowmap: SlowMap, drive: EncodedDrive, features: NDArray[np.float32]) -> FloatArray:
    return slowmap.sight(Encoded(features, drive.session.phase.rows())).located.xy


def _joined(drives: Sequence[EncodedDrive]) -> tuple[NDArray[np.float32], FloatArray]:
    return np.concatenate([drive.features for drive in drives]), np.concatenate([drive.xy for drive in drives])


def _file_bytes(slowmap: SlowMap) -> int:
    """Of what localizing needs; the frames that a map remembers to learn from once more are left out."""
    slowmap = replace(slowmap, memory=None)
    with tempfile.TemporaryDirectory(prefix="andante-") as folder:
        return slowmap.save(Path(folder) / "a.andante")
