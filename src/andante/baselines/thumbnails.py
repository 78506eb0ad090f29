"""Nearest neighbours on thumbnails of the panorama under every turn: retrieval without any learning.

The pictures of SeqSLAM (Milford and Wyeth 2012), small and patch-normalised, compared as a visual compass does (Zeil et
al. 2003): a robot that turns shifts its panorama, so the best of all circular shifts tells place and heading at once.
"""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray
from scipy import fft

from andante.angles import wrapped
from andante.baselines.drives import read_drives
from andante.baselines.mapped_drives import default_front_end
from andante.baselines.method import Learned
from andante.data import Estimate, FloatArray, Hypothesis, ImageArray, PoseSource, Status
from andante.errors import BlankImageError
from andante.features.illumination import Surroundings, patch_normalised, window_px
from andante.features.phase import ComplexArray, alike_under_turns, summit
from andante.mapping import FrontEnd, Progress
from andante.protocols import Recording

Thumbnail = NDArray[np.float32]
_SHAPE = (12, 120)
_WINDOW_SHARE, _DEVIATION_FLOOR = (0.05, 0.4), 10.0
_VOTERS = 3


@dataclass(frozen=True, eq=False)
class ThumbnailNeighbours:
    """A ``StagedLocalizer`` on n thumbnails, whose spectra (n, rows, K) are kept with ``xy`` (n, 2) and headings (n,).

    The position is the mean of the three most alike, weighted by inverse distance; the heading is that of the most
    alike one and the turn from it. Panoramas of cameras that do not look all around are compared unturned.
    """

    front_end: FrontEnd = field(repr=False)
    spectra: ComplexArray = field(repr=False)
    xy: FloatArray = field(repr=False)
    heading_rad: FloatArray = field(repr=False)
    name: str = "thumbnails"

    @property
    def bytes(self) -> int:
        """Of the thumbnails in one byte a pixel, of positions and headings."""
        return len(self.xy) * _SHAPE[0] * _SHAPE[1] + self.xy.nbytes + self.heading_rad.nbytes

    def localize(self, image: ImageArray) -> Estimate:
        """Grey (height, width) or BGR (height, width, 3) uint8; lost only where the picture shows nothing."""
        return self.locate(self.prepare(image))

    def prepare(self, image: ImageArray) -> ComplexArray | BlankImageError:
        """The spectrum (1, rows, K) of a thumbnail."""
        try:
            return spectra_of(thumbnails(self.front_end.grey_panorama(image)[None]))
        except BlankImageError as error:
            return error

    def locate(self, prepared: ComplexArray | BlankImageError) -> Estimate:
        """The most alike thumbnails."""
        if isinstance(prepared, BlankImageError):
            return Estimate(Status.LOST, str(prepared))
        turns = _SHAPE[1]
        alike = alike_under_turns(prepared, self.spectra, turns)
        if not self.front_end.camera.heading_invariant:
            alike = alike[:, :1]
        peaks = alike.max(axis=1)
        best = np.argsort(-peaks)[:_VOTERS]
        # Of vectors of length one, the squared distance is 2 - 2 (what they have in common).
        weights = 1 / np.sqrt(np.maximum(2 - 2 * peaks[best], 1e-9))
        x, y = (weights @ self.xy[best] / weights.sum()).tolist()
        heading = self._heading(alike[best[0]], float(self.heading_rad[best[0]]))
        hypothesis = Hypothesis(x, y, 1.0, heading)
        return Estimate(Status.OK, "thumbnails always answer", x, y, heading, hypotheses=(hypothesis,))

    def _heading(self, curve: FloatArray, mapped_rad: float) -> float | None:
        if not np.isfinite(mapped_rad):
            return None
        at, count = int(curve.argmax()), len(curve)
        aside = 0.0
        if count > 1:
            aside = summit(*(float(curve[(at + step) % count]) for step in (-1, 0, 1)))
        return float(wrapped(mapped_rad + 2 * np.pi * (at + aside) / count))


@dataclass(frozen=True)
class ThumbnailMethod:
    """A ``Method`` that keeps every mapped frame as a thumbnail."""

    name: str = "thumbnails"

    def learn(
        self, recordings: Sequence[Recording], *, positions: PoseSource = "reference", progress: Progress | None = None
    ) -> Learned:
        """Raises ``RecordingError`` for recordings without positions, and for several with odometry alone."""
        start = time.perf_counter()
        front_end = default_front_end(recordings)
        drives = read_drives(recordings, front_end, positions, progress=progress)
        pictures = thumbnails(drives.panoramas)
        read = time.perf_counter()
        localizer = ThumbnailNeighbours(front_end, spectra_of(pictures), drives.xy, drives.heading)
        return Learned(localizer, read - start, time.perf_counter() - read, localizer.bytes)


def thumbnails(panoramas: ImageArray) -> Thumbnail:
    """Grey panoramas (n, height, width) uint8 -> (n, rows, columns), patch-normalised."""
    rows, columns = _SHAPE
    small = np.stack([cv2.resize(one, (columns, rows), interpolation=cv2.INTER_AREA) for one in panoramas])
    surroundings = Surroundings.of(small, window_px(_SHAPE, _WINDOW_SHARE), wrap=True)
    return np.asarray(patch_normalised(surroundings, _DEVIATION_FLOOR), dtype=np.float32)


def spectra_of(pictures: Thumbnail) -> ComplexArray:
    """(n, rows, columns) -> (n, rows, K): coefficients 1..K of every row, each picture of length one."""
    spectra = fft.rfft(pictures, axis=-1)[..., 1 : _SHAPE[1] // 2]
    power = np.sqrt((np.abs(spectra) ** 2).sum(axis=(1, 2), keepdims=True))
    return np.asarray(spectra / np.maximum(power, 1e-9), dtype=np.complex64)
