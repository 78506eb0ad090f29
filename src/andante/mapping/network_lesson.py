"""Learning the network of a map, which has to be there before a drive can be encoded.

One pass reads all drives and keeps their panoramas in a temporary file. The network learns from these, and then they
are encoded, so that every picture is decoded once.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from andante.data import Edges, ImageArray
from andante.mapping.codes import Codes
from andante.mapping.config import MapConfig, Positions
from andante.mapping.frontend import FrontEnd
from andante.mapping.learning import Ground, edges_in_order
from andante.mapping.lessons import ground_of
from andante.mapping.memory import MappedSession
from andante.mapping.network import as_stored, crosses_seam, layers_of, require_room
from andante.mapping.sessions import STACK, BuildLog, Progress, read_session, require_distinct
from andante.protocols import Recording
from andante.sequences import place_edges, temporal_edges
from andante.sfa import HierarchicalModel, HierarchicalSFA
from andante.sfa.map_store import SpooledMaps
from andante.sfa.pictures import Pictures

_BATCH = 64
_GAPS = 3.0
"""Frames of a drive follow each other if they are at most so many usual steps apart."""


def encode_with_network(
    recordings: Sequence[Recording],
    front_end: FrontEnd,
    positions: Positions,
    config: MapConfig,
    *,
    progress: Progress | None = None,
    log: BuildLog | None = None,
) -> tuple[FrontEnd, list[MappedSession]]:
    """Learn a network from drives: ``front_end`` with it, and the drives with the features that it gives them.

    Raises as ``encode_session`` does, ``ConfigError`` for panoramas that are too small for the layers, and
    ``LearningError`` for drives that do not suffice.
    """
    log = log or BuildLog()
    require_room(config.network, front_end)
    panoramas = SpooledMaps((1, *front_end.panorama_shape), np.uint8)

    def keep(stack: ImageArray) -> None:
        panoramas.append(stack[:, None])

    drives = [read_session(one, front_end, positions, config, keep, progress=progress, log=log) for one in recordings]
    require_distinct(drives)

    def batches() -> Iterator[ImageArray]:
        for start in range(0, len(panoramas), _BATCH):
            yield panoramas.take(np.arange(start, min(start + _BATCH, len(panoramas))))[:, 0]

    with log.timed("network"):
        taught = front_end.with_network(learn_network(batches, drives, front_end, config, progress))
    with log.timed("features"):
        return taught, _encoded(panoramas, drives, taught, progress)


def network_edges(sessions: Sequence[MappedSession], config: MapConfig) -> Edges:
    """Which pictures of all sessions are alike for the network.

    With places, each picture and the next one of its drive, and about ``network.neighbours`` of other drives that were
    taken near it: every edge costs as much as a picture, so there are not as many as behind the network. Drives that
    know their odometry alone are not in one frame yet; they are learnt along time.
    """
    ground = ground_of(sessions, config)
    if sessions[0].source.poses == "odometry":
        return edges_in_order(ground, "temporal", config.seed)
    if config.learning.order != "places":
        return edges_in_order(ground, config.learning.order, config.seed)
    # Frames without a position leave gaps; the next one that has one is still a neighbour.
    gaps = np.diff(ground.number)[np.diff(ground.session) == 0]
    usual = float(np.median(gaps)) if len(gaps) else 1.0
    in_time = temporal_edges(ground.session, timestamp_s=ground.number, max_gap_s=_GAPS * usual)
    return Edges.joined([in_time, _across(ground, config.network.neighbours, config.seed)])


def _across(ground: Ground, neighbours: int, seed: int) -> Edges:
    """Edges between frames of one place in different sessions, some of them drawn by chance where there are many."""
    sessions = len(np.unique(ground.session))
    if sessions == 1 or neighbours == 0:
        return Edges.between(np.empty(0, np.int64), np.empty(0, np.int64))
    near = place_edges(ground.xy, ground.radius, ground.session, max_neighbours=neighbours * sessions)
    across = np.flatnonzero(ground.session[near.first] != ground.session[near.second])
    at_most = neighbours * len(ground)
    if len(across) > at_most:
        # Evenly spaced ones would meet the same pairs of sessions again and again where drives are alike.
        across = np.sort(np.random.default_rng(seed).choice(across, at_most, replace=False))
    return Edges(near.first[across], near.second[across], near.weight[across])


def learn_network(
    panoramas: Pictures,
    sessions: Sequence[MappedSession],
    front_end: FrontEnd,
    config: MapConfig,
    progress: Progress | None = None,
) -> HierarchicalModel:
    """The network of grey ``panoramas`` of all frames of ``sessions``, whose codes do not matter."""
    network, edges = config.network, network_edges(sessions, config)
    layers = layers_of(network)
    student = HierarchicalSFA(
        layers,
        wrap=crosses_seam(network, front_end),
        deviation_floor=network.deviation_floor,
        ridge=network.ridge,
    )
    student.fit(panoramas, edges=edges, progress=_one_bar(progress, len(layers)))
    return as_stored(student.model_)


def _one_bar(progress: Progress | None, layers: int) -> Progress | None:
    """Every layer goes over the pictures twice, and all but the last hand their outputs on: one stage in all."""
    if progress is None:
        return None
    passes = list[str]()

    def told(stage: str, done: int, total: int) -> None:
        if stage not in passes:
            passes.append(stage)
        progress("network", (len(passes) - 1) * total + done, (3 * layers - 1) * total)

    return told


def _encoded(
    panoramas: SpooledMaps, sessions: Sequence[MappedSession], front_end: FrontEnd, progress: Progress | None
) -> list[MappedSession]:
    """The drives with the codes that ``encode_session`` would give them."""
    start, encoded = 0, list[MappedSession]()
    for session in sessions:
        stop, parts = start + len(session), list[Codes]()
        for first in range(start, stop, STACK):
            stack = panoramas.take(np.arange(first, min(first + STACK, stop)))[:, 0]
            parts.append(Codes.of(front_end.encoder.encode(stack)))
            if progress is not None:
                progress("encode", first + len(stack), len(panoramas))
        encoded.append(replace(session, codes=Codes.joined(parts)))
        start = stop
    return encoded
