"""Recordings and a configuration in, a map out: the main path of the house."""

from __future__ import annotations

import os
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from itertools import combinations, islice

import numpy as np
from numpy.typing import NDArray

from andante.data import FloatArray, Frame, FrameInfo, ImageArray, Trajectory
from andante.errors import LearningError, RecordingError
from andante.mapping.calibration import Calibration, calibrate
from andante.mapping.compact import CompactModel
from andante.mapping.config import MapConfig, Positions
from andante.mapping.frontend import FrontEnd, camera_and_size
from andante.mapping.learning import Ground, Learnt, learn_slow, learning_edges, typical_radius
from andante.mapping.located import Located, Readout
from andante.mapping.readout import fit_readout
from andante.mapping.slow_map import MAX_SHARED_PICTURES, SlowMap, Source, Unit
from andante.mapping.store import FeatureStore
from andante.mapping.timing import TimedRecording
from andante.protocols import Recording, StoredRecording
from andante.recordings import default_workers, map_frames, moving_frames, picture_fingerprint
from andante.sfa import PCA, pca_of_samples

Progress = Callable[[str, int, int], None]
"""Called with a stage, the steps done and the steps in all."""

_PCA_SAMPLE = 800
_STACK = 8
_LEAST_RADIUS_M = 0.35
_APART_RADII = 4
_LEAST_RADIUS_PLACES = 1.5


@dataclass
class BuildLog:
    """What happened while a map was built: seconds by stage, and frames left out before their picture was read."""

    seconds: dict[str, float] = field(default_factory=dict)
    stationary: int = 0
    without_position: int = 0

    @contextmanager
    def timed(self, stage: str) -> Iterator[None]:
        """Add the time spent inside to a stage."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.seconds[stage] = self.seconds.get(stage, 0.0) + time.perf_counter() - start


def build_map(
    recordings: Sequence[Recording],
    config: MapConfig | None = None,
    *,
    name: str = "andante",
    progress: Progress | None = None,
    log: BuildLog | None = None,
) -> SlowMap:
    """Learn a map from recordings with known positions (thesis 5.1).

    All recordings share one frame of reference and a camera of one kind. ``progress`` is told of every stage, ``log``
    filled in. Raises ``RecordingError`` for recordings that cannot be used (no positions, unreadable images) and
    ``LearningError`` where they do not suffice. The same recordings and configuration give the same map.
    """
    config, log = config or MapConfig(), log or BuildLog()
    progress = progress or (lambda stage, done, total: None)
    hashes = _distinct_hashes(recordings)
    # Frames that can be mapped: with a position, and not standing still.
    positions = _positions_of(recordings, config.positions)
    sessions = [_Session(one, *usable_frames(one, positions, config, log)) for one in recordings]
    # Pictures to feature vectors, in the threads that decode.
    front_end = FrontEnd(*camera_and_size(recordings[0]), config.panorama, config.features)
    front_ends = [front_end, *(front_end.for_recording(one) for one in recordings[1:])]
    with FeatureStore(front_end.dim) as store:
        with log.timed("features"):
            pairs = zip(sessions, front_ends, strict=True)
            encoded = [_encode(session, eye, store, progress, log) for session, eye in pairs]
        _require_distinct_pictures(recordings, [pictures for _, pictures in encoded])
        skipped = [missing for missing, _ in encoded]
        ground = _ground(sessions, skipped, config, positions)
        # Features to slow features, tried on held-out parts first.
        with log.timed("learn"):
            progress("learn", 0, 1)
            pca, compressed, spread = _compress(store, config)
            learnt = learn_slow(compressed, learning_edges(ground, config.learning, config.seed), config.learning)
        with log.timed("readout"):
            names = [session.recording.name for session in sessions]
            calibration = _cross_validate(compressed, spread, ground, names, config)
            model = CompactModel.of(learnt.model if pca is None else learnt.model.after(pca))
            readout = _final_readout(store, model, learnt, ground, config)
            progress("learn", 1, 1)
    made_from = zip(sessions, hashes, encoded, strict=True)
    sources = tuple(_source(session, content, *found, positions) for session, content, found in made_from)
    unit: Unit = "place" if positions == "place" else "m"
    resolved = _resolved(config, positions, front_end, ground, learnt)
    return SlowMap(resolved, front_end, model, readout, calibration, sources, unit, name)


@dataclass(frozen=True)
class _Session:
    """One recording and the frames of it that can be mapped: indices (m,), positions (m, 2)."""

    recording: Recording
    indices: list[int]
    xy: FloatArray


def _distinct_hashes(recordings: Sequence[Recording]) -> list[str]:
    """The content hash of every recording; the same content twice would make the cross-validation see the answer."""
    if not recordings:
        raise RecordingError("a map needs at least one recording, got none")
    hashes: list[str] = []
    for recording in recordings:
        content = recording.content_hash()
        if content in hashes:
            twin = recordings[hashes.index(content)].name
            raise RecordingError(f"recordings {twin!r} and {recording.name!r} have the same content; leave one out")
        hashes.append(content)
    return hashes


def _require_distinct_pictures(recordings: Sequence[Recording], pictures: Sequence[list[str]]) -> None:
    """The same for copies that differ in their table or have frames cut away: at most 5 % of pictures in common."""
    for (one, own), (other, theirs) in combinations(zip(recordings, pictures, strict=True), 2):
        shared = len({*own} & {*theirs})
        if shared > MAX_SHARED_PICTURES * min(len(own), len(theirs)):
            raise RecordingError(
                f"recordings {one.name!r} and {other.name!r} have {shared} pictures in common; leave one out"
            )


def _positions_of(recordings: Sequence[Recording], wanted: Positions) -> Positions:
    """Resolve ``auto``: reference poses where all recordings have some, else place numbers.

    Odometry begins anew with every drive, so it is only chosen for a single recording.
    """
    if wanted != "auto":
        return wanted
    shared: tuple[Positions, ...] = ("reference", "place")
    for kind in shared if len(recordings) > 1 else (*shared, "odometry"):
        if all(np.isfinite(_xy(recording.infos, kind)).all(axis=1).any() for recording in recordings):
            return kind
    if len(recordings) == 1:
        raise RecordingError(
            f"recording {recordings[0].name!r} has neither reference poses, places nor odometry; a map needs x_m and "
            "y_m, place, or odom_x_m and odom_y_m in frames.csv"
        )
    lacking = [r.name for r in recordings if not np.isfinite(_xy(r.infos, "reference")).any()]
    raise RecordingError(
        f"recording {lacking[0]!r} has neither reference poses nor places in common with the others; a map of several "
        "drives needs x_m and y_m, or place, in frames.csv. If all drives began at one pose, --positions odometry is "
        "enough"
    )


def _xy(infos: Sequence[FrameInfo], positions: Positions) -> FloatArray:
    if positions == "place":
        return np.array([(np.nan if info.place is None else info.place, 0.0) for info in infos]).reshape(-1, 2)
    return Trajectory.of(infos, "odometry" if positions == "odometry" else "reference").xy_m


def usable_frames(
    recording: Recording, positions: Positions, config: MapConfig, log: BuildLog | None = None
) -> tuple[list[int], FloatArray]:
    """Indices (m,) and positions (m, 2) of the frames to learn from: position known, robot not standing still.

    Raises ``RecordingError`` where there is none.
    """
    infos = recording.infos
    xy = _xy(infos, positions)
    known = np.isfinite(xy).all(axis=1)
    if not known.any():
        columns = {"place": "place", "odometry": "odom_x_m and odom_y_m"}.get(positions, "x_m and y_m")
        raise RecordingError(
            f"recording {recording.name!r} has no {positions} positions ({columns} of frames.csv are blank); "
            "choose other --positions or fill them in"
        )
    # Of a stand, the first frame with a position is kept.
    usable = np.flatnonzero(known)
    chosen = usable[moving_frames([infos[index] for index in usable.tolist()], config.learning.stationary_m)]
    if log is not None:
        log.without_position += len(infos) - len(usable)
        log.stationary += len(usable) - len(chosen)
    return chosen.tolist(), xy[chosen]


def _encode(
    session: _Session, front_end: FrontEnd, store: FeatureStore, progress: Progress, log: BuildLog
) -> tuple[dict[int, str], list[str]]:
    """Store the features of a session.

    Gives index and reason of every frame that had to be skipped, and the fingerprints of the others.
    """
    recording, skipped = session.recording, dict[int, str]()

    def panorama(frame: Frame) -> tuple[ImageArray, str]:
        return front_end.grey_panorama(frame.image), picture_fingerprint(frame.image)

    def on_skip(info: FrameInfo, reason: str) -> None:
        # Where a recording lies is nobody's business in a map; only some reasons name the picture.
        if isinstance(recording, StoredRecording):
            reason = reason.replace(f"{recording.folder}{os.sep}", "")
        skipped[info.index] = reason if info.image in reason else f"{info.image}: {reason}"

    total, before = len(session.indices), store.rows
    # The threads decode and unwrap; encoding whole stacks here keeps the interpreter out of their way.
    timed = TimedRecording(recording)
    found = (result for _, result in map_frames(timed, panorama, session.indices, on_skip=on_skip))
    pictures: list[str] = []
    while stack := list(islice(found, _STACK)):
        store.extend(front_end.encoder.encode(np.stack([image for image, _ in stack])))
        pictures += [fingerprint for _, fingerprint in stack]
        progress(recording.name, min(total, store.rows - before + len(skipped)), total)
    # Decoding shares its threads and its time with the rest; its part is told apart from theirs.
    decode = timed.load_seconds / default_workers()
    log.seconds["decode"] = log.seconds.get("decode", 0.0) + decode
    log.seconds["features"] = log.seconds.get("features", 0.0) - decode
    return skipped, pictures


def _ground(sessions: list[_Session], skipped: list[dict[int, str]], config: MapConfig, positions: Positions) -> Ground:
    """Positions of the frames that were stored, in their order."""
    xy, session_numbers = [], []
    for count, (session, missing) in enumerate(zip(sessions, skipped, strict=True)):
        kept = [index not in missing for index in session.indices]
        xy.append(session.xy[kept])
        session_numbers.append(np.full(sum(kept), count, dtype=np.int64))
    together, session_of = np.concatenate(xy), np.concatenate(session_numbers)
    least = _LEAST_RADIUS_PLACES if positions == "place" else _LEAST_RADIUS_M
    radius = config.learning.place_radius_m or typical_radius(together, session_of, least)
    return Ground(together, session_of, np.arange(len(together)), radius)


def _compress(store: FeatureStore, config: MapConfig) -> tuple[PCA | None, NDArray[np.float32], FloatArray]:
    """Principal components of a sample spread over all sessions, all frames in them (n, p), and their spread (n,)."""
    if store.rows < 2:
        raise LearningError(f"{store.rows} usable frames are too few to learn from; record a longer drive")
    if config.learning.pca_components == 0:
        features = np.concatenate([rows for _, rows in store.chunks()])
        return None, features, np.linalg.norm(features - features.mean(axis=0), axis=1).astype(np.float64)
    sample = np.unique(np.linspace(0, store.rows - 1, min(store.rows, _PCA_SAMPLE)).astype(np.int64))
    pca = pca_of_samples(store.take(sample), config.learning.pca_components)
    mean, components = pca.mean.astype(np.float32), pca.components.astype(np.float32)
    compressed, spread = np.empty((store.rows, pca.output_dim), dtype=np.float32), np.empty(store.rows)
    for rows, vectors in store.chunks():
        centred = vectors - mean
        compressed[rows], spread[rows] = centred @ components, np.linalg.norm(centred, axis=1)
    return pca, compressed, spread


def _cross_validate(
    compressed: NDArray[np.float32], spread: FloatArray, ground: Ground, names: list[str], config: MapConfig
) -> Calibration:
    """Everything behind the compression is learnt anew without the held-out frames."""

    def locate_fold(train: NDArray[np.bool_], test: NDArray[np.bool_]) -> tuple[Located, FloatArray]:
        inside = ground.subset(train)
        x = compressed[train]
        learnt = learn_slow(x, learning_edges(inside, config.learning, config.seed), config.learning)
        readout = _readout(learnt.model.transform(x), learnt, inside, config, spread[train])
        slow = learnt.model.transform(compressed[test])
        apart = _APART_RADII * ground.radius
        return readout.locate(slow), readout.strangers(slow, ground.xy[test], apart, spread[test])

    return calibrate(ground, names, locate_fold, config.calibration)


def _readout(
    slow: FloatArray, learnt: Learnt, ground: Ground, config: MapConfig, spread: FloatArray | None = None
) -> Readout:
    consensus = config.readout.consensus_m or 2 * ground.radius
    return fit_readout(
        slow,
        ground.xy,
        ground.session,
        metric=learnt.metric,
        config=config.readout,
        consensus_m=consensus,
        spread=spread,
    )


def _final_readout(
    store: FeatureStore, model: CompactModel, learnt: Learnt, ground: Ground, config: MapConfig
) -> Readout:
    slow, spread = np.empty((store.rows, model.output_dim)), np.empty(store.rows)
    for rows, vectors in store.chunks():
        slow[rows], spread[rows] = model.transform(vectors), model.spread(vectors)
    return _readout(slow, learnt, ground, config, spread)


def _source(
    session: _Session, content_hash: str, skipped: dict[int, str], pictures: list[str], positions: Positions
) -> Source:
    recording = session.recording
    return Source(
        name=recording.name,
        content_hash=content_hash,
        frames=len(session.indices) - len(skipped),
        poses=positions,
        conditions=dict(recording.conditions),
        skipped=tuple(skipped.values()),
        pictures=tuple(pictures),
        folder=str(recording.folder.resolve()) if isinstance(recording, StoredRecording) else None,
    )


def _resolved(
    config: MapConfig, positions: Positions, front_end: FrontEnd, ground: Ground, learnt: Learnt
) -> MapConfig:
    """The configuration as it came out, with no default left open."""
    return config.with_values(
        {
            "positions": positions,
            "features": {"kind": front_end.feature_kind},
            "learning": {"place_radius_m": ground.radius, "slow_features": learnt.model.output_dim},
            "readout": {"consensus_m": config.readout.consensus_m or 2 * ground.radius},
            "calibration": {"block_m": config.calibration.block_m or 4 * ground.radius},
        }
    )
