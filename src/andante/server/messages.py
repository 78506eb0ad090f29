"""What the page may say: every request's body, checked before anything else sees it."""

from __future__ import annotations

import math
from typing import Annotated, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from andante.angles import wrapped
from andante.landmarks.tracks import Chosen

MAX_BODY_BYTES = 64 * 1024
_Number = Annotated[float, Field(strict=True, allow_inf_nan=False)]
MOST_FRAMES = 10**9
_Frame = Annotated[int, Field(strict=True, ge=0, lt=MOST_FRAMES)]


class _Message(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class Search(_Message):
    """Look for one kind of anchor; of several the one nearest to an azimuth in a frame."""

    anchor: Annotated[str, Field(min_length=1, max_length=60)]
    frame: _Frame | None = None
    azimuth_deg: Annotated[_Number, Field(ge=-360, le=360)] | None = None

    @model_validator(mode="after")
    def _both_or_none(self) -> Self:
        if (self.frame is None) != (self.azimuth_deg is None):
            raise ValueError("one of several is told by a frame and an azimuth_deg, by both")
        return self

    def chosen(self) -> Chosen | None:
        """Which one, where it is told."""
        if self.frame is None or self.azimuth_deg is None:
            return None
        return Chosen(self.frame, wrapped(math.radians(self.azimuth_deg)))


class Draw(_Message):
    """A landmark, in units of the anchor's box, as ``andante.landmarks.teaching.Relation``."""

    name: Annotated[str, Field(max_length=200)]
    right: _Number
    up: _Number
    width: _Number
    height: _Number


class Remove(_Message):
    """Forget a landmark."""

    name: Annotated[str, Field(max_length=200)]


class LeftOut(_Message):
    """Frames of one landmark that the person does not approve."""

    landmark: Annotated[str, Field(max_length=200)]
    frames: Annotated[tuple[_Frame, ...], Field(max_length=5000)]


class Save(_Message):
    """Write the labels of everything that was taught."""

    left_out: Annotated[tuple[LeftOut, ...], Field(max_length=100)] = ()

    @model_validator(mode="after")
    def _each_once(self) -> Self:
        if len({one.landmark for one in self.left_out}) < len(self.left_out):
            raise ValueError("left_out names a landmark twice")
        return self
