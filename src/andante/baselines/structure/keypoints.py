"""SIFT key points (Lowe 2004) as COLMAP finds them, placed in the picture that COLMAP is shown."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from andante.baselines.structure.library import colmap
from andante.baselines.structure.views import View
from andante.data import ImageArray


@dataclass(frozen=True, slots=True, eq=False)
class Keypoints:
    """``xy`` (k, 2) float32 in COLMAP's pixels of a view and ``descriptors`` (k, 128) uint8 (RootSIFT times 512)."""

    xy: NDArray[np.float32]
    descriptors: ImageArray

    def __len__(self) -> int:
        return len(self.xy)


@dataclass(frozen=True, slots=True)
class Sift:
    """At most the ``most`` largest key points of at least ``contrast``, which is COLMAP's own."""

    most: int = 4096
    contrast: float = 0.02 / 3

    def keypoints(self, view: View, image: ImageArray) -> Keypoints:
        """Of a grey picture (height, width); safe to call from many threads."""
        library = colmap()
        options = library.FeatureExtractionOptions(num_threads=1, use_gpu=False)
        options.sift.max_num_features, options.sift.peak_threshold = self.most, self.contrast
        extractor = library.FeatureExtractor.create(options, library.Device.cpu)
        found, descriptors = extractor.extract(library.Bitmap.from_array(view.picture(image)))
        # COLMAP has pixel centres at halves, Andante at whole numbers.
        places = np.asarray(library.keypoints_to_matrix(found), np.float64).reshape(-1, 4)[:, :2] - 0.5
        moved, kept = view.points(places)
        return Keypoints(moved[kept].astype(np.float32), np.asarray(descriptors.data, np.uint8).reshape(-1, 128)[kept])
