"""From a picture to its feature vector and its phases: camera, panorama and encoders in one callable."""

from __future__ import annotations

import contextlib
import copy
import dataclasses
from dataclasses import dataclass
from functools import cached_property
from typing import Literal

import cv2
import numpy as np
from numpy.typing import NDArray

from andante.camera import Unwrapper, with_found_circle
from andante.data import CameraSpec, ImageArray
from andante.errors import BlankImageError, ConfigError, ImageError, RecordingError
from andante.features import FourierEncoder, NetworkEncoder, PhaseEncoder, PixelEncoder
from andante.mapping.config import FeatureConfig, PanoramaConfig
from andante.mapping.landmarks import LandmarkEye
from andante.protocols import Encoder, Recording
from andante.sfa import HierarchicalModel

Kind = Literal["fourier", "flat", "pixels"]
MIN_CONTRAST = 3.0
"""Standard deviation in grey levels below which a panorama shows nothing."""
_CIRCLE_FRAMES = 12


@dataclass(frozen=True, slots=True, eq=False)
class Encoded:
    """n pictures as a map sees them: ``features`` (n, d) and ``phase`` (n, p) float32.

    Phases are signatures of ``PhaseEncoder``; p is 0 for cameras that do not look all around. ``landmarks`` (n, s) are
    signatures of ``LandmarkMap``, ``None`` where nobody looks for landmarks.
    """

    features: NDArray[np.float32]
    phase: NDArray[np.float32]
    landmarks: NDArray[np.float32] | None = None


def make_encoder(
    config: FeatureConfig, shape: tuple[int, int], *, wrap: bool, network: HierarchicalModel | None = None
) -> Encoder:
    """The configured encoder for panoramas of (height, width); raises ``ConfigError`` where it lacks a ``network``."""
    height, width = shape
    kind = resolved_kind(config, heading_invariant=wrap)
    if kind == "pixels":
        if network is None:
            raise ConfigError(
                "features of kind pixels come from a network that was not learnt yet: build_map learns it, and "
                "slowmap.front_end carries it"
            )
        return NetworkEncoder(network, config.unit)
    if kind == "flat":
        return PixelEncoder(height, width, config.normalise, config.window_share, config.deviation_floor, wrap)
    values = config.model_dump(exclude={"kind"})
    # A source narrower than the configured panorama has fewer frequencies to offer.
    values["n_frequencies"] = min(config.n_frequencies, width // 2 + 1)
    return FourierEncoder(height, width, **values, wrap=wrap)


def resolved_kind(config: FeatureConfig, *, heading_invariant: bool) -> Kind:
    """The kind of features for a camera, ``auto`` decided."""
    if config.kind == "auto":
        return "fourier" if heading_invariant else "flat"
    return config.kind


def camera_of(recording: Recording) -> CameraSpec:
    """The camera of a recording, its image circle found from frames spread over it where not declared."""
    spec = recording.camera
    if spec.model != "fisheye" or (spec.centre_px is not None and spec.radius_px is not None):
        return spec
    images: list[ImageArray] = []
    step = max(1, len(recording.infos) // _CIRCLE_FRAMES)
    for info in recording.infos[::step]:
        # Whether too many pictures are missing is judged where all of them are read.
        with contextlib.suppress(ImageError):
            images.append(recording.load(info))
    return with_found_circle(spec, images)


def camera_and_size(recording: Recording) -> tuple[CameraSpec, tuple[int, int]]:
    """The camera of a recording and the (height, width) of its images; ``RecordingError`` where none can be read."""
    first = next(iter(recording.frames()), None)
    if first is None:
        raise RecordingError(f"recording {recording.name!r} has no image that can be read")
    return camera_of(recording), (first.image.shape[0], first.image.shape[1])


class FrontEnd:
    """Pictures of one camera -> panoramas and feature vectors; safe to call from many threads.

    ``image_shape`` (height, width) is the size that ``camera`` speaks of; pictures of another resolution but
    the same proportions are understood as well. Features have ``dim`` numbers in float32. Those of kind pixels need a
    learnt ``network``; without one there are only panoramas.
    """

    def __init__(
        self,
        camera: CameraSpec,
        image_shape: tuple[int, int],
        panorama: PanoramaConfig,
        features: FeatureConfig,
        network: HierarchicalModel | None = None,
    ) -> None:
        self.camera = camera
        self.image_shape = image_shape
        self.geometry = panorama.geometry(features.kind)
        self._feature_config = features
        self._unwrappers = {image_shape: Unwrapper(camera, image_shape, self.geometry)}
        self.panorama_shape = self._unwrappers[image_shape].shape
        self.network = network
        self._encoder = None if self.lacks_network else self._made_encoder()
        self._landmarks: LandmarkEye | None = None

    @property
    def feature_kind(self) -> Kind:
        """Which encoder is at work."""
        return resolved_kind(self._feature_config, heading_invariant=self.camera.heading_invariant)

    @property
    def lacks_network(self) -> bool:
        """Whether a network has to be learnt before there are features."""
        return self.feature_kind == "pixels" and self.network is None

    @property
    def encoder(self) -> Encoder:
        """What turns panoramas into features; raises ``ConfigError`` while it lacks its network."""
        return self._encoder or self._made_encoder()

    @property
    def dim(self) -> int:
        """Length of the feature vector."""
        return self.encoder.dim

    @cached_property
    def phase_encoder(self) -> PhaseEncoder | None:
        """What turns panoramas into phases; ``None`` for cameras that do not look all around."""
        if not self.camera.heading_invariant:
            return None
        # A panorama has the elevations that it was recorded with, whatever these are.
        known = self.camera.model == "fisheye"
        elevation_deg = (self.geometry.min_deg, self.geometry.max_deg) if known else None
        return PhaseEncoder(*self.panorama_shape, elevation_deg)

    @property
    def phase_dim(self) -> int:
        """Length of a phase signature, 0 where there is none."""
        return 0 if self.phase_encoder is None else self.phase_encoder.dim

    @property
    def landmark_dim(self) -> int:
        """Length of a signature of landmarks, 0 where nobody looks for any."""
        return 0 if self._landmarks is None else self._landmarks.dim

    def with_landmarks(self, eye: LandmarkEye) -> FrontEnd:
        """The same features, and what ``eye`` sees of landmarks; raises ``ConfigError`` unless this is a fisheye."""
        front_end = copy.copy(self)
        front_end._landmarks = eye.for_camera(self.camera, self.image_shape)
        return front_end

    def with_network(self, network: HierarchicalModel) -> FrontEnd:
        """The same panoramas, and the features that a network makes of them."""
        panorama = PanoramaConfig(**dataclasses.asdict(self.geometry))
        front_end = FrontEnd(self.camera, self.image_shape, panorama, self._feature_config, network)
        return front_end if self._landmarks is None else front_end.with_landmarks(self._landmarks)

    def with_camera(self, camera: CameraSpec, image_shape: tuple[int, int]) -> FrontEnd:
        """The same features from another camera; raises ``ConfigError`` where the panoramas do not match."""
        panorama = PanoramaConfig(**dataclasses.asdict(self.geometry))
        other = FrontEnd(camera, image_shape, panorama, self._feature_config, self.network)
        if _promised(other) != _promised(self):
            raise ConfigError(
                f"this map was made from {self.camera.model} images giving panoramas of {_size(self.panorama_shape)}, "
                f"the new {camera.model} camera gives {_size(other.panorama_shape)}; use a camera like the map's"
            )
        return other if self._landmarks is None else other.with_landmarks(self._landmarks)

    def for_recording(self, recording: Recording) -> FrontEnd:
        """The same features from the camera of a recording, whose image circle is found where it is not declared."""
        return self if recording.camera == self.camera else self.with_camera(*camera_and_size(recording))

    def panorama(self, image: ImageArray) -> ImageArray:
        """(height, width[, 3]) uint8 -> panorama (H, W[, 3]); raises ``ImageError`` for foreign proportions."""
        if image.ndim not in (2, 3):
            raise ImageError(f"an image is grey (height, width) or BGR (height, width, 3), got shape {image.shape}")
        return self.unwrapper((image.shape[0], image.shape[1]))(image)

    def unwrapper(self, shape: tuple[int, int]) -> Unwrapper:
        """What makes panoramas of images (height, width); raises ``ImageError`` for foreign proportions."""
        unwrapper = self._unwrappers.get(shape)
        if unwrapper is None:
            # Two threads may both make the table; either is as good, and storing it is atomic.
            unwrapper = self._unwrappers[shape] = self._scaled_unwrapper(shape)
        return unwrapper

    def grey_panorama(self, image: ImageArray) -> ImageArray:
        """What the encoder takes; raises ``BlankImageError`` for a picture that shows nothing."""
        panorama = self.panorama(image)
        if panorama.ndim == 3:
            panorama = np.asarray(cv2.cvtColor(panorama, cv2.COLOR_BGR2GRAY), dtype=np.uint8)
        contrast = float(panorama.std())
        if contrast < MIN_CONTRAST:
            raise BlankImageError(
                f"the image shows nothing: its panorama has a contrast of {contrast:.1f} grey levels, at least "
                f"{MIN_CONTRAST:g} is needed; is the lens covered?"
            )
        return panorama

    def features(self, image: ImageArray) -> NDArray[np.float32]:
        """(height, width[, 3]) uint8 -> (dim,); raises as ``grey_panorama`` does."""
        return self.encoder.encode(self.grey_panorama(image))

    def phases(self, panoramas: ImageArray) -> NDArray[np.float32]:
        """Grey panoramas (n, height, width) -> (n, phase_dim)."""
        if self.phase_encoder is None:
            return np.empty((len(panoramas), 0), dtype=np.float32)
        return self.phase_encoder.encode(panoramas)

    def encode(self, image: ImageArray) -> Encoded:
        """One picture (height, width[, 3]) uint8 -> all that a map wants of it; raises as ``grey_panorama`` does."""
        panorama = self.grey_panorama(image)[None]
        landmarks = None if self._landmarks is None else self._landmarks.signature(image)[None]
        return Encoded(self.encoder.encode(panorama), self.phases(panorama), landmarks)

    def _made_encoder(self) -> Encoder:
        wrap = self.camera.heading_invariant
        return make_encoder(self._feature_config, self.panorama_shape, wrap=wrap, network=self.network)

    def _scaled_unwrapper(self, shape: tuple[int, int]) -> Unwrapper:
        scale = shape[1] / self.image_shape[1]
        if abs(shape[0] - scale * self.image_shape[0]) > 1.0:
            raise ImageError(
                f"an image of {_size(shape)} px does not fit the camera, whose images are "
                f"{_size(self.image_shape)} px or of the same proportions"
            )
        unwrapper = Unwrapper(self.camera, shape, self.geometry, scale=scale)
        if unwrapper.shape != self.panorama_shape:
            raise ImageError(
                f"an image of {_size(shape)} px is too small: it gives a panorama of {_size(unwrapper.shape)} px, "
                f"the map needs {_size(self.panorama_shape)} px"
            )
        return unwrapper


def _promised(front_end: FrontEnd) -> tuple[object, ...]:
    """What has to be the same for two cameras to give features that can be compared."""
    camera = front_end.camera
    return camera.model, camera.heading_invariant, front_end.panorama_shape, front_end._encoder


def _size(shape: tuple[int, int]) -> str:
    return f"{shape[1]}x{shape[0]}"
