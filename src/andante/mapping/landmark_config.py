"""How landmarks are learnt and fused, as frozen values: every field has a default, unknown keys are errors."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from andante.landmarks.views import ViewWindow
from andante.mapping.config import Count, ReadoutConfig

_Degrees = Annotated[float, Field(ge=-90, le=90)]


class LandmarkConfig(BaseModel):
    """What is cut out around landmarks, what is learnt of it, and how several are fused.

    Views hang on the horizon, from ``low_deg`` to ``high_deg``, ``width_deg`` wide around the middle of a box: wider
    than most landmarks, so that they show it with its surroundings, which a single one needs to tell places apart.
    ``window_share`` is the part of a view whose own brightness and contrast are taken out, besides those of the whole.
    ``edge_ridge`` and ``invariance`` are those of ``LearningConfig``.

    ``fusion``: by calibrated covariance and geometry, or by inverse error as in thesis 7.3.3.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    width_deg: Annotated[float, Field(gt=0, le=360)] = 60.0
    low_deg: _Degrees = 0.0
    high_deg: _Degrees = 40.0
    width_px: Annotated[int, Field(ge=8, le=512)] = 96
    height_px: Annotated[int, Field(ge=8, le=512)] = 48
    window_share: Annotated[float, Field(ge=0, le=1)] = 0.4
    pca_components: Count = 200
    slow_features: Count = 32
    edge_ridge: Annotated[float, Field(ge=0)] = 1.0
    invariance: Annotated[float, Field(ge=0)] = 1.0
    readout: ReadoutConfig = ReadoutConfig(caution=10.0)
    fusion: Literal["covariance", "inverse-error"] = "covariance"
    coverage: Annotated[float, Field(gt=0, lt=1)] = 0.9
    folds: Annotated[int, Field(ge=2, le=20)] = 5
    seed: Annotated[int, Field(ge=0)] = 0

    @property
    def window(self) -> ViewWindow:
        """What is cut out around every landmark."""
        low, high, width = np.radians([self.low_deg, self.high_deg, self.width_deg]).tolist()
        return ViewWindow(width, low, high, self.width_px, self.height_px)
