"""Where a picture was taken, from the points of a reconstruction that it shows: matching, then perspective-n-point."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.baselines.structure.cloud import Cloud
from andante.baselines.structure.keypoints import Keypoints, Sift
from andante.baselines.structure.library import SEED, colmap
from andante.baselines.structure.matching import Matcher
from andante.baselines.structure.views import View, colmap_camera
from andante.data import Estimate, Hypothesis, ImageArray, Status
from andante.errors import ImageError

_FEWEST_MATCHES = 4


@dataclass(frozen=True, slots=True)
class Extractor:
    """What a picture of (height, width) ``image_shape`` is turned into before anything is known of a map."""

    view: View = field(repr=False)
    image_shape: tuple[int, int]
    sift: Sift = field(default_factory=Sift)

    def keypoints(self, image: ImageArray) -> Keypoints:
        """Grey (height, width) or BGR uint8; raises ``ImageError`` for another size than the camera's."""
        if image.shape[:2] != self.image_shape:
            height, width = self.image_shape
            raise ImageError(
                f"the reconstruction is of pictures of {width} x {height} pixels, got {image.shape[1]} x "
                f"{image.shape[0]}; give pictures of the camera that it was made with"
            )
        grey = image if image.ndim == 2 else np.asarray(cv2.cvtColor(image, cv2.COLOR_BGR2GRAY), np.uint8)
        return self.sift.keypoints(self.view, grey)


@dataclass(frozen=True, slots=True)
class PoseSearch:
    """Poses are found from points that agree within ``error_px`` and believed where ``min_inliers`` of them do."""

    error_px: float = 6.0
    min_inliers: int = 18


@dataclass(frozen=True)
class StructureLocalizer:
    """A ``StagedLocalizer`` on a cloud of points; gravity is not assumed."""

    name: str
    extractor: Extractor = field(repr=False)
    cloud: Cloud = field(repr=False)
    matcher: Matcher = field(repr=False)
    search: PoseSearch = field(default_factory=PoseSearch)

    def localize(self, image: ImageArray) -> Estimate:
        """Grey (height, width) or BGR (height, width, 3) uint8 -> estimate; raises ``ImageError`` for another size."""
        return self.locate(self.prepare(image))

    def prepare(self, image: ImageArray) -> Keypoints:
        """Key points and descriptors."""
        return self.extractor.keypoints(image)

    def locate(self, prepared: Keypoints) -> Estimate:
        """Lost with a hypothesis where too few points agree with the best pose, without one where there is no pose."""
        key, point = self.matcher.match(prepared.descriptors)
        if len(key) < _FEWEST_MATCHES:
            return Estimate(Status.LOST, f"{len(key)} of {len(prepared)} key points look like a mapped point")
        found = self._pose(prepared.xy[key], self.cloud.xyz[point])
        if found is None:
            return Estimate(Status.LOST, f"no pose agrees with the {len(key)} points that were recognised")
        inliers, world_from_camera = int(found["num_inliers"]), found["cam_from_world"].inverse()
        # Its first column is where the robot's forward points to.
        rotation = world_from_camera.rotation.matrix() @ self.extractor.view.robot_from_camera.T
        x, y = (float(value) for value in world_from_camera.translation[:2])
        heading = float(np.arctan2(rotation[1, 0], rotation[0, 0]))
        reason, best = f"{inliers} of {len(key)} recognised points agree with the pose", Hypothesis(x, y, 1.0, heading)
        if inliers < self.search.min_inliers:
            needed = f"only {reason}, {self.search.min_inliers} have to"
            return Estimate(Status.LOST, needed, hypotheses=(best,))
        return Estimate(Status.OK, reason, x, y, heading, hypotheses=(best,))

    def _pose(self, xy: NDArray[np.float32], xyz: NDArray[np.float32]) -> dict[str, Any] | None:
        """COLMAP's LO-RANSAC and refinement from pixels (k, 2) and points (k, 3)."""
        library = colmap()
        options = library.AbsolutePoseEstimationOptions()
        options.ransac.max_error, options.ransac.random_seed = self.search.error_px, SEED
        found: dict[str, Any] | None = library.estimate_and_refine_absolute_pose(
            xy.astype(np.float64), xyz.astype(np.float64), colmap_camera(self.extractor.view), options
        )
        return found
