"""What a trained PoseNet does with a picture."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
import torch

from andante.baselines.posenet.network import PoseNetwork
from andante.baselines.posenet.pictures import evened
from andante.data import Estimate, FloatArray, Hypothesis, ImageArray, Status
from andante.errors import BlankImageError
from andante.features.illumination import Float32Array
from andante.mapping import FrontEnd


@dataclass(frozen=True)
class PoseNetLocalizer:
    """A ``StagedLocalizer`` that always answers: a regression knows no doubt.

    The network's unit of length is ``scale_m`` metres from ``centre`` (2,); ``heading_known`` is whether it was taught
    any headings.
    """

    front_end: FrontEnd = field(repr=False)
    network: PoseNetwork = field(repr=False)
    centre: FloatArray
    scale_m: float
    heading_known: bool

    @property
    def name(self) -> str:
        """The name in tables."""
        return "posenet"

    def prepare(self, image: ImageArray) -> Float32Array | BlankImageError:
        """Grey (h, w) or BGR (h, w, 3) uint8 -> (height, width) of the network, or why there is nothing to see."""
        try:
            panorama = self.front_end.grey_panorama(image)
        except BlankImageError as error:
            return error
        prepared: Float32Array = evened(panorama[None], wrap=self.front_end.camera.heading_invariant)[0]
        return prepared

    def locate(self, prepared: Float32Array | BlankImageError) -> Estimate:
        """Ok with a pose; lost only where the picture shows nothing."""
        if isinstance(prepared, BlankImageError):
            return Estimate(Status.LOST, str(prepared))
        with torch.inference_mode():
            position, direction = self.network(torch.from_numpy(np.ascontiguousarray(prepared))[None, None])
        x, y = (self.scale_m * position[0].double().numpy() + self.centre).tolist()
        heading = float(torch.atan2(direction[0, 1], direction[0, 0])) if self.heading_known else None
        return Estimate(
            Status.OK, f"{self.name} always answers", x, y, heading, hypotheses=(Hypothesis(x, y, 1.0, heading),)
        )

    def localize(self, image: ImageArray) -> Estimate:
        """Both steps at once; raises ``ImageError`` for pictures of foreign proportions."""
        return self.locate(self.prepare(image))
