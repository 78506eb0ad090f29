"""Recordings and a configuration in, a map out: the main path of the house."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, replace
from functools import partial

import numpy as np

from andante.errors import RecordingError
from andante.mapping.calibration import calibrate
from andante.mapping.codes import Codes
from andante.mapping.compact import CompactModel
from andante.mapping.config import MapConfig
from andante.mapping.frontend import FrontEnd, camera_and_size
from andante.mapping.learning import Ground, Learnt, Recipe, learn_slow
from andante.mapping.lessons import Lessons, lessons_of, readout_of, try_held_out
from andante.mapping.located import Readout
from andante.mapping.memory import MappedSession, bounded
from andante.mapping.network import crosses_seam
from andante.mapping.network_lesson import encode_with_network
from andante.mapping.odometry import in_one_frame
from andante.mapping.off_path import ViewBounds, try_views
from andante.mapping.scenery import Drives, Scenery
from andante.mapping.selection import choose_caution, choose_recipe
from andante.mapping.sessions import (
    BuildLog,
    Progress,
    encode_session,
    positions_of,
    require_distinct,
    unused_positions,
)
from andante.mapping.slow_map import SlowMap, Unit
from andante.protocols import Recording
from andante.sfa import one_thread


def build_map(
    recordings: Sequence[Recording],
    config: MapConfig | None = None,
    *,
    name: str = "andante",
    progress: Progress | None = None,
    log: BuildLog | None = None,
) -> SlowMap:
    """Learn a map from recordings with known positions (thesis 5.1).

    All recordings share one frame of reference and a camera of one kind; where only odometry is known, they are laid
    over each other by what they see (see ``andante.mapping.odometry``). ``progress`` is told of every stage, ``log``
    filled in. Raises ``RecordingError`` for recordings that cannot be used (no positions, unreadable images) and
    ``LearningError`` where they do not suffice. The same recordings and configuration give the same map.
    """
    config, log = config or MapConfig(), log or BuildLog()
    positions = positions_of(recordings, config.positions)
    if config.positions == "auto" and (hint := unused_positions(recordings, positions)):
        log.hints.append(hint)
    front_end = FrontEnd(*camera_and_size(recordings[0]), config.panorama, config.features)
    # Pictures to features, in the threads that decode; then everything that is learnt.
    if front_end.lacks_network:
        front_end, sessions = encode_with_network(recordings, front_end, positions, config, progress=progress, log=log)
    else:
        sessions = [encode_session(one, front_end, positions, config, progress=progress, log=log) for one in recordings]
    if positions == "odometry":
        sessions, closings = in_one_frame([], list(zip(sessions, recordings, strict=True)), config.drift)
        log.closings += closings
    return learn_map(sessions, front_end, config, name=name, progress=progress, log=log)


def learn_map(
    sessions: Sequence[MappedSession],
    front_end: FrontEnd,
    config: MapConfig | None = None,
    *,
    name: str = "andante",
    progress: Progress | None = None,
    log: BuildLog | None = None,
) -> SlowMap:
    """What ``build_map`` does once the pictures have become features: the same sessions always give the same map.

    Raises ``RecordingError`` for sessions that are copies of each other, ``LearningError`` for too little data.
    """
    config, log = config or MapConfig(), log or BuildLog()
    progress = progress or (lambda stage, done, total: None)
    if not sessions:
        raise RecordingError("a map needs at least one recording, got none")
    require_distinct(sessions)
    sessions = bounded(sessions, config.memory.max_frames)
    features = Codes.joined([session.codes for session in sessions])
    # How to learn is chosen and tried on held-out sessions, then all of them are learnt from.
    with log.timed("learn"):
        progress("learn", 0, 3)
        lessons = lessons_of(sessions, features, config, front_end.phase_encoder)
        pca, ground = lessons.pca, lessons.ground
        # Many small problems: on a busy machine two threads of BLAS wait for each other longer than they work.
        with one_thread():
            recipe = choose_recipe(lessons, config)
            caution = choose_caution(lessons, recipe, config)
        progress("learn", 1, 3)
        learnt = learn_slow(lessons.x, ground, recipe, config.seed)
        recipe = replace(recipe, slow_features=learnt.model.output_dim)
        asked, config = config, config.with_values({"readout": {"caution": caution}})
        progress("learn", 2, 3)
    with log.timed("readout"):
        with one_thread():
            locate_fold = partial(try_held_out, lessons, recipe, config)
            calibration = calibrate(ground, lessons.heading, lessons.folds, locate_fold, config.calibration.coverage)
        model = CompactModel.of(learnt.model if pca is None else learnt.model.after(pca))
        readout = _final_readout(features, model, learnt, ground, config)
        scenery, views = _imagination(lessons, sessions, config)
        progress("learn", 3, 3)
    return SlowMap(
        config=_resolved(config, sessions, front_end, ground, recipe),
        asked=asked,
        front_end=front_end,
        model=model,
        readout=readout,
        compass=lessons.compass(np.ones(len(ground), dtype=np.bool_)),
        scenery=scenery,
        calibration=replace(calibration, views=views),
        sources=tuple(session.source for session in sessions),
        pictures=tuple(session.pictures for session in sessions),
        unit=_unit(sessions),
        name=name,
        memory=tuple(sessions) if config.memory.keep else None,
    )


def _imagination(
    lessons: Lessons, sessions: Sequence[MappedSession], config: MapConfig
) -> tuple[Scenery | None, ViewBounds | None]:
    """What the drives show of their surroundings, and what may be promised of it; ``None`` where that is nothing."""
    if not config.off_path.enabled or lessons.phase_encoder is None:
        return None, None
    poses = np.concatenate([session.poses for session in sessions])
    ground = lessons.ground
    drives = Drives(lessons.phase_encoder, lessons.phase, poses, ground.session, ground.radius)
    views = try_views(drives, coverage=config.calibration.coverage, seed=config.seed)
    scenery = None if views is None else Scenery.fit(drives, seed=config.seed)
    return (None, None) if scenery is None else (scenery, views)


def _unit(sessions: Sequence[MappedSession]) -> Unit:
    return "place" if sessions[0].source.poses == "place" else "m"


def _final_readout(features: Codes, model: CompactModel, learnt: Learnt, ground: Ground, config: MapConfig) -> Readout:
    slow, spread = np.empty((len(features), model.output_dim)), np.empty(len(features))
    for covered, vectors in features.chunks():
        slow[covered], spread[covered] = model.transform(vectors), model.spread(vectors)
    return readout_of(slow, learnt, ground, config, spread)


def _resolved(
    config: MapConfig, sessions: Sequence[MappedSession], front_end: FrontEnd, ground: Ground, recipe: Recipe
) -> MapConfig:
    """The configuration as it came out, with no default left open."""
    return config.with_values(
        {
            "positions": sessions[0].source.poses,
            "panorama": asdict(front_end.geometry),
            "features": {"kind": front_end.feature_kind},
            "network": {"wrap": crosses_seam(config.network, front_end)},
            "learning": {
                "place_radius_m": ground.radius,
                "slow_features": recipe.slow_features,
                "edge_ridge": recipe.edge_ridge,
                "invariance": recipe.invariance,
            },
            "readout": {"consensus_m": config.readout.consensus_m or 2 * ground.radius},
            "calibration": {"block_m": config.calibration.block_m or 4 * ground.radius},
        }
    )
