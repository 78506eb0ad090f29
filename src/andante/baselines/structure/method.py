"""The structure-based way (thesis 8.1): a cloud of points from the mapped pictures, and the pose that sees them so."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Literal

import numpy as np

from andante.baselines.method import Learned
from andante.baselines.structure.alignment import Similarity, aligned
from andante.baselines.structure.cloud import Cloud
from andante.baselines.structure.keyframes import Keyframes, read_keyframes
from andante.baselines.structure.keypoints import Sift
from andante.baselines.structure.library import SEED, colmap
from andante.baselines.structure.localizer import Extractor, PoseSearch, StructureLocalizer
from andante.baselines.structure.matching import Matcher, MatchRule
from andante.baselines.structure.pairs import matched_pairs
from andante.baselines.structure.reconstruction import camera_poses, reconstructions
from andante.baselines.structure.views import FisheyeView, PinholeView, View, colmap_camera
from andante.data import CameraSpec, FloatArray, PoseSource
from andante.errors import LearningError, RecordingError
from andante.mapping import Progress
from andante.mapping.frontend import camera_and_size
from andante.protocols import Recording

if TYPE_CHECKING:
    import pycolmap

_EVERY_M = {"fisheye": 0.2, "pinhole": 0.05}
_ENOUGH = 0.5
"""Of the frames; where COLMAP finds the poses of fewer, known poses serve better."""


@dataclass(frozen=True)
class Structure:
    """A ``Method``: SIFT, structure from motion with COLMAP, and perspective-n-point; the intrinsics are known.

    ``view`` is the whole picture up to ``limit_deg`` off axis, or as in the thesis a pinhole view of ``pinhole_deg``
    cut from its middle. Frames lie at least ``every_m`` apart, by default 0.2 m, and 0.05 m for pinhole views, which
    share too little of the scene otherwise. With ``poses`` estimated, COLMAP finds them from the pictures alone and its
    reconstruction is laid over the positions, those within ``tolerance_m`` counting; given, points are triangulated
    from positions and headings as they are. That is also done where fewer than half of the poses are found and headings
    are known, as under clouds: they fill most of an upward picture and look as if the camera did not move. Pictures are
    matched along the drives and with the ``neighbours`` nearest ones within ``radius_m``.
    """

    view: Literal["fisheye", "pinhole"] = "fisheye"
    limit_deg: float = 89.5
    pinhole_deg: float = 90.0
    every_m: float | None = None
    poses: Literal["estimated", "given"] = "estimated"
    neighbours: int = 8
    radius_m: float = 2.0
    tolerance_m: float = 0.3
    sift: Sift = field(default_factory=Sift)
    rule: MatchRule = field(default_factory=MatchRule)
    search: PoseSearch = field(default_factory=PoseSearch)

    @property
    def name(self) -> str:
        """The name in tables."""
        return f"structure-{self.view}"

    def learn(
        self, recordings: Sequence[Recording], *, positions: PoseSource = "reference", progress: Progress | None = None
    ) -> Learned:
        """See ``Method``; ``positions`` of odometry take one drive."""
        colmap()
        start = time.perf_counter()
        extractor, keyframes = self._read(recordings, positions, progress)
        read = time.perf_counter()
        cloud, notes = self.reconstruct(extractor.view, keyframes, progress)
        localizer = StructureLocalizer(self.name, extractor, cloud, Matcher.of(cloud, self.rule), self.search)
        return Learned(localizer, read - start, time.perf_counter() - read, cloud.nbytes, notes)

    def _read(
        self, recordings: Sequence[Recording], positions: PoseSource, progress: Progress | None
    ) -> tuple[Extractor, Keyframes]:
        if not recordings:
            raise RecordingError("no recording was given; a reconstruction needs at least one drive")
        camera, image_shape = camera_and_size(recordings[0])
        extractor = Extractor(self._view_of(camera), image_shape, self.sift)
        every_m = _EVERY_M[self.view] if self.every_m is None else self.every_m
        keyframes = read_keyframes(recordings, extractor, positions=positions, every_m=every_m, progress=progress)
        if self.poses == "given" and not np.isfinite(keyframes.heading).all():
            raise RecordingError(
                f"{np.isnan(keyframes.heading).sum()} of {len(keyframes)} frames have no heading, which poses='given' "
                "needs of all of them; use poses='estimated'"
            )
        return extractor, keyframes

    def _view_of(self, camera: CameraSpec) -> View:
        """Raises ``ConfigError`` for cameras without a fisheye lens."""
        if self.view == "fisheye":
            return FisheyeView.of(camera, self.limit_deg)
        return PinholeView.of(camera, self.pinhole_deg)

    def reconstruct(
        self, view: View, keyframes: Keyframes, progress: Progress | None = None
    ) -> tuple[Cloud, tuple[str, ...]]:
        """The points in the frame of the positions and what to say of them; raises ``LearningError`` without any."""
        known = bool(np.isfinite(keyframes.heading).all())
        if self.poses == "given":
            cloud, notes, _ = self._reconstructed(view, keyframes, progress, given=True)
        else:
            start = time.perf_counter()
            cloud, notes, posed = self._reconstructed(view, keyframes, progress, given=False)
            if known and posed < _ENOUGH * len(keyframes):
                spent = time.perf_counter() - start
                cloud, more, _ = self._reconstructed(view, keyframes, progress, given=True)
                instead = "points were triangulated from the given poses instead"
                notes = (*notes, f"too few, after {spent:.0f} s that count as mapping: {instead}", *more)
        if len(cloud) == 0:
            raise LearningError(
                f"nothing could be reconstructed from {len(keyframes)} frames with "
                f"{np.mean([len(one) for one in keyframes.keypoints]):.0f} key points each"
                f"{''.join(f'; {note}' for note in notes[1:])}; use frames closer together or pictures that show more"
            )
        return cloud, notes

    def _reconstructed(
        self, view: View, keyframes: Keyframes, progress: Progress | None, *, given: bool
    ) -> tuple[Cloud, tuple[str, ...], int]:
        """The points in the frame of the positions, what to say of them, and how many frames have a pose there."""
        pairs = matched_pairs(keyframes.xy, keyframes.session, neighbours=self.neighbours, radius_m=self.radius_m)
        poses = camera_poses(view, keyframes.xy, keyframes.heading) if given else None
        models = reconstructions(keyframes.keypoints, colmap_camera(view), pairs, poses=poses, progress=progress)
        parts, notes, posed = list[Cloud](), list[str](), set[int]()
        for model in models:
            try:
                similarity = Similarity.identity() if given else self._laid_over(model, view, keyframes.xy)
            except LearningError as error:
                notes.append(f"a part of {model.num_reg_images()} frames was left out: {error}")
                continue
            parts.append(Cloud.of(model, keyframes.keypoints, similarity))
            posed |= set(model.reg_image_ids())  # models may share frames
        cloud = Cloud.joined(parts)
        found = f"{len(posed)} of {len(keyframes)} frames registered in {len(parts)} models, {len(cloud)} points"
        return cloud, (found, *notes), len(posed)

    def _laid_over(self, model: pycolmap.Reconstruction, view: View, xy: FloatArray) -> Similarity:
        numbers = sorted(model.reg_image_ids())
        poses = [model.image(number).cam_from_world().inverse() for number in numbers]
        # The robot's upward axis as the camera has it is the last row of that rotation.
        up = np.stack([pose.rotation.matrix() @ view.robot_from_camera[2] for pose in poses])
        centres = np.stack([pose.translation for pose in poses])
        known = xy[np.array(numbers) - 1]
        return aligned(centres, up, known, tolerance_m=self.tolerance_m, rng=np.random.default_rng(SEED))
