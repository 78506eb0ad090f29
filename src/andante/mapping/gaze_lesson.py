"""From drives to what any patch can be compared with: regions, gazes that follow things, slow features of patches."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.data import Edges, FloatArray, ImageArray, IndexArray
from andante.errors import LearningError, RecordingError
from andante.features import PatchEncoder, PhaseEncoder
from andante.mapping.codes import Codes
from andante.mapping.config import MapConfig
from andante.mapping.frontend import FrontEnd
from andante.mapping.gaze_config import GazeConfig
from andante.mapping.gaze_readout import GazeModel, GazeReadout
from andante.mapping.gaze_votes import Gallery, Rules
from andante.mapping.memory import MappedSession
from andante.mapping.sessions import Progress, read_session
from andante.mapping.stereo import COLUMNS, sweep
from andante.mapping.thinning import thinned_by_place
from andante.protocols import Recording
from andante.sequences.gaze import gaze_edges, region_azimuths
from andante.sfa import PCA, AffineModel, Moments, solve_slow

_CHUNK_FRAMES = 64
_PCA_PATCHES = 20_000
_LEAST_DELTA = 1e-12


@dataclass(frozen=True, slots=True, eq=False)
class GazeDrive:
    """One drive as patches are learnt from it: n frames at ``poses`` (n, 3), metres and radians.

    ``fields`` (n, width, channels) are what patches are cut from, ``distance_m`` (n, K) how far away the thing is that
    each of K regions looks at, NaN where nothing tells.
    """

    session: MappedSession
    poses: FloatArray
    fields: NDArray[np.float32]
    distance_m: FloatArray

    def __len__(self) -> int:
        return len(self.poses)

    @property
    def points_m(self) -> FloatArray:
        """(n, K, 2) what regions look at, in the frame of the map; NaN where nothing tells."""
        azimuth = region_azimuths(self.distance_m.shape[1])
        towards = np.stack([np.cos(azimuth), np.sin(azimuth)], axis=1)
        points: FloatArray = self.poses[:, None, :2] + self.distance_m[..., None] * towards
        return points

    def subset(self, chosen: IndexArray | NDArray[np.bool_]) -> GazeDrive:
        """Some of the frames."""
        return GazeDrive(self.session.subset(chosen), self.poses[chosen], self.fields[chosen], self.distance_m[chosen])


def read_drive(
    recording: Recording,
    front_end: FrontEnd,
    encoder: PatchEncoder,
    config: GazeConfig,
    *,
    progress: Progress | None = None,
) -> GazeDrive:
    """One drive whose frames have positions and headings; raises ``RecordingError`` for one that lacks them."""
    parts = list[NDArray[np.float32]]()

    def take(panoramas: ImageArray) -> None:
        parts.append(encoder.fields(panoramas))

    session = read_session(recording, front_end, config.positions, MapConfig(), take, progress=progress)
    poses = session.poses
    known: NDArray[np.bool_] = np.asarray(np.isfinite(poses).all(axis=1))
    if not known.any():
        raise RecordingError(
            f"recording {recording.name!r} has no headings; to know where a patch looks, a map of gazes needs "
            "heading_rad, or odom_heading_rad with positions='odometry'"
        )
    fields, session, poses = np.concatenate(parts)[known], session.subset(known), poses[known]
    assert front_end.phase_encoder is not None
    distance = gaze_distances(front_end.phase_encoder, session.phase.rows(), poses, config)
    return GazeDrive(session, poses, fields, distance)


def gaze_distances(
    encoder: PhaseEncoder, phase: NDArray[np.float32], poses: FloatArray, config: GazeConfig
) -> FloatArray:
    """How far away (n, K) what each region of n frames of a drive looks at is, by a plane sweep; NaN for no idea."""
    pictures = encoder.pictures(encoder.turned(phase, -poses[:, 2]), COLUMNS)
    ranges = sweep(encoder, pictures, poses[:, :2], config.place_radius_m)
    column = np.arange(config.regions) * COLUMNS // config.regions
    return np.where(ranges.weight[:, column] > 0, ranges.distance_m[:, column], np.nan)


def region_patches(drive: GazeDrive, encoder: PatchEncoder, regions: int) -> NDArray[np.float32]:
    """(n, K, dim): every region of every frame, cut at the azimuth in which the world lies and not the robot."""
    azimuth = region_azimuths(regions) - drive.poses[:, 2:]
    starts = range(0, len(drive), _CHUNK_FRAMES)
    parts = [encoder.cut(drive.fields[at : at + _CHUNK_FRAMES], azimuth[at : at + _CHUNK_FRAMES]) for at in starts]
    return np.concatenate(parts)


def learn_gaze(drives: Sequence[GazeDrive], encoder: PatchEncoder, config: GazeConfig) -> GazeModel:
    """Slow features of patches along gazes, or principal components where the configuration asks for these.

    Raises ``LearningError`` for too few patches.
    """
    patches = [region_patches(drive, encoder, config.regions).reshape(-1, encoder.dim) for drive in drives]
    count = sum(map(len, patches))
    if count <= config.principal_components:
        raise LearningError(
            f"{count} patches are too few to learn from, more than {config.principal_components} are needed; record "
            "a longer drive or lower principal_components"
        )
    step = max(1, count // _PCA_PATCHES)
    pca = PCA.of(Moments.of(np.concatenate([part[::step] for part in patches])), config.principal_components)
    if config.representation == "principal":
        model = AffineModel(pca.mean, pca.components, np.ones(pca.output_dim), pca.output_dim, pca.rank_tolerance)
        return GazeModel.of(model, np.ones(pca.output_dim))
    reduced = np.concatenate([(part - pca.mean) @ pca.components for part in patches])
    moments = Moments.of(reduced, gazes_of(drives, config))
    slow_features = min(config.slow_features, pca.output_dim)
    slow = solve_slow(moments, slow_features, ridge=config.ridge, edge_ridge=config.edge_ridge)
    noise = config.edge_ridge * float(np.trace(moments.edge_covariance)) / moments.dim
    deltas = slow.deltas + noise * (slow.weights**2).sum(axis=0)
    return GazeModel.of(slow.after(pca), 1 / np.sqrt(np.maximum(deltas, _LEAST_DELTA)))


def gazes_of(drives: Sequence[GazeDrive], config: GazeConfig) -> Edges:
    """The edges of all drives, whose patches follow each other frame by frame and region by region."""
    return gaze_edges(
        np.concatenate([drive.poses[:, :2] for drive in drives]),
        np.concatenate([drive.points_m for drive in drives]),
        np.repeat(np.arange(len(drives)), [len(drive) for drive in drives]),
        strides=config.strides,
        radius_m=config.place_radius_m,
        step_weight=config.step_weight,
    )


def gallery_of(drives: Sequence[GazeDrive], encoder: PatchEncoder, model: GazeModel, config: GazeConfig) -> Gallery:
    """Slow features of every region of at most ``max_frames`` frames, spread over places and drives."""
    session = np.repeat(np.arange(len(drives)), [len(drive) for drive in drives])
    xy = np.concatenate([drive.poses[:, :2] for drive in drives])
    kept = np.zeros(len(xy), dtype=np.bool_)
    kept[thinned_by_place(xy, session, config.max_frames)] = True
    parts = [drive.subset(kept[session == number]) for number, drive in enumerate(drives)]
    slow = [model.transform(region_patches(one, encoder, config.regions).reshape(-1, encoder.dim)) for one in parts]
    # As a file keeps them, so that a map that was loaded says the same as before.
    kept_slow = Codes.of(np.concatenate(slow)).rows()
    points = np.concatenate([drive.points_m for drive in parts])
    return Gallery(kept_slow.reshape(len(xy[kept]), config.regions, -1), xy[kept], points)


def learn_readout(drives: Sequence[GazeDrive], encoder: PatchEncoder, config: GazeConfig) -> GazeReadout:
    """All that is needed to look at patches; raises ``LearningError`` for too few of them."""
    model = learn_gaze(drives, encoder, config)
    return GazeReadout(encoder, model, gallery_of(drives, encoder, model, config), rules_of(config))


def rules_of(config: GazeConfig) -> Rules:
    """The part of a configuration that says how patches vote."""
    return Rules(config.sharpness, config.outlier_share, config.consensus_m, config.width_deg)
