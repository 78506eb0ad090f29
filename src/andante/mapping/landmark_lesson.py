"""Learning landmarks: cut out of recordings, learnt one by one, tried together on frames that were held out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from andante.angles import wrapped
from andante.data import FloatArray, Frame, ImageArray, IndexArray, Trajectory
from andante.errors import LearningError
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.views import ViewCutter, ViewWindow
from andante.mapping.landmark_config import LandmarkConfig
from andante.mapping.landmark_fusion import correlation_of
from andante.mapping.landmark_model import LEAST_VIEWS, LandmarkModel, Views, learn_landmark
from andante.mapping.landmark_sights import Fused, Sight, fused, sights_in
from andante.mapping.learning import Ground, typical_radius
from andante.mapping.uncertainty import conformal_factor
from andante.protocols import Recording

Spotter = Callable[[Frame], Sequence[Detection]]
"""Landmarks in a frame; of one name the best counts."""

_LEAST_RADIUS_M = 0.35
_MEDIAN_OF_CHI2 = 1.386  # of two degrees of freedom
_ANOTHER_DRIVE = 1.8
"""How much larger errors are on another drive than between the frames of one, as measured for whole images."""
_PARTS = 3
_PIECE_M = 0.5


@dataclass(frozen=True, slots=True, eq=False)
class Album:
    """Views of all landmarks in n frames, of which ``poses`` (n, 3) and ``session`` (n,) are known."""

    views: tuple[Views, ...]
    poses: FloatArray
    session: IndexArray

    def __len__(self) -> int:
        return len(self.poses)

    def only(self, names: Sequence[str]) -> Album:
        """The same frames with some of the landmarks."""
        return replace(self, views=tuple(one for one in self.views if one.name in names))


@dataclass(frozen=True, slots=True)
class LandmarkCalibration:
    """What held-out frames allow to promise.

    ``correlation`` is that of the errors of two landmarks in one image. ``radius_factor`` times the expected error of a
    fused position holds the truth for the configured share of held-out frames, ``heading_factor`` likewise; ``None``
    where none is known. ``usual_radius_m`` is the median radius. ``sessions`` says whether whole sessions were held
    out.
    """

    correlation: float
    radius_factor: float
    heading_factor: float | None
    usual_radius_m: float
    sessions: bool


@dataclass(frozen=True, slots=True, eq=False)
class Learnt:
    """Landmarks with their calibration, and for every frame (n,) the radius to expect there, infinite without any."""

    models: tuple[LandmarkModel, ...]
    calibration: LandmarkCalibration
    expected_m: FloatArray


def collect(drives: Sequence[tuple[Recording, ViewCutter, Spotter]], window: ViewWindow) -> Album:
    """Cut all landmarks out of the frames with reference positions of some recordings.

    Raises ``LearningError`` where no landmark is seen at all, as ``Recording.frames`` does for pictures that cannot be
    read.
    """
    pictures, boxes, frames = dict[str, list[ImageArray]](), dict[str, list[Box]](), dict[str, list[int]]()
    poses, session = list[FloatArray](), list[int]()
    for number, (recording, cutter, spot) in enumerate(drives):
        known = Trajectory.of(recording.infos, "reference")
        for frame in recording.frames(np.flatnonzero(known.known).tolist()):
            for name, box in best_by_name(spot(frame)).items():
                pictures.setdefault(name, []).append(cutter(frame.image, box, window))
                boxes.setdefault(name, []).append(box)
                frames.setdefault(name, []).append(len(poses))
            row = frame.info.index
            poses.append(np.array([*known.xy_m[row], known.heading_rad[row]]))
            session.append(number)
    if not pictures:
        raise LearningError("no landmark is seen in any frame with a position; teach one first, or record one nearby")
    views = tuple(
        Views(name, window, np.stack(pictures[name]), tuple(boxes[name]), np.array(frames[name], np.int64))
        for name in sorted(pictures)
    )
    return Album(views, np.array(poses), np.array(session, np.int64))


def best_by_name(detections: Sequence[Detection]) -> dict[str, Box]:
    """The box with the highest score of every name, names in order."""
    best = {one.name: one.box for one in sorted(detections, key=lambda one: one.score)}
    return dict(sorted(best.items()))


def learn_album(album: Album, config: LandmarkConfig) -> Learnt:
    """Landmarks that are seen often enough, calibrated on parts of the album that are held out in turn.

    Parts are sessions or, where there is one session alone, every third half metre of it. Landmarks of which nothing
    can be held out are left out: nobody could say how far to believe them. Raises ``LearningError`` where none is left,
    and where no view that was held out looks like one that was not.
    """
    part = _parts(album, config)
    enough = [one.name for one in album.views if _can_be_tried(one, part)]
    if not enough:
        raise LearningError(_too_seldom(album))
    album = album.only(enough)
    everything = np.ones(len(album), np.bool_)
    models = tuple(_learnt(album, everything, config))
    tries = [_tried(album, part == number, config, enough) for number in np.unique(part)]
    held: list[list[Sight | None]] = [[None] * len(enough) for _ in range(len(album))]
    for tried in tries:
        for frame, column, sight in tried:
            held[frame][column] = sight
    sessions = len(np.unique(album.session)) > 1
    models = _calibrated(models, held, album, 1.0 if sessions else _ANOTHER_DRIVE)
    scaled = [
        [_rescaled(sight, models[column]) for column, sight in enumerate(row) if sight and sight.familiar]
        for row in held
    ]
    correlation = correlation_of(_white(held, models, album))
    if not any(scaled):
        raise LearningError(
            "no landmark looks the same in frames that were held out, so nobody could say how far to believe them; "
            "look at their boxes, or record slower drives past them"
        )
    answers = [fused(row, config.fusion, correlation) if row else None for row in scaled]
    calibration, expected = _promised(answers, album, config, correlation, sessions)
    return Learnt(models, calibration, expected)


def sights_of(models: Sequence[LandmarkModel], album: Album, frames: NDArray[np.bool_]) -> list[tuple[int, int, Sight]]:
    """All landmarks of the album in some of its frames (n,): frame, number of the landmark, what it says."""
    found = list[tuple[int, int, Sight]]()
    for column, (model, views) in enumerate(zip(models, album.views, strict=True)):
        part = views.subset(frames[views.frame])
        if not len(part.frame):
            continue
        located = model.locate(part.pictures)
        found += [
            (int(frame), column, sight)
            for frame, sight in zip(part.frame, sights_in(model, part.boxes, located), strict=True)
        ]
    return found


def _learnt(album: Album, frames: NDArray[np.bool_], config: LandmarkConfig) -> list[LandmarkModel]:
    """Every landmark from some of the frames."""
    radius = typical_radius(album.poses[:, :2], album.session, _LEAST_RADIUS_M)
    models = []
    for views in album.views:
        part = views.subset(frames[views.frame])
        ground = Ground(album.poses[part.frame, :2], album.session[part.frame], part.frame, radius)
        models.append(learn_landmark(part, ground, album.poses[part.frame], config))
    return models


def _parts(album: Album, config: LandmarkConfig) -> IndexArray:
    """(n,) which frames are held out together."""
    if len(np.unique(album.session)) > 1:
        return np.asarray(album.session % config.folds, np.int64)
    # Frames a few centimetres apart are no test of each other.
    way = np.cumsum(np.linalg.norm(np.diff(album.poses[:, :2], axis=0, prepend=album.poses[:1, :2]), axis=1))
    pieces = np.unique(way // _PIECE_M, return_inverse=True)[1]
    return np.asarray(pieces % _PARTS, np.int64)


def _can_be_tried(views: Views, part: IndexArray) -> bool:
    """Whether enough views remain to learn from where some are held out; ``part`` (n,) of all frames."""
    own = part[views.frame]
    return any(LEAST_VIEWS <= int((own != one).sum()) < len(own) for one in np.unique(part))


def _too_seldom(album: Album) -> str:
    """Why no landmark can be learnt."""
    often = max(album.views, key=lambda one: len(one.frame))
    seen = f"the most frequent, {often.name!r}, in {len(often.frame)}"
    if len(often.frame) < LEAST_VIEWS:
        return f"no landmark is seen in {LEAST_VIEWS} frames or more, {seen}; record a longer drive past it"
    if len(np.unique(album.session)) > 1:
        return (
            f"no landmark is seen in {LEAST_VIEWS} frames or more of the other drives when it is tried on one of them, "
            f"{seen}; record another drive past it"
        )
    return (
        f"no landmark is seen often enough to hold a third of its frames out and learn from {LEAST_VIEWS} others, "
        f"{seen}; record a longer drive past it"
    )


def _tried(
    album: Album, held: NDArray[np.bool_], config: LandmarkConfig, names: Sequence[str]
) -> list[tuple[int, int, Sight]]:
    """What landmarks that are learnt from the other frames say of those held out."""
    rest = [one.name for one in album.views if (~held[one.frame]).sum() >= LEAST_VIEWS]
    part = album.only(rest)
    if not rest:
        return []
    column = [names.index(name) for name in rest]
    return [(frame, column[one], sight) for frame, one, sight in sights_of(_learnt(part, ~held, config), part, held)]


def _calibrated(
    models: Sequence[LandmarkModel], held: Sequence[Sequence[Sight | None]], album: Album, unseen: float
) -> tuple[LandmarkModel, ...]:
    """Covariances as large as errors on held-out frames were, by their median: what is taken for elsewhere is rare.

    Under a light of which nothing was held out, errors are ``unseen`` times larger; that is so for what views say and
    not for where boxes are, which then count for more.
    """
    done = []
    for column, model in enumerate(models):
        rows = [(frame, sight) for frame, row in enumerate(held) if (sight := row[column]) is not None]
        off = np.array([sight.xy - album.poses[frame, :2] for frame, sight in rows])
        information = np.linalg.inv(np.array([sight.covariance for _, sight in rows]))
        squared = np.einsum("ni,nij,nj->n", off, information, off)
        error = float(np.median(np.linalg.norm(off, axis=1)))
        scale = max(unseen**2 * float(np.median(squared)) / _MEDIAN_OF_CHI2, 1e-6)
        done.append(replace(model, scale=scale, error_m=max(error, 1e-6)))
    return tuple(done)


def _rescaled(sight: Sight, model: LandmarkModel) -> Sight:
    """What a landmark from a trial said, as sure as all trials together let it be.

    Where it stands stays what the trial learnt: the frames that were held out must not have a say in it.
    """
    tried = replace(sight.model, scale=model.scale, error_m=model.error_m)
    return replace(sight, model=tried, covariance=sight.covariance * model.scale)


def _white(held: Sequence[Sequence[Sight | None]], models: Sequence[LandmarkModel], album: Album) -> FloatArray:
    """Errors (n, m, 2) in units of their deviations, along the axes of the map, as ``correlation_of`` compares them."""
    white = np.full((len(album), len(models), 2), np.nan)
    for frame, row in enumerate(held):
        for column, sight in enumerate(row):
            if sight is not None:
                variances, axes = np.linalg.eigh(sight.covariance * models[column].scale)
                off = axes.T @ (sight.xy - album.poses[frame, :2])
                white[frame, column] = axes @ (off / np.sqrt(variances))
    return white


def _promised(
    answers: Sequence[Fused | None], album: Album, config: LandmarkConfig, correlation: float, sessions: bool
) -> tuple[LandmarkCalibration, FloatArray]:
    """Factors from errors of fused positions, and the radius (n,) to expect at every frame."""
    seen = np.array([one is not None for one in answers])
    found = [one for one in answers if one is not None]
    unseen = 1.0 if sessions else _ANOTHER_DRIVE
    expected = np.full(len(album), np.inf)
    pose, truth = np.array([one.pose for one in found]), album.poses[seen]
    sigma = np.array([one.sigma_m for one in found])
    factor = unseen * conformal_factor(np.linalg.norm(pose[:, :2] - truth[:, :2], axis=1), sigma, config.coverage)
    turn = np.abs(wrapped(pose[:, 2] - truth[:, 2])) / np.array([one.sigma_rad for one in found])
    turn = turn[np.isfinite(turn)]
    heading = unseen * conformal_factor(turn, np.ones(len(turn)), config.coverage) if len(turn) else None
    expected[seen] = factor * sigma
    return LandmarkCalibration(correlation, factor, heading, float(np.median(expected[seen])), sessions), expected
