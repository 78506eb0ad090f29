"""Landmarks as a part of a map: from the boxes in one image to an estimate, and where another landmark would help."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import pairwise
from typing import Any, Protocol, Self, runtime_checkable

import numpy as np
from numpy.typing import NDArray

from andante.camera import scaled
from andante.data import CameraSpec, Estimate, FloatArray, Hypothesis, ImageArray, Status
from andante.errors import ArrayError, ImageError
from andante.landmarks.boxes import Box, Detection
from andante.landmarks.views import ViewCutter
from andante.mapping.landmark_config import LandmarkConfig
from andante.mapping.landmark_lesson import Album, LandmarkCalibration, best_by_name, learn_album
from andante.mapping.landmark_model import LandmarkModel
from andante.mapping.landmark_sights import Fused, Sight, fused, sights_in, trusted
from andante.mapping.uncertainty import covariance_of
from andante.mapping.weak_places import WeakPlace, weak_places
from andante.sfa.arrays import require_names

_BOX = 4
_DOUBTFUL = 3.0
"""Times the usual radius from which on a pose is degraded."""
_LEAST_AGREEMENT = 0.5


class LandmarkDetector(Protocol):
    """Finds landmarks in an image."""

    def detect(self, image: ImageArray, camera: CameraSpec) -> Sequence[Detection]:
        """Grey (height, width) or BGR (height, width, 3) uint8 of a camera -> what is seen."""
        ...


@runtime_checkable
class FiledDetector(LandmarkDetector, Protocol):
    """One that is a file, which a map can carry."""

    @property
    def data(self) -> bytes:
        """All of the file."""
        ...


@dataclass(frozen=True, eq=False)
class LandmarkMap:
    """All landmarks of a map, what may be promised of them, and what to expect where the mapped drives were.

    ``places`` (n, 3) are x, y and the expected radius of the mapped frames, infinite where no landmark was seen.
    ``detector`` is the file of what finds them, ``None`` for one that has no file.
    """

    models: tuple[LandmarkModel, ...]
    calibration: LandmarkCalibration
    config: LandmarkConfig
    places: FloatArray = field(repr=False)
    detector: bytes | None = field(default=None, repr=False)

    @classmethod
    def learn(cls, album: Album, config: LandmarkConfig | None = None) -> Self:
        """From the views of landmarks in some drives; raises ``LearningError`` where none is seen often enough."""
        config = config or LandmarkConfig()
        learnt = learn_album(album, config)
        places = np.column_stack([album.poses[:, :2], learnt.expected_m])
        return cls(learnt.models, learnt.calibration, config, places)

    @property
    def names(self) -> tuple[str, ...]:
        """Of all landmarks, in order."""
        return tuple(model.name for model in self.models)

    @property
    def signature_dim(self) -> int:
        """Length of a signature."""
        return int(self._bounds[-1])

    def signature(self, image: ImageArray, detections: Sequence[Detection], cutter: ViewCutter) -> NDArray[np.float32]:
        """(signature_dim,) all that a map wants of the landmarks in an image: boxes and slow features, NaN for unseen.

        Of several boxes of one name the best counts; names that are not mapped are passed over.
        """
        row = np.full(self.signature_dim, np.nan, np.float32)
        boxes = best_by_name(detections)
        for model, (start, stop) in zip(self.models, pairwise(self._bounds), strict=True):
            box = boxes.get(model.name)
            if box is not None:
                row[start : start + _BOX] = box.azimuth_rad, box.elevation_rad, box.width_rad, box.height_rad
                row[start + _BOX : stop] = model.slow_features(cutter(image, box, model.window)[None])[0]
        return row

    def sights(self, signature: NDArray[np.float32]) -> list[Sight]:
        """What each landmark that is seen says of the position; raises ``ArrayError`` for another length."""
        if signature.shape != (self.signature_dim,):
            raise ArrayError(
                f"a signature of these landmarks has {self.signature_dim} numbers, got {signature.shape}; "
                "make it with the same map"
            )
        found = []
        for model, (start, stop) in zip(self.models, pairwise(self._bounds), strict=True):
            values = signature[start:stop].astype(np.float64)
            if np.isfinite(values).all():
                located = model.located(values[None, _BOX:])
                box = Box(*values[:_BOX].tolist())
                found += sights_in(model, [box], located)
        return found

    def estimate(self, signature: NDArray[np.float32]) -> Estimate:
        """Where the robot is, by the landmarks alone; lost where none is seen. The reason names those that were."""
        return self.estimate_of(self.sights(signature))

    def estimate_of(self, sights: Sequence[Sight]) -> Estimate:
        """The same from what is seen already; views that are like no mapped one are left out, or the robot is lost."""
        if not sights:
            return Estimate(Status.LOST, f"no landmark of this map is seen, of {', '.join(self.names)}")
        sights = trusted(sights)
        answer = fused(sights, self.config.fusion, self.calibration.correlation)
        radius = self.calibration.radius_factor * answer.sigma_m
        if not np.isfinite([*answer.pose[:2], radius]).all():
            return Estimate(Status.LOST, "the landmarks lead to numbers that are not finite; is the map damaged?")
        hypotheses = _hypotheses(answer, sights, None if np.isnan(answer.pose[2]) else float(answer.pose[2]))
        if not sights[0].familiar:
            strange = ", ".join(f"{one.model.name} ({one.likeness:.2f})" for one in sights)
            reason = f"what is seen looks like no mapped view of it, by likeness: {strange}"
            return Estimate(Status.LOST, reason, hypotheses=hypotheses)
        factor = self.calibration.heading_factor
        off = np.nan if factor is None else factor * answer.sigma_rad
        x, y, heading = answer.pose.tolist()
        status, doubt = self._judged(sights, radius)
        return Estimate(
            status,
            f"from {_listed(sights)}{doubt}",
            x,
            y,
            heading if np.isfinite(off) else None,
            covariance_of(answer.covariance[:2, :2], radius, off),
            radius,
            hypotheses=hypotheses,
        )

    def weak_places(self, radius_m: float | None = None, cell_m: float = 2.0) -> list[WeakPlace]:
        """Where landmarks say less than ``radius_m`` wants to know, the worst first: ask a human for one there (7.3.3).

        Where no radius is asked for it is the one from which on a pose is degraded. The mapped frames are joined in
        cells of ``cell_m``, of which each has its median radius; raises ``ArrayError`` for a size that is not above
        zero.
        """
        radius_m = _DOUBTFUL * self.calibration.usual_radius_m if radius_m is None else radius_m
        return weak_places(self.places, radius_m, cell_m)

    def with_detector(self, detector: LandmarkDetector) -> LandmarkMap:
        """The same landmarks, and in their file the file of what finds them, if it has one."""
        return replace(self, detector=detector.data if isinstance(detector, FiledDetector) else None)

    def describe(self) -> list[dict[str, Any]]:
        """Every landmark as plain values: its name, its usual error, and where it stands, ``None`` where unknown."""
        return [
            {
                "name": one.name,
                "error_m": one.error_m,
                "x_m": None if one.geometry is None else one.geometry.x_m,
                "y_m": None if one.geometry is None else one.geometry.y_m,
            }
            for one in self.models
        ]

    def to_arrays(self) -> dict[str, NDArray[Any]]:
        """Arrays by name, for a file; names of landmarks, calibration and configuration are kept elsewhere."""
        arrays: dict[str, NDArray[Any]] = {"places": np.nan_to_num(self.places, posinf=-1.0)}
        for number, model in enumerate(self.models):
            arrays |= {f"{number}.{name}": array for name, array in model.to_arrays().items()}
        if self.detector is not None:
            arrays["detector"] = np.frombuffer(self.detector, np.uint8)
        return arrays

    @classmethod
    def from_arrays(
        cls,
        arrays: Mapping[str, NDArray[Any]],
        names: Sequence[str],
        calibration: LandmarkCalibration,
        config: LandmarkConfig,
    ) -> Self:
        """The inverse of ``to_arrays``; raises ``ArrayError`` for arrays that do not belong together."""
        require_names(arrays, ("places",), "the landmarks of a map")
        places = np.array(arrays["places"], np.float64)
        if places.ndim != 2 or places.shape[1] != 3:
            raise ArrayError(f"the places of landmarks have shape (n, 3), got {places.shape}")
        places[places[:, 2] < 0, 2] = np.inf
        models = []
        for number, name in enumerate(names):
            start = f"{number}."
            own = {key.removeprefix(start): array for key, array in arrays.items() if key.startswith(start)}
            models.append(LandmarkModel.from_arrays(name, own))
        detector = arrays["detector"].tobytes() if "detector" in arrays else None
        return cls(tuple(models), calibration, config, places, detector)

    @property
    def _bounds(self) -> NDArray[np.int64]:
        """Where in a signature each landmark begins, and the end."""
        return np.cumsum([0, *(_BOX + model.model.output_dim for model in self.models)])

    def _judged(self, sights: Sequence[Sight], radius: float) -> tuple[Status, str]:
        """How far to believe it, and what to say of a doubt."""
        if radius > _DOUBTFUL * self.calibration.usual_radius_m:
            return Status.DEGRADED, f"; {radius:.2g} m where {self.calibration.usual_radius_m:.2g} m is usual"
        if len(sights) == 1 and sights[0].agreement < _LEAST_AGREEMENT:
            return Status.DEGRADED, f"; several places look like this, {sights[0].agreement:.0%} of the evidence agrees"
        return Status.OK, ""


class LandmarkEye:
    """Sees the landmarks of a map in images of one camera; safe to call from many threads if the detector is.

    ``image_shape`` (height, width) is the size that ``camera`` speaks of; images of another size but the same
    proportions are understood as well. It is a ``Localizer`` that goes by landmarks alone. Raises ``ConfigError`` for a
    camera that is no fisheye.
    """

    name = "landmarks"

    def __init__(
        self, landmarks: LandmarkMap, detector: LandmarkDetector, camera: CameraSpec, image_shape: tuple[int, int]
    ) -> None:
        self.landmarks, self.detector, self.camera, self.image_shape = landmarks, detector, camera, image_shape
        self._cutters = {image_shape: (camera, ViewCutter(camera, image_shape))}

    @property
    def dim(self) -> int:
        """Length of a signature."""
        return self.landmarks.signature_dim

    def for_camera(self, camera: CameraSpec, image_shape: tuple[int, int]) -> LandmarkEye:
        """The same for another camera."""
        return LandmarkEye(self.landmarks, self.detector, camera, image_shape)

    def signature(self, image: ImageArray) -> NDArray[np.float32]:
        """(dim,) of an image, grey (height, width) or BGR (height, width, 3) uint8.

        Raises ``ImageError`` for one of other proportions than the camera's.
        """
        shape = image.shape[0], image.shape[1]
        if shape not in self._cutters:
            # Two threads may both make it; either is as good, and storing it is atomic.
            scale = shape[1] / self.image_shape[1]
            if abs(shape[0] - scale * self.image_shape[0]) > 1.0:
                raise ImageError(
                    f"an image of {shape[1]}x{shape[0]} px does not fit the camera, whose images are "
                    f"{self.image_shape[1]}x{self.image_shape[0]} px or of the same proportions"
                )
            self._cutters[shape] = scaled(self.camera, scale), ViewCutter(self.camera, shape, scale=scale)
        camera, cutter = self._cutters[shape]
        return self.landmarks.signature(image, self.detector.detect(image, camera), cutter)

    def localize(self, image: ImageArray) -> Estimate:
        """One image -> estimate, by its landmarks alone."""
        return self.landmarks.estimate(self.signature(image))


def _listed(sights: Sequence[Sight]) -> str:
    return ", ".join(f"{one.model.name} ({one.radius_m:.2g} m)" for one in sights)


def _hypotheses(answer: Fused, sights: Sequence[Sight], heading: float | None) -> tuple[Hypothesis, ...]:
    """The estimate itself with half of the weight, then what each landmark says alone, by its precision."""
    x, y = answer.pose[:2].tolist()
    precision = np.array([1.0 / np.trace(one.covariance) for one in sights])
    weights = 0.5 * precision / precision.sum()
    alone = [
        Hypothesis(float(one.xy[0]), float(one.xy[1]), weight)
        for one, weight in zip(sights, weights.tolist(), strict=True)
    ]
    alone.sort(key=lambda one: -one.weight)
    return (Hypothesis(x, y, 0.5, heading), *alone)
