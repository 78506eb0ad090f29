"""How a map of gazes is made; every field has a default, unknown keys are errors."""

from __future__ import annotations

from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field

from andante.mapping.config import PanoramaConfig

Share = Annotated[float, Field(gt=0, lt=1)]


class GazeConfig(BaseModel):
    """What is learnt of patches, and how they vote.

    ``regions`` all around are learnt of every frame; a patch is ``width_deg`` wide. Frames at most ``place_radius_m``
    apart are of one place. ``representation`` is slow, or principal for the components that slow features are made of,
    an honest neighbour. Gazes are followed over ``strides`` frames and step to the neighbouring region by edges of
    ``step_weight``. ``patches`` evenly spaced ones are looked at in an image where nothing else is asked for.
    ``coverage`` is the share of held-out frames within the radius that estimates promise.
    """

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    panorama: PanoramaConfig = PanoramaConfig()
    positions: Literal["reference", "odometry"] = "reference"
    regions: Annotated[int, Field(ge=8, le=120)] = 72
    width_deg: Annotated[float, Field(gt=0, le=360)] = 48.0
    cell_deg: Annotated[float, Field(gt=0, le=360)] = 4.0
    place_radius_m: Annotated[float, Field(gt=0)] = 0.35
    representation: Literal["slow", "principal"] = "slow"
    principal_components: Annotated[int, Field(ge=1)] = 150
    slow_features: Annotated[int, Field(ge=1)] = 80
    strides: tuple[Annotated[int, Field(ge=1)], ...] = (1, 10, 30, 100)
    step_weight: Annotated[float, Field(ge=0)] = 0.3
    ridge: Annotated[float, Field(ge=0)] = 0.01
    edge_ridge: Annotated[float, Field(ge=0)] = 0.0
    max_frames: Annotated[int, Field(ge=8)] = 1000
    sharpness: Annotated[float, Field(gt=0)] = 5.0
    outlier_share: Share = 0.01
    consensus_m: Annotated[float, Field(gt=0)] = 0.8
    patches: Annotated[int, Field(ge=1, le=360)] = 24
    coverage: Share = 0.9
