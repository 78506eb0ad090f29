"""A map that lives: another drive is learnt into it, or refused where it would do harm; two maps become one.

Learning goes back to the remembered frames of all sessions, so a map that was updated is the very map that all its
recordings would have given at once, in the order in which they came. A network that makes the features is the one thing
that stays as it was first learnt: with it given, the same holds.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.spatial import KDTree
from scipy.spatial.distance import cdist

from andante.data import FloatArray
from andante.errors import LearningError, MapError, RecordingError, SessionRefusedError
from andante.features import PhaseEncoder
from andante.mapping.builder import learn_map
from andante.mapping.codes import Codes
from andante.mapping.config import MapConfig
from andante.mapping.folds import Folds, Mask
from andante.mapping.frontend import Encoded
from andante.mapping.lessons import lessons_of, locate_held_out
from andante.mapping.memory import MappedSession
from andante.mapping.network import same_network
from andante.mapping.odometry import in_one_frame
from andante.mapping.selection import recipe_of
from andante.mapping.sessions import BuildLog, Progress, encode_session, positions_in, require_distinct
from andante.mapping.slow_map import SlowMap, Unit
from andante.protocols import Recording
from andante.sfa import one_thread

_FEWEST_FRAMES, _FEWEST_PLACES = 10, 5
_LEAST_AGREEING = 0.5
_MOST_CONTRADICTING = 0.08
_FARTHEST_OFF_RADII = 0.75
_NEAR_RADII, _FAR_RADII, _CAP_RADII = 2.0, 4.0, 10.0
_WORSE_BY, _WORSE_RADII = 1.1, 0.02
_FOLDS = 5


@dataclass(frozen=True, slots=True)
class Trial:
    """What speaks for a session that is to be added, in metres or places.

    ``overlap`` of its ``frames`` claim to be at most a place ``radius`` from a mapped one: ``agreeing`` is the share of
    these that the map, as it was, finds near the claimed position (by ``chance`` it would be that many), ``off`` the
    median distance from it of those that claim to be nearest to mapped places. ``contradicting`` is the share of all
    frames that the map finds elsewhere without doubt. ``before`` and ``after`` are the mean errors of the map's own
    sessions, held out and located without and with the new one, each capped at ten radii; ``None`` where the map has
    fewer than two.
    """

    name: str
    frames: int
    overlap: int
    agreeing: float
    chance: float
    contradicting: float
    off: float
    before: float | None
    after: float | None
    radius: float
    unit: Unit

    @property
    def objection(self) -> str | None:
        """Why the session should not be added, ``None`` where nothing speaks against it."""
        if self.overlap < _FEWEST_FRAMES:
            return (
                f"{self.overlap} of its {self.frames} images were taken near mapped places, at least {_FEWEST_FRAMES} "
                "are needed to see that it fits"
            )
        if self.agreeing < _LEAST_AGREEING:
            return (
                f"of {self.overlap} images near mapped places the map finds {self.agreeing:.0%} where they claim to be "
                f"({self.chance:.0%} by chance): wrong poses, another place, or a condition unlike all that is mapped"
            )
        if self.contradicting > _MOST_CONTRADICTING:
            return (
                f"the map knows {self.contradicting:.0%} of its images from other places than they claim: wrong poses"
            )
        if self.off > _FARTHEST_OFF_RADII * self.radius:
            return (
                f"its poses are off by {self.off:.2f} {self.unit} in the median: another frame of reference, another "
                "clock, or drift"
            )
        if self.before is not None and self.after is not None:
            worst = _WORSE_BY * self.before + _WORSE_RADII * self.radius
            if self.after > worst:
                return (
                    f"with it the images of the mapped drives are located worse, held out by {self.after:.3f} "
                    f"{self.unit} in the mean instead of {self.before:.3f}"
                )
        return None

    def as_dict(self) -> dict[str, Any]:
        """Plain values for JSON."""
        return asdict(self) | {"objection": self.objection}


def update_map(
    slowmap: SlowMap,
    recording: Recording,
    *,
    force: bool = False,
    progress: Progress | None = None,
    log: BuildLog | None = None,
) -> tuple[SlowMap, Trial]:
    """Learn another recording into a map, as if it had been there from the beginning.

    Raises ``SessionRefusedError`` for one that would make the map worse (wrong poses, another garden, a robot that did
    not drive), unless ``force`` is set; ``RecordingError`` for one that is in the map already; ``MapError`` for a map
    without memory.
    """
    log = log or BuildLog()
    memory, positions = _memory_of(slowmap), slowmap.sources[0].poses
    if positions not in positions_in(recording):
        raise RecordingError(
            f"recording {recording.name!r} has no {positions} positions, from which the map was made; "
            + (
                "a drive that knows only odometry fits a map of odometry alone"
                if positions == "reference"
                else "add them"
            )
        )
    session = encode_session(recording, slowmap.front_end, positions, slowmap.config, progress=progress, log=log)
    _require_drive(slowmap, session)
    if positions == "odometry":
        (session,), closings = in_one_frame(memory, [(session, recording)], slowmap.config.drift)
        log.closings += closings
    with log.timed("learn"):
        trial = _tried(slowmap, memory, session, force=force)
    sessions = [*memory, session]
    learnt = learn_map(sessions, slowmap.front_end, slowmap.asked, name=slowmap.name, progress=progress, log=log)
    return replace(learnt, landmarks=slowmap.landmarks), trial


def merge_maps(
    first: SlowMap, second: SlowMap, *, force: bool = False, progress: Progress | None = None
) -> tuple[SlowMap, tuple[Trial, ...]]:
    """One map from two of the same place and frame of reference; sessions that are in both count once.

    The camera and the configuration are those of ``first``. Raises ``MapError`` for maps that do not fit each other or
    have no memory, ``SessionRefusedError`` where a session of ``second`` does not fit, unless ``force`` is set.
    """
    memory, others = _memory_of(first), _memory_of(second)
    _require_alike(first, second)
    known = {session.source.content_hash for session in memory}
    new = [session for session in others if session.source.content_hash not in known]
    for session in new:
        _require_drive(first, session)
    trials = tuple(_tried(first, memory, session, force=force) for session in new)
    merged = learn_map([*memory, *new], first.front_end, first.asked, name=first.name, progress=progress)
    return replace(merged, landmarks=first.landmarks), trials


def _memory_of(slowmap: SlowMap) -> tuple[MappedSession, ...]:
    if slowmap.memory is None:
        raise MapError(
            "this map does not remember its frames, so nothing can be learnt into it; make it again without "
            "--localize-only (memory.keep = true)"
        )
    return slowmap.memory


def _require_drive(slowmap: SlowMap, session: MappedSession) -> None:
    """Refuse what is in the map already, and a robot that did not drive."""
    if slowmap.learnt_from(session.source.content_hash):
        raise RecordingError(f"recording {session.source.name!r} is in the map already; leave it out")
    places = len(np.unique(np.floor(session.xy / _radius_of(slowmap)), axis=0))
    if len(session) < _FEWEST_FRAMES or places < _FEWEST_PLACES:
        raise SessionRefusedError(
            f"recording {session.source.name!r} has {len(session)} images of {places} places, at least "
            f"{_FEWEST_FRAMES} of {_FEWEST_PLACES} are needed: did the robot stand in its dock? The map stays as it was"
        )


def _require_alike(first: SlowMap, second: SlowMap) -> None:
    differences = [
        name
        for name, one, other in (
            ("positions", first.config.positions, second.config.positions),
            ("panorama", first.config.panorama, second.config.panorama),
            ("features", first.config.features, second.config.features),
            ("camera model", first.front_end.camera.model, second.front_end.camera.model),
            ("panorama size", first.front_end.panorama_shape, second.front_end.panorama_shape),
        )
        if one != other
    ]
    if differences:
        raise MapError(f"these maps cannot be merged, they differ in {', '.join(differences)}; make one as the other")
    if not same_network(first.front_end.network, second.front_end.network):
        raise MapError(
            "these maps cannot be merged, each has learnt a network of its own from its first recordings; update one "
            "of them with the recordings of the other"
        )
    if first.config.positions == "odometry":
        raise MapError(
            "maps made from odometry each have a frame of reference of their own and cannot be merged; update one of "
            "them with the recordings of the other"
        )


def _tried(slowmap: SlowMap, memory: Sequence[MappedSession], session: MappedSession, *, force: bool) -> Trial:
    """Try a session; raises ``SessionRefusedError`` where it should not be added."""
    require_distinct([*memory, session])
    with one_thread():
        trial = _trial_of(slowmap, memory, session)
    if trial.objection is not None and not force:
        raise SessionRefusedError(
            f"recording {session.source.name!r} would make the map worse: {trial.objection}. The map stays as it was; "
            "--force adds it nevertheless"
        )
    return trial


def _trial_of(slowmap: SlowMap, memory: Sequence[MappedSession], session: MappedSession) -> Trial:
    config, radius = slowmap.config, _radius_of(slowmap)
    mapped = KDTree(np.concatenate([one.xy for one in memory]))
    beside = np.asarray(mapped.query(session.xy)[0])
    overlap = beside <= radius
    found, sure = _located(slowmap, session)
    apart = np.linalg.norm(found - session.xy, axis=1)
    near = apart[overlap]
    # On new ways an image is found at the mapped place beside it: the closer that is, the more it tells.
    closest = apart[beside <= max(radius / 2, np.partition(beside, _FEWEST_FRAMES - 1)[_FEWEST_FRAMES - 1])]
    before, after = _harm(config, slowmap.front_end.phase_encoder, memory, session, radius)
    return Trial(
        name=session.source.name,
        frames=len(session),
        overlap=len(near),
        agreeing=_share(near <= _NEAR_RADII * radius),
        chance=_share(cdist(found[overlap], session.xy[overlap]) <= _NEAR_RADII * radius),
        contradicting=_share(sure & (apart > _FAR_RADII * radius)),
        off=float(np.median(closest)),
        before=before,
        after=after,
        radius=radius,
        unit=slowmap.unit,
    )


def _radius_of(slowmap: SlowMap) -> float:
    radius = slowmap.config.learning.place_radius_m
    assert radius is not None  # a map resolves it
    return radius


def _share(true: NDArray[np.bool_]) -> float:
    return float(true.mean()) if true.size else 0.0


def _located(slowmap: SlowMap, session: MappedSession) -> tuple[FloatArray, NDArray[np.bool_]]:
    """Positions (n, 2) of remembered frames, and whether (n,) the map has no doubt about them."""
    xy, sure, bounds = [np.empty((0, 2))], [np.empty(0, dtype=np.bool_)], slowmap.calibration
    for covered, rows in session.codes.chunks():
        sighting = slowmap.sight(Encoded(rows, session.phase.rows(covered)))
        xy.append(sighting.located.xy)
        agreeing = sighting.located.agreement >= max(bounds.lost_below, 0.5)
        sure.append(agreeing & (sighting.likeness >= bounds.degraded_below))
    return np.concatenate(xy), np.concatenate(sure)


def _harm(
    config: MapConfig,
    phase_encoder: PhaseEncoder | None,
    memory: Sequence[MappedSession],
    session: MappedSession,
    radius: float,
) -> tuple[float | None, float | None]:
    """Mean capped errors of the mapped frames, held out, without and with a new session; the same frames in both.

    Blocks of a single session would be found by the new one better than by the rest, whatever its poses.
    """
    if len(memory) < 2:
        return None, None
    sessions = [*memory, session]
    features = Codes.joined([one.codes for one in sessions])
    lessons = lessons_of(sessions, features, config, phase_encoder)
    n = sum(len(one) for one in memory)
    mapped = np.arange(len(lessons.x)) < n
    calibration = config.calibration.model_copy(update={"folds": _FOLDS})
    names = [one.source.name for one in memory]
    recipe = recipe_of(config.learning)

    def errors(train: Mask, test: Mask) -> FloatArray:
        located = locate_held_out(lessons, recipe, config, train, test).located
        capped: FloatArray = np.minimum(
            np.linalg.norm(located.xy - lessons.ground.xy[test], axis=1), _CAP_RADII * radius
        )
        return capped

    before, after = list[FloatArray](), list[FloatArray]()
    for _, held_out in Folds.of(lessons.ground.subset(mapped), names, calibration):
        test = np.concatenate([held_out, np.zeros(len(session), dtype=np.bool_)])
        if not held_out.any():
            continue
        try:
            pair = errors(mapped & ~test, test), errors(~test, test)
        except LearningError:
            continue  # too little is left to learn from without this part
        before.append(pair[0])
        after.append(pair[1])
    if not before:
        return None, None
    return float(np.concatenate(before).mean()), float(np.concatenate(after).mean())
