"""What every compared way of localizing has in common: it learns from recordings, then takes images in two steps."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeVar, runtime_checkable

from andante.data import Estimate, ImageArray, PoseSource
from andante.mapping import Progress
from andante.protocols import Localizer, Recording

Prepared = TypeVar("Prepared")


@runtime_checkable
class StagedLocalizer(Localizer, Protocol[Prepared]):
    """A localizer whose two steps can be timed apart, as in table 8.3 of the thesis.

    ``localize(image)`` is ``locate(prepare(image))``. Images are grey (height, width) uint8 of the camera that the
    method learnt from. Errors are told by the estimate: a method that cannot say where it is gives status lost.
    """

    def prepare(self, image: ImageArray) -> Prepared:
        """What does not depend on the map: unwrapping, features, key points."""
        ...

    def locate(self, prepared: Prepared) -> Estimate:
        """What was prepared -> estimate in the frame of the mapped positions."""
        ...


@dataclass(frozen=True, slots=True)
class Learned:
    """A localizer and what it cost.

    ``preprocessing_s`` are the seconds of decoding, unwrapping and features or key points of the mapped frames,
    ``mapping_s`` those of everything after it; ``bytes`` is what has to be kept for localizing. ``notes`` say what to
    keep in mind, such as how many of the frames could be reconstructed.
    """

    localizer: StagedLocalizer[Any]
    preprocessing_s: float
    mapping_s: float
    bytes: int
    notes: tuple[str, ...] = ()


@runtime_checkable
class Method(Protocol):
    """A way to learn a localizer from drives."""

    @property
    def name(self) -> str:
        """The name in tables and on the command line, such as ``posenet``."""
        ...

    def learn(
        self, recordings: Sequence[Recording], *, positions: PoseSource = "reference", progress: Progress | None = None
    ) -> Learned:
        """Learn from the frames with positions of all recordings, which one camera took.

        Raises ``MissingExtraError`` where a library is missing, ``RecordingError`` for recordings that it cannot learn
        from, ``LearningError`` where learning fails.
        """
        ...
